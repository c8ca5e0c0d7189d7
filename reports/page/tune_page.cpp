#include "reports/page/tune_page.h"

#include <algorithm>

#include "reports/charts/charts.h"
#include "reports/charts/tune_chart.h"
#include "reports/page/blocks.h"
#include "reports/page/escape.h"
#include "reports/page/page_files.h"
#include "reports/page/page_frame.h"

namespace crowdbench::reports {
namespace {

using Rows = std::vector<TemplateValues>;

Rows texts(const std::vector<std::string>& lines) {
  Rows rows;
  for (const std::string& line : lines) rows.push_back({{"text", line}});
  return rows;
}

// One row where there is something to show, which then has these values; no row otherwise.
Rows once(bool there, TemplateValues values) {
  Rows rows;
  if (there) rows.push_back(std::move(values));
  return rows;
}

// Cells by the letters a, b, ...
Rows lettered(const std::vector<std::vector<std::string>>& table) {
  Rows rows;
  for (const std::vector<std::string>& cells : table) {
    TemplateValues values;
    for (size_t i = 0; i < cells.size(); ++i) values[std::string(1, static_cast<char>('a' + i))] = cells[i];
    rows.push_back(std::move(values));
  }
  return rows;
}

Rows switches_of(const TunePage& page) {
  Rows rows;
  for (const TunePageSwitch& one : page.switches)
    rows.push_back({{"from", one.from},
                    {"to", one.to},
                    {"height", one.height},
                    {"height_interval", one.height_interval},
                    {"next", one.next},
                    {"depth", one.depth},
                    {"depth_interval", one.depth_interval},
                    {"ratio", one.ratio},
                    {"hysteresis", one.hysteresis},
                    {"pop", one.pop},
                    {"sure", one.sure}});
  return rows;
}

Html figure_of(const TunePagePicture& picture) {
  return figure_block(picture.width, picture.height, picture.png, picture.caption, Html{html_escape(picture.caption)});
}

Rows pictures_of(const TunePage& page) {
  Rows switches;
  for (const TunePagePictures& one : page.pictures) {
    std::vector<Html> figures;
    for (const TunePagePicture& picture : one.pictures) figures.push_back(figure_of(picture));
    switches.push_back({{"title", one.title}, {"figures", html_rows(std::move(figures))}});
  }
  const bool there = !switches.empty();
  return once(there, {{"switches", std::move(switches)},
                      {"scale", page.picture_scale},
                      {"bar", there ? figure_of(page.picture_bar) : Html{}}});
}

Rows heights_of(const TunePageCharacter& character) {
  Rows rows;
  for (size_t r = 0; r < character.rows.size(); ++r) {
    Rows cells;
    const std::vector<std::string>& row = character.rows[r];
    for (size_t i = 0; i < row.size(); ++i) {
      const bool chosen = i >= 3 && r < character.chosen.size() && (i - 3) / 2 == character.chosen[r];
      cells.push_back({{"text", row[i]}, {"chosen", chosen}});
    }
    rows.push_back({{"cells", std::move(cells)}});
  }
  return rows;
}

TemplateValues character_of(const TunePageCharacter& character, int& last_chart) {
  const TuneGraph& graph = character.graph;
  Rows marks;
  Rows columns;
  const std::vector<std::string> colours = representation_colours(graph.curves.size());
  for (size_t i = 0; i < graph.curves.size(); ++i) {
    const std::string& name = graph.curves[i].representation;
    marks.push_back(
        {{"mark", fill_template(page_file("mark.html"), {{"colour", colours[i]}, {"representation", name}})}});
    columns.push_back({{"name", name}, {"score", graph.doc.title}});
  }
  std::vector<Html> charts;
  if (const std::string chart = tune_error_chart(graph); !chart.empty())
    charts.push_back(chart_block(chart, heading(graph.doc) + ": the worst 5 % of the figures", ++last_chart));
  if (const std::string chart = tune_cost_chart(graph); !chart.empty())
    charts.push_back(chart_block(chart, "Time of one more agent", ++last_chart));
  return {{"name", character.name},        {"measured", character.measured},         {"alone", texts(character.alone)},
          {"marks", std::move(marks)},     {"charts", html_rows(std::move(charts))}, {"columns", std::move(columns)},
          {"rows", heights_of(character)}, {"notes", texts(character.notes)}};
}

Rows rules_of(const TunePage& page) {
  Rows rows;
  for (const TunePageRule& one : page.rules)
    rows.push_back({{"to", one.to},
                    {"measured_height", one.measured_height},
                    {"measured_depth", one.measured_depth},
                    {"rule", one.rule},
                    {"height", one.height},
                    {"depth", one.depth},
                    {"shown", one.shown},
                    {"verdict", one.verdict},
                    {"cost", one.cost}});
  return once(!page.rules.empty(), {{"rows", std::move(rows)}});
}

Rows engines_of(const TunePage& page) {
  Rows rows;
  for (const TunePageEngines& one : page.engines)
    rows.push_back({{"to", one.to},
                    {"metres", one.metres},
                    {"unity", one.unity},
                    {"unreal", one.unreal},
                    {"godot", one.godot},
                    {"godot_pixels", one.godot_pixels}});
  return once(!page.engines.empty(), {{"rows", std::move(rows)}, {"notes", texts(page.engine_notes)}});
}

}  // namespace

std::string tune_page(const TunePage& page) {
  int last_chart = 0;
  Rows characters;
  for (const TunePageCharacter& one : page.characters) characters.push_back(character_of(one, last_chart));
  Rows facts;
  for (const auto& [title, value] : page.facts) facts.push_back({{"title", title}, {"value", value}});
  Html content = fill_template(
      page_file("tune_page.html"),
      {{"under", page.under},
       {"broken", texts(page.broken)},
       {"answer", texts(page.answer)},
       {"software", page.software},
       {"rule", once(!page.switches.empty(), {{"switches", switches_of(page)}})},
       {"draws_as", once(!page.draws_as.empty(), {{"text", page.draws_as}})},
       {"shown", pictures_of(page)},
       {"characters", std::move(characters)},
       {"predicted", rules_of(page)},
       {"engines", engines_of(page)},
       {"lenses",
        once(!page.lens_verdict.empty(),
             {{"verdict", page.lens_verdict}, {"lines", texts(page.lens_lines)}, {"rows", lettered(page.lenses)}})},
       {"proof", once(!page.proof_lines.empty(), {{"lines", texts(page.proof_lines)}, {"rows", lettered(page.seeds)}})},
       {"facts", std::move(facts)}});
  return page_frame(page.title, std::move(content), "");
}

}  // namespace crowdbench::reports
