#include "reports/page/pop_page.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "reports/charts/charts.h"
#include "reports/model/number_text.h"
#include "reports/page/blocks.h"
#include "reports/page/escape.h"
#include "reports/page/page_files.h"
#include "reports/page/page_frame.h"

namespace crowdbench::reports {
namespace {

using Rows = std::vector<TemplateValues>;

std::string at_text(const PopPoint& point) {
  return fmt::format("azimuth {:g}°, elevation {:g}°, phase {:g}", point.azimuth_deg, point.elevation_deg, point.phase);
}

Rows figures(const std::vector<PopPicture>& pictures) {
  std::vector<Html> blocks;
  for (const PopPicture& picture : pictures)
    blocks.push_back(
        figure_block(picture.width, picture.height, picture.png, picture.caption, Html{html_escape(picture.caption)}));
  return html_rows(std::move(blocks));
}

Rows titles(const PopPage& page) {
  Rows rows;
  for (const ScoreDoc& doc : page.scores)
    rows.push_back({{"title", heading(doc)}, {"tail", doc.higher_is_better ? "5th percentile" : "95th percentile"}});
  return rows;
}

Rows kinds(const PopPage& page, const PopSize& size) {
  Rows rows;
  for (size_t w = 0; w < kPopSwitchKinds; ++w) {
    Rows cells;
    for (size_t i = 0; i < page.scores.size(); ++i) {
      const ScoreDoc& doc = page.scores[i];
      Rows summary;
      if (const auto& s = size.summaries[i][w])
        summary.push_back({{"mean", score_text(doc, s->mean)},
                           {"tail", score_text(doc, s->tail)},
                           {"worst", score_text(doc, s->worst)}});
      cells.push_back({{"summary", std::move(summary)}});
    }
    const auto& ranked = size.summaries[page.ranking][w];
    rows.push_back({{"kind", kPopSwitchTitles[w]},
                    {"cells", std::move(cells)},
                    {"worst_at", ranked ? at_text(ranked->worst_at) : "nothing is drawn"}});
  }
  return rows;
}

// What the numbers say, in a sentence each.
std::vector<std::string> answer(const PopPage& page) {
  const ScoreDoc& doc = page.scores[page.ranking];
  const auto text = [&](double value) { return score_text(doc, value); };
  std::vector<std::string> out;
  for (const PopSize& size : page.sizes) {
    const auto& [cut, fade, matched, both] = size.summaries[page.ranking];
    if (!cut || !fade || !matched || !both) continue;
    out.push_back(fmt::format(
        "{}: between the pictures before and after a switch the {} is {}{}{} on average and {} at worst. With the mesh "
        "in the stored frame's pose it is {}, with a cross-fade of {} ticks {} a step, with both {}.",
        pop_size_text(size.points.front()), doc.title, text(cut->mean), doc.unit.empty() ? "" : " ", doc.unit,
        text(cut->worst), text(matched->mean), page.fade, text(fade->mean), text(both->mean)));
  }
  return out;
}

// The largest value of a chart, so that all charts of a page share one scale.
double chart_top(const PopPage& page) {
  double top = 0;
  for (const PopSize& size : page.sizes)
    for (const PopPoint& point : size.points)
      for (const auto& value : point.scores[page.ranking])
        if (value && std::isfinite(*value)) top = std::max(top, *value);
  return top > 0 ? std::ceil(top) : 1;
}

TemplateValues size_values(const PopPage& page, const PopSize& size, double top, int& last_chart) {
  std::vector<Html> charts;
  if (const std::string chart = pop_chart(size, page.scores, page.ranking, top); !chart.empty())
    charts.push_back(chart_block(chart, heading(page.scores[page.ranking]) + ", by view, clip phase and kind of switch",
                                 ++last_chart));
  const auto& ranked = size.summaries[page.ranking][0];
  Rows worst;
  if (!size.worst.empty())
    worst.push_back({{"at", ranked ? at_text(ranked->worst_at) : ""}, {"figures", figures(size.worst)}});
  Rows fade;
  if (!size.fade.empty()) fade.push_back({{"figures", figures(size.fade)}});
  return {{"size", pop_size_text(size.points.front())},
          {"scores", titles(page)},
          {"ranking", page.scores[page.ranking].title},
          {"kinds", kinds(page, size)},
          {"charts", html_rows(std::move(charts))},
          {"worst_cell", std::move(worst)},
          {"cross_fade", std::move(fade)}};
}

}  // namespace

std::string pop_page(const PopPage& page) {
  Rows sentences;
  for (const std::string& sentence : answer(page)) sentences.push_back({{"sentence", sentence}});
  size_t cells = 0;
  for (const PopSize& size : page.sizes) cells += size.points.size();
  const double top = chart_top(page);
  int last_chart = 0;
  Rows sizes;
  for (const PopSize& size : page.sizes)
    if (!size.points.empty()) sizes.push_back(size_values(page, size, top, last_chart));
  Html content = fill_template(page_file("pop_page.html"), {{"character", page.character},
                                                            {"clip", page.clip},
                                                            {"renderer", page.renderer},
                                                            {"program", page.program},
                                                            {"display", page.display},
                                                            {"answer", std::move(sentences)},
                                                            {"cells", count_text(cells)},
                                                            {"fade", page.fade},
                                                            {"software", page.software},
                                                            {"sizes", std::move(sizes)}});
  return page_frame(fmt::format("What a switch from the mesh to {} would show", page.representation),
                    std::move(content), "");
}

}  // namespace crowdbench::reports
