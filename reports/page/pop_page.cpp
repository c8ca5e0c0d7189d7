#include "reports/page/pop_page.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "reports/charts/charts.h"
#include "reports/model/number_text.h"
#include "reports/model/scores.h"
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

TemplateValues summary_values(const char* score, const PopSummary& summary) {
  return {{"mean", score_text(score, summary.mean)},
          {"tail", score_text(score, summary.tail)},
          {"worst", score_text(score, summary.worst)}};
}

Rows kinds(const PopSize& size) {
  Rows rows;
  for (size_t w = 0; w < kPopSwitchKinds; ++w) {
    Rows mae;
    if (const auto& summary = size.mae[w]) {
      mae.push_back(summary_values("mae", *summary));
      mae.back()["worst_at"] = at_text(summary->worst_at);
    }
    Rows ssim;
    if (const auto& summary = size.ssim_union[w]) ssim.push_back(summary_values("ssim_union", *summary));
    rows.push_back({{"kind", kPopSwitchTitles[w]}, {"mae", std::move(mae)}, {"ssim", std::move(ssim)}});
  }
  return rows;
}

// What the numbers say, in a sentence each.
std::vector<std::string> answer(const PopPage& page) {
  std::vector<std::string> out;
  for (const PopSize& size : page.sizes) {
    const auto& cut = size.mae[0];
    const auto& fade = size.mae[1];
    const auto& matched = size.mae[2];
    const auto& both = size.mae[3];
    if (!cut || !fade || !matched || !both) continue;
    out.push_back(fmt::format(
        "{}: switching at once changes the figure by {:.1f} code values on average and {:.1f} at worst. With the mesh "
        "in the stored frame's pose it is {:.1f}, with a cross-fade of {} ticks {:.1f} a step, with both {:.1f}.",
        pop_size_text(size.points.front()), cut->mean, cut->worst, matched->mean, page.fade, fade->mean, both->mean));
  }
  return out;
}

// The largest value of a chart, so that all charts of a page share one scale.
double chart_top(const PopPage& page) {
  double top = 0;
  for (const PopSize& size : page.sizes)
    for (const PopPoint& point : size.points)
      for (const auto& mae : point.mae) top = std::max(top, mae.value_or(0));
  return top > 0 ? std::ceil(top) : 1;
}

TemplateValues size_values(const PopSize& size, double top, int& last_chart) {
  std::vector<Html> charts;
  if (const std::string chart = pop_chart(size, top); !chart.empty())
    charts.push_back(
        chart_block(chart, "Mean absolute difference by view, clip phase and kind of switch", ++last_chart));
  Rows worst;
  if (!size.worst.empty())
    worst.push_back({{"at", size.mae[0] ? at_text(size.mae[0]->worst_at) : ""}, {"figures", figures(size.worst)}});
  Rows fade;
  if (!size.fade.empty()) fade.push_back({{"figures", figures(size.fade)}});
  return {{"size", pop_size_text(size.points.front())},
          {"kinds", kinds(size)},
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
    if (!size.points.empty()) sizes.push_back(size_values(size, top, last_chart));
  Html content = fill_template(page_file("pop_page.html"), {{"character", page.character},
                                                            {"clip", page.clip},
                                                            {"renderer", page.renderer},
                                                            {"program", page.program},
                                                            {"answer", std::move(sentences)},
                                                            {"cells", count_text(cells)},
                                                            {"fade", page.fade},
                                                            {"software", page.software},
                                                            {"sizes", std::move(sizes)}});
  return page_frame(fmt::format("What a switch from the mesh to {} would show", page.representation),
                    std::move(content), "");
}

}  // namespace crowdbench::reports
