#include "reports/page/pop_page.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "reports/charts/charts.h"
#include "reports/model/summary.h"
#include "reports/page/page.h"
#include "reports/page/page_frame.h"

namespace crowdbench::reports {
namespace {

std::string at_text(const PopPoint& point) {
  return fmt::format("azimuth {:g}°, elevation {:g}°, phase {:g}", point.azimuth_deg, point.elevation_deg, point.phase);
}

std::string pictures_of(const std::vector<PopPicture>& pictures) {
  std::string html;
  for (const PopPicture& picture : pictures)
    html += fmt::format(
        "<figure><img width=\"{}\" height=\"{}\" alt=\"{}\" src=\"data:image/png;base64,{}\"><figcaption>{}"
        "</figcaption></figure>\n",
        picture.width, picture.height, html_escape(picture.caption), base64(picture.png), html_escape(picture.caption));
  return html;
}

std::string table(const PopSize& size) {
  std::string html =
      "<div class=\"scroll\"><table>\n<tr><th class=\"l\">Mesh before the switch</th><th>MAE, mean</th><th>95th "
      "percentile</th><th>worst</th><th class=\"l\">worst at</th><th>SSIM in the figure, mean</th><th>5th "
      "percentile</th>"
      "<th>worst</th></tr>\n";
  for (size_t w = 0; w < kPopSwitchKinds; ++w) {
    html += fmt::format("<tr><td class=\"l\">{}</td>", kPopSwitchTitles[w]);
    if (const auto& mae = size.mae[w])
      html += fmt::format("<td>{:.2f}</td><td>{:.2f}</td><td>{:.2f}</td><td class=\"l i\">{}</td>", mae->mean,
                          mae->tail, mae->worst, html_escape(at_text(mae->worst_at)));
    else
      html += "<td>–</td><td>–</td><td>–</td><td class=\"l i\">nothing is drawn</td>";
    if (const auto& ssim = size.ssim_union[w])
      html += fmt::format("<td>{:.3f}</td><td>{:.3f}</td><td>{:.3f}</td></tr>\n", ssim->mean, ssim->tail, ssim->worst);
    else
      html += "<td>–</td><td>–</td><td>–</td></tr>\n";
  }
  return html + "</table></div>\n";
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

}  // namespace

std::string pop_page(const PopPage& page) {
  std::string html = page_head(fmt::format("What a switch from the mesh to {} would show", page.representation));
  html += fmt::format("<p class=\"under\">{}, clip {}. Drawn on {} by {}.</p>\n", html_escape(page.character),
                      html_escape(page.clip), html_escape(page.renderer), html_escape(page.program));
  html += "<div class=\"answer\">\n";
  for (const std::string& sentence : answer(page)) html += "<p>" + html_escape(sentence) + "</p>\n";
  html += "</div>\n";
  html += fmt::format(
      "<p>Mesh and impostor at the identical camera and frame, over {} cells. <b>Own pose</b>: the mesh shows the "
      "exact "
      "phase of the clip, the impostor the stored frame nearest to it, so that the pose error counts. <b>Stored "
      "frame's "
      "pose</b>: the mesh has taken on that frame before the switch. A cross-fade of {} ticks passes pixels over by "
      "ordered dither; what counts is the largest of its steps.</p>\n",
      [&] {
        size_t cells = 0;
        for (const PopSize& size : page.sizes) cells += size.points.size();
        return count_text(cells);
      }(),
      page.fade);
  if (page.software)
    html +=
        "<p class=\"note\">Drawn by a software rasteriser; pictures and their differences do not depend on it beyond "
        "rounding.</p>\n";
  double high = 0;
  for (const PopSize& size : page.sizes)
    for (const PopPoint& point : size.points)
      for (const auto& mae : point.mae) high = std::max(high, mae.value_or(0));
  high = high > 0 ? std::ceil(high) : 1;
  int charts = 0;
  for (const PopSize& size : page.sizes) {
    if (size.points.empty()) continue;
    html += fmt::format("<h2>{}</h2>\n", html_escape(pop_size_text(size.points.front())));
    html += table(size);
    const std::string chart = pop_chart(size, high);
    if (!chart.empty())
      html += chart_block(chart, "Mean absolute difference by view, clip phase and kind of switch", ++charts);
    if (!size.worst.empty()) {
      html += fmt::format("<h3>The worst cell: {}</h3>\n<div class=\"pops\">\n",
                          size.mae[0] ? html_escape(at_text(size.mae[0]->worst_at)) : "");
      html += pictures_of(size.worst);
      html += "</div>\n";
    }
    if (!size.fade.empty()) {
      html += fmt::format("<h3>The same by a cross-fade of {} ticks</h3>\n<div class=\"pops\">\n", page.fade);
      html += pictures_of(size.fade);
      html += "</div>\n";
    }
  }
  html += page_foot("");
  return html;
}

}  // namespace crowdbench::reports
