#include "reports/page/blocks.h"

#include <fmt/format.h>

#include "reports/page/escape.h"
#include "reports/page/page_files.h"

namespace crowdbench::reports {

Html chart_block(std::string_view specification, std::string_view title, int number) {
  return fill_template(page_file("chart.html"), {{"title", std::string(title)},
                                                 {"id", fmt::format("chart-{}", number)},
                                                 {"specification", Html{script_json(specification)}}});
}

Html figure_block(int width, int height, const std::vector<uint8_t>& png, std::string_view alt, Html caption) {
  return fill_template(page_file("figure.html"), {{"width", width},
                                                  {"height", height},
                                                  {"png", base64(png)},
                                                  {"alt", std::string(alt)},
                                                  {"caption", std::move(caption)}});
}

std::vector<TemplateValues> html_rows(std::vector<Html> blocks) {
  std::vector<TemplateValues> rows;
  for (Html& block : blocks) rows.push_back({{"html", std::move(block)}});
  return rows;
}

}  // namespace crowdbench::reports
