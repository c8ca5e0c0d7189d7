#include "reports/page/study_page.h"

#include <utility>

#include "reports/charts/study_chart.h"
#include "reports/page/blocks.h"
#include "reports/page/page_files.h"
#include "reports/page/page_frame.h"

namespace crowdbench::reports {
namespace {

std::vector<TemplateValues> text_rows(const std::vector<std::string>& texts) {
  std::vector<TemplateValues> out;
  for (const std::string& text : texts) out.push_back({{"text", text}});
  return out;
}

// None or one, for a place that may stay away.
std::vector<TemplateValues> text_if_any(const std::string& text) {
  return text.empty() ? std::vector<TemplateValues>{} : text_rows({text});
}
std::vector<TemplateValues> list_if_any(const std::vector<std::string>& texts) {
  std::vector<TemplateValues> out;
  if (!texts.empty()) out.push_back({{"items", text_rows(texts)}});
  return out;
}

std::vector<TemplateValues> heads_of(const StudyTable& table) {
  std::vector<TemplateValues> out;
  for (size_t i = 0; i < table.columns.size(); ++i)
    out.push_back({{"class", i < table.words ? "l" : "n"}, {"text", table.columns[i]}});
  return out;
}

// Beside each cell stands its column's head, where the table is too wide for the screen.
std::vector<TemplateValues> cells_of(const std::vector<std::string>& row, const StudyTable& table) {
  std::vector<TemplateValues> out;
  for (size_t i = 0; i < row.size(); ++i)
    out.push_back({{"class", i < table.words ? "l" : "n"},
                   {"of", i < table.columns.size() ? table.columns[i] : ""},
                   {"text", row[i]}});
  return out;
}

std::vector<TemplateValues> table_of(const StudyTable& table) {
  std::vector<TemplateValues> out;
  if (table.columns.empty()) return out;
  std::vector<TemplateValues> rows;
  for (const auto& row : table.rows) rows.push_back({{"cells", cells_of(row, table)}});
  out.push_back({{"columns", heads_of(table)}, {"rows", std::move(rows)}});
  return out;
}

std::pair<std::string, std::string> chart_of(const StudyTask& task, StudyChart chart) {
  switch (chart) {
    case StudyChart::shares: return {study_shares_chart(task), "Answers by condition"};
    case StudyChart::curves:
      return {study_curves_chart(task), "Share of yes by " + task.axis + ", with the fitted functions"};
    case StudyChart::ranking:
      return {study_rows_chart(task.ranking, "just-objectionable differences"), "Items on one scale"};
    case StudyChart::prediction: return {study_rows_chart(task.prediction, "AUC"), "Scores against the answers"};
    case StudyChart::none: break;
  }
  return {};
}

TemplateValues section_of(const StudyTask& task, const StudySection& section, int& last_chart) {
  std::vector<Html> charts;
  if (const auto [chart, title] = chart_of(task, section.chart); !chart.empty())
    charts.push_back(chart_block(chart, title, ++last_chart));
  return {
      {"heading", section.heading},       {"lead", text_if_any(section.lead)}, {"charts", html_rows(std::move(charts))},
      {"table", table_of(section.table)}, {"list", list_if_any(section.list)}, {"note", text_if_any(section.note)}};
}

}  // namespace

std::string study_page(const StudyPageModel& model) {
  int last_chart = 0;
  std::vector<TemplateValues> tasks;
  for (const StudyTask& task : model.tasks) {
    std::vector<TemplateValues> sections;
    for (const StudySection& section : task.sections) sections.push_back(section_of(task, section, last_chart));
    tasks.push_back({{"name", task.name}, {"verdicts", list_if_any(task.verdicts)}, {"sections", std::move(sections)}});
  }
  std::vector<TemplateValues> planned = list_if_any(model.planned ? model.standing : std::vector<std::string>{});
  std::vector<TemplateValues> not_planned;
  if (!model.planned && !model.standing.empty())
    not_planned.push_back({{"title", model.standing_title}, {"items", text_rows(model.standing)}});
  Html content = fill_template(page_file("study_page.html"), {{"planned", std::move(planned)},
                                                              {"not_planned", std::move(not_planned)},
                                                              {"lead", text_rows(model.lead)},
                                                              {"tasks", std::move(tasks)}});
  return page_frame(model.title, std::move(content), model.source);
}

}  // namespace crowdbench::reports
