#include "reports/model/findings.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "reports/model/number_text.h"

namespace crowdbench::reports {
namespace {

// Representations in the order in which their rows come.
template <typename Row>
std::vector<std::string> representations_of(const std::vector<Row>& rows, int64_t run) {
  std::vector<std::string> names;
  for (const Row& row : rows)
    if (row.run == run && std::find(names.begin(), names.end(), row.representation) == names.end())
      names.push_back(row.representation);
  return names;
}

// Never "-0 %".
std::string percent_of(double share) { return fmt::format("{} %", std::lround(100 * share)); }

std::string values_text(const PopRow& pop, const std::vector<ScoreDoc>& docs) {
  std::vector<std::string> texts;
  for (const ScoreDoc& doc : docs)
    if (const auto value = score_of(pop, doc.name); value && doc.headline)
      texts.push_back(fmt::format("{} {}{}{}{}", doc.title, score_text(doc, *value), doc.unit.empty() ? "" : " ",
                                  doc.unit, best_text(doc)));
  return fmt::format("{}", fmt::join(texts, "; "));
}

}  // namespace

std::vector<std::string> cause_sentences(const StoreContents& contents, int64_t run) {
  std::vector<std::string> out;
  for (const std::string& name : representations_of(contents.cause_ranges, run)) {
    std::vector<std::string> words;
    const CauseRangeRow* first = nullptr;
    for (const CauseRangeRow& row : contents.cause_ranges) {
      if (row.run != run || row.representation != name) continue;
      if (first == nullptr) first = &row;
      words.push_back(row.words);
    }
    out.push_back(fmt::format("{} against {}, {} of {}: the error is dominated by: {}.", name, first->reference,
                              first->unit == "view" ? "views of one agent" : "agents of a crowd", first->character,
                              fmt::join(words, "; ")));
  }
  return out;
}

CauseTable cause_table(const StoreContents& contents, int64_t run) {
  CauseTable table;
  for (const CauseRangeRow& row : contents.cause_ranges)
    for (const CauseShareRow& share : row.shares)
      if (row.run == run && std::find(table.titles.begin(), table.titles.end(), share.title) == table.titles.end())
        table.titles.push_back(share.title);
  for (const CauseRangeRow& row : contents.cause_ranges) {
    if (row.run != run) continue;
    CauseTableRow& out = table.rows.emplace_back(CauseTableRow{&row, {}});
    for (const std::string& title : table.titles) {
      const auto share =
          std::find_if(row.shares.begin(), row.shares.end(), [&](const auto& s) { return s.title == title; });
      out.shares.push_back(share == row.shares.end() ? "–" : percent_of(share->share));
    }
    out.shares.push_back(percent_of(row.residue));
  }
  if (!table.rows.empty()) table.titles.emplace_back("no cause");
  return table;
}

std::string height_range_text(const CauseRangeRow& range) {
  if (!range.below) return fmt::format("{:g} and more", range.from);
  if (range.from == 0) return fmt::format("below {:g}", *range.below);
  return fmt::format("{:g} to {:g}", range.from, *range.below);
}

std::optional<double> score_of(const PopRow& pop, const std::string& name) {
  for (const PopScoreRow& score : pop.scores)
    if (score.name == name) return score.value;
  return std::nullopt;
}

std::vector<PopList> pop_lists(const StoreContents& contents, int64_t run, const std::vector<ScoreDoc>& docs,
                               size_t most) {
  std::vector<PopList> out;
  for (const std::string& name : representations_of(contents.pops, run)) {
    PopList list{name, {}, 0, 0, {}};
    for (const PopRow& row : contents.pops) {
      if (row.run != run || row.representation != name) continue;
      list.display = row.display;
      ++list.switches;
      if (row.pixels == 0) continue;
      ++list.seen;
      list.worst.push_back(&row);
    }
    if (!docs.empty())
      std::stable_sort(list.worst.begin(), list.worst.end(), [&](const PopRow* a, const PopRow* b) {
        const auto left = score_of(*a, docs[0].name);
        const auto right = score_of(*b, docs[0].name);
        if (!left || !right) return left.has_value() && !right.has_value();
        return docs[0].higher_is_better ? *left < *right : *left > *right;
      });
    if (list.worst.size() > most) list.worst.resize(most);
    out.push_back(std::move(list));
  }
  return out;
}

std::vector<std::string> pop_sentences(const StoreContents& contents, int64_t run, const std::vector<ScoreDoc>& docs) {
  std::vector<std::string> out;
  for (const PopList& list : pop_lists(contents, run, docs, 1)) {
    std::set<uint32_t> agents;
    for (const PopRow& row : contents.pops)
      if (row.run == run && row.representation == list.representation) agents.insert(row.agent);
    std::string text =
        fmt::format("{}: {} switch{} of {}, {} of them seen.", list.representation, count_text(list.switches),
                    list.switches == 1 ? "" : "es", agents_text(agents.size()), count_text(list.seen));
    if (!list.worst.empty()) {
      const PopRow& worst = *list.worst.front();
      text += fmt::format(" The most visible: agent {} at tick {}, {:.3g} m away, from {} to {}: {}.", worst.agent,
                          worst.tick, worst.distance, worst.from, worst.to, values_text(worst, docs));
    }
    out.push_back(std::move(text));
  }
  return out;
}

}  // namespace crowdbench::reports
