#include "reports/page/clip_page.h"

#include <fmt/format.h>

#include "reports/charts/clip_chart.h"
#include "reports/model/number_text.h"
#include "reports/page/blocks.h"
#include "reports/page/escape.h"
#include "reports/page/page_files.h"
#include "reports/page/page_frame.h"

namespace crowdbench::reports {
namespace {

using Rows = std::vector<TemplateValues>;

std::string frame_text(const ClipPage& page, size_t frame) {
  return page.fps > 0 ? fmt::format("{} ({:.2f} s)", frame, static_cast<double>(frame) / page.fps)
                      : fmt::format("{}", frame);
}

std::string equal_text(const ClipPage& page) {
  if (page.equal == page.frames) return ", all equal: no frame is worse than another";
  return page.equal > 0 ? fmt::format(", {} of them equal", count_text(page.equal)) : "";
}

TemplateValues row_of(const ClipPage& page, const ClipSeries& series) {
  TemplateValues row = {{"title", heading(series.doc)}};
  Rows there;
  Rows worst;
  if (series.worst_frame)
    worst.push_back({{"value", score_text(series.doc, series.by_frame[*series.worst_frame].value())},
                     {"frame", frame_text(page, *series.worst_frame)}});
  Rows how;
  Rows missing;
  if (series.whole) {
    there.push_back({{"value", score_text(series.doc, *series.whole)}});
    how.push_back({{"pooling", series.pooling + best_text(series.doc)},
                   {"conditions", series.conditions.empty() ? "" : "; at " + series.conditions}});
  } else {
    missing.push_back({{"reason", series.reason}});
  }
  row["how"] = std::move(how);
  row["missing"] = std::move(missing);
  row["there"] = std::move(there);
  row["worst"] = std::move(worst);
  return row;
}

}  // namespace

std::string clip_page(const ClipPage& page) {
  Rows rows;
  std::vector<Html> charts;
  std::vector<Html> maps;
  for (const ClipSeries& series : page.scores) {
    rows.push_back(row_of(page, series));
    if (std::string chart = clip_chart(series, page.fps); !chart.empty())
      charts.push_back(chart_block(chart, heading(series.doc), static_cast<int>(charts.size()) + 1));
    if (series.map.png.empty()) continue;
    const std::string caption =
        series.worst_frame ? fmt::format("{}, frame {}", heading(series.doc), frame_text(page, *series.worst_frame))
                           : heading(series.doc);
    maps.push_back(
        figure_block(series.map.width, series.map.height, series.map.png, caption, Html{html_escape(caption)}));
  }
  Rows with_maps;
  if (!maps.empty()) with_maps.push_back({{"figures", html_rows(std::move(maps))}});
  Html content = fill_template(page_file("clip_page.html"),
                               {{"reference", page.reference},
                                {"test", page.test},
                                {"frames", count_text(page.frames)},
                                {"equal", equal_text(page)},
                                {"rate", page.fps > 0 ? fmt::format(" at {:g} a second", page.fps) : ""},
                                {"width", page.width},
                                {"height", page.height},
                                {"display", page.display},
                                {"rows", std::move(rows)},
                                {"charts", html_rows(std::move(charts))},
                                {"maps", std::move(with_maps)}});
  return page_frame("Two clips compared", std::move(content), "");
}

}  // namespace crowdbench::reports
