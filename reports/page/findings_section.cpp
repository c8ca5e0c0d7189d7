#include "reports/page/findings_section.h"

#include <fmt/format.h>

#include <algorithm>

#include "reports/model/findings.h"
#include "reports/model/number_text.h"
#include "reports/page/page_files.h"

namespace crowdbench::reports {
namespace {

using Rows = std::vector<TemplateValues>;

constexpr size_t kMostPops = 20;

Rows pop_rows(const PopList& list, const std::vector<ScoreDoc>& docs) {
  Rows rows;
  for (const PopRow* pop : list.worst) {
    Rows cells;
    for (const ScoreDoc& doc : docs) {
      const auto value = score_of(*pop, doc.name);
      cells.push_back({{"value", value ? score_text(doc, *value) : "–"}});
    }
    rows.push_back({{"tick", pop->tick},
                    {"agent", pop->agent},
                    {"from", pop->from},
                    {"to", pop->to},
                    {"frames", fmt::format("{}{}", pop->frames, pop->complete ? "" : "+")},
                    {"distance", fmt::format("{:.2f}", pop->distance)},
                    {"pixels", count_text(pop->pixels)},
                    {"cells", std::move(cells)}});
  }
  return rows;
}

}  // namespace

Html findings_section(const StoreContents& contents, const std::vector<ScoreDoc>& pop_scores) {
  Rows paragraphs;
  for (const RunRow& run : contents.runs) {
    for (std::string& text : cause_sentences(contents, run.id)) paragraphs.push_back({{"text", std::move(text)}});
    for (std::string& text : pop_sentences(contents, run.id, pop_scores))
      paragraphs.push_back({{"text", std::move(text)}});
  }
  if (paragraphs.empty()) return {};
  return fill_template(page_file("findings.html"), {{"paragraphs", std::move(paragraphs)}});
}

Html causes_section(const StoreContents& contents, int64_t run) {
  const CauseTable table = cause_table(contents, run);
  if (table.rows.empty()) return {};
  Rows titles;
  for (const std::string& title : table.titles) titles.push_back({{"title", title}});
  Rows rows;
  for (const CauseTableRow& row : table.rows) {
    Rows shares;
    for (const std::string& share : row.shares) shares.push_back({{"share", share}});
    rows.push_back({{"representation", row.range->representation},
                    {"height", height_range_text(*row.range)},
                    {"count", count_text(row.range->units)},
                    {"shares", std::move(shares)},
                    {"dominant", row.range->words.substr(row.range->words.find(": ") + 2)}});
  }
  return fill_template(page_file("causes.html"),
                       {{"units", table.rows.front().range->unit == "view" ? "Views" : "Agents"},
                        {"titles", std::move(titles)},
                        {"rows", std::move(rows)}});
}

Html pops_section(const StoreContents& contents, const RunRow& run, const std::vector<ScoreDoc>& pop_scores) {
  const std::vector<PopList> lists = pop_lists(contents, run.id, pop_scores, kMostPops);
  if (lists.empty()) return {};
  const auto first =
      std::find_if(contents.pops.begin(), contents.pops.end(), [&](const PopRow& row) { return row.run == run.id; });
  Rows titles;
  for (const ScoreDoc& doc : pop_scores) titles.push_back({{"title", heading(doc)}});
  Rows shown;
  for (const PopList& list : lists) {
    Rows table;
    if (!list.worst.empty())
      table.push_back(
          {{"shown", count_text(list.worst.size())}, {"scores", titles}, {"rows", pop_rows(list, pop_scores)}});
    shown.push_back({{"representation", list.representation},
                     {"switches", count_text(list.switches)},
                     {"seen", count_text(list.seen)},
                     {"table", std::move(table)}});
  }
  return fill_template(page_file("pops.html"), {{"character", first->character},
                                                {"scenario", run.scenario_name},
                                                {"display", first->display},
                                                {"run", run.id},
                                                {"lists", std::move(shown)}});
}

}  // namespace crowdbench::reports
