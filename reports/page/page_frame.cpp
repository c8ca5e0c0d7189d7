#include "reports/page/page_frame.h"

#include <fmt/format.h>

#include "reports/page/libraries.h"
#include "reports/page/page.h"

namespace crowdbench::reports {

std::string page_head(std::string_view title) {
  const std::string heading = html_escape(title);
  std::string html = fmt::format(
      "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
      "<meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; img-src data: blob:; style-src "
      "'unsafe-inline'; script-src 'unsafe-inline' 'unsafe-eval'\">\n"
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n"
      "<meta name=\"color-scheme\" content=\"light dark\">\n<title>{}</title>\n<style>\n",
      heading);
  html += page_style();
  html += fmt::format("</style>\n</head>\n<body>\n<h1>{}</h1>\n", heading);
  return html;
}

std::string page_foot(std::string_view source) {
  std::string html =
      fmt::format("<footer>Made by crowdbench{}. Charts by Vega, Vega-Lite and Vega-Embed (BSD-3-Clause).</footer>\n",
                  source.empty() ? "" : " from " + html_escape(source));
  for (const Library& library : chart_libraries()) {
    std::string licence(library.licence);
    for (size_t at = licence.find("--"); at != std::string::npos; at = licence.find("--"))
      licence.replace(at, 2, "- -");
    html += fmt::format("<!-- {}\n{} -->\n<script>", library.name, licence);
    html += inline_script(library.script);
    html += "</script>\n";
  }
  html += "<script>";
  html += inline_script(page_script());
  html += "</script>\n</body>\n</html>\n";
  return html;
}

std::string chart_block(std::string_view specification, std::string_view title, int number) {
  const std::string id = fmt::format("chart-{}", number);
  return fmt::format(
      "<div class=\"chart\"><h3>{}</h3><div class=\"plot\" id=\"{}\"></div>\n<script type=\"application/json\" "
      "data-plot=\"{}\">{}</script></div>\n",
      html_escape(title), id, id, script_json(specification));
}

}  // namespace crowdbench::reports
