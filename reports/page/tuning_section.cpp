#include "reports/page/tuning_section.h"

#include <fmt/format.h>

#include "reports/model/tuning_text.h"
#include "reports/page/page_files.h"

namespace crowdbench::reports {
namespace {

using Rows = std::vector<TemplateValues>;

TemplateValues rule_values(const StoreContents& contents, const TuningRow& row, const std::vector<ScoreDoc>& scores) {
  Rows sentences;
  for (std::string& text : tuning_sentences(row, scores)) sentences.push_back({{"text", std::move(text)}});
  const ScoreDoc pop = doc_of(scores, row.pop_score);
  Rows switches;
  for (const TunedSwitchRow& one : row.switches)
    switches.push_back(
        {{"to", one.to},
         {"from", one.from},
         {"height", fmt::format("{:.1f}", one.height_px)},
         {"depth", fmt::format("{:.1f}", one.depth)},
         {"sure", certainty_text(one)},
         {"texel", one.pixels_per_texel ? fmt::format("{:.2f}", *one.pixels_per_texel) : std::string("–")},
         {"error", one.pixels_per_error ? fmt::format("{:.2f}", *one.pixels_per_error) : std::string("–")},
         {"hysteresis", fmt::format("{:.1f} %", 100 * one.hysteresis)},
         {"pop", one.pop ? pop.title + " " + score_text(pop, *one.pop) : std::string("–")}});
  Rows table;
  if (!switches.empty()) table.push_back({{"switches", std::move(switches)}});
  Rows draws;
  if (row.representation) draws.push_back({{"text", *row.representation}});
  const auto source = contents.sources.find(row.run);
  return {
      {"character", row.character},        {"source", source == contents.sources.end() ? "" : ", " + source->second},
      {"sentences", std::move(sentences)}, {"table", std::move(table)},
      {"draws", std::move(draws)},         {"display", row.display}};
}

}  // namespace

Html tuning_section(const StoreContents& contents, const std::vector<ScoreDoc>& scores) {
  if (contents.tunings.empty()) return {};
  Rows rules;
  for (const TuningRow& row : contents.tunings) rules.push_back(rule_values(contents, row, scores));
  return fill_template(page_file("tuning.html"), {{"rules", std::move(rules)}});
}

}  // namespace crowdbench::reports
