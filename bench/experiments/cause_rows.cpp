#include "bench/experiments/cause_rows.h"

#include <cmath>

namespace crowdbench::bench {

std::vector<CauseRangeRow> cause_rows(int64_t run, const CauseSubject& subject, std::span<const CauseRange> ranges,
                                      const std::string& unit) {
  std::vector<CauseRangeRow> rows;
  for (size_t i = 0; i < ranges.size(); ++i) {
    const CauseRange& range = ranges[i];
    CauseRangeRow& row = rows.emplace_back();
    row.run = run;
    row.representation = subject.representation;
    row.reference = subject.reference;
    row.character = subject.character;
    row.unit = unit;
    row.from = range.from;
    if (std::isfinite(range.below)) row.below = range.below;
    row.units = range.units;
    row.total = static_cast<uint64_t>(range.total);
    row.residue = range.residue;
    if (range.dominant) {
      row.dominant = metrics::doc_of(*range.dominant).name;
      row.share_low = range.share.low;
      row.share_high = range.share.high;
    }
    row.words = cause_range_words(ranges, i, unit);
    for (const metrics::CauseDoc& doc : metrics::causes())
      if (const double share = range.shares[static_cast<size_t>(doc.cause)]; share != 0)
        row.shares.push_back({std::string(doc.name), std::string(doc.title), share});
  }
  return rows;
}

std::vector<PopRow> pop_rows(int64_t run, const std::string& representation, const std::string& character,
                             const std::string& display, const PoppingResult& result) {
  const auto scores = metrics::pop_scores();
  std::vector<PopRow> rows;
  for (const Switch& of : result.switches) {
    PopRow& row = rows.emplace_back();
    row.run = run;
    row.representation = representation;
    row.character = character;
    row.from = result.components[of.from];
    row.to = result.components[of.to];
    row.agent = of.id - 1;
    row.tick = of.tick;
    row.frames = of.steps;
    row.complete = of.complete;
    row.distance = of.distance;
    row.pixels = of.pixels;
    row.worst_tick = of.worst_tick;
    row.display = display;
    for (size_t s = 0; s < scores.size(); ++s)
      row.scores.push_back({std::string(scores[s].name), of.pixels > 0 ? of.values[s] : std::nullopt});
  }
  return rows;
}

}  // namespace crowdbench::bench
