#include "reports/page/libraries.h"

#include "core/error.h"

#ifdef CROWDBENCH_HAS_CHART_LIBRARIES
extern "C" {
extern const char crowdbench_vega_js_begin[], crowdbench_vega_js_end[];
extern const char crowdbench_vega_licence_begin[], crowdbench_vega_licence_end[];
extern const char crowdbench_vega_lite_js_begin[], crowdbench_vega_lite_js_end[];
extern const char crowdbench_vega_lite_licence_begin[], crowdbench_vega_lite_licence_end[];
extern const char crowdbench_vega_embed_js_begin[], crowdbench_vega_embed_js_end[];
extern const char crowdbench_vega_embed_licence_begin[], crowdbench_vega_embed_licence_end[];
extern const char crowdbench_page_css_begin[], crowdbench_page_css_end[];
extern const char crowdbench_page_js_begin[], crowdbench_page_js_end[];
}
#endif

namespace crowdbench::reports {

#ifdef CROWDBENCH_HAS_CHART_LIBRARIES

const std::vector<Library>& chart_libraries() {
  static const std::vector<Library> all = {{"Vega",
                                            {crowdbench_vega_js_begin, crowdbench_vega_js_end},
                                            {crowdbench_vega_licence_begin, crowdbench_vega_licence_end}},
                                           {"Vega-Lite",
                                            {crowdbench_vega_lite_js_begin, crowdbench_vega_lite_js_end},
                                            {crowdbench_vega_lite_licence_begin, crowdbench_vega_lite_licence_end}},
                                           {"Vega-Embed",
                                            {crowdbench_vega_embed_js_begin, crowdbench_vega_embed_js_end},
                                            {crowdbench_vega_embed_licence_begin, crowdbench_vega_embed_licence_end}}};
  return all;
}
std::string_view page_style() { return {crowdbench_page_css_begin, crowdbench_page_css_end}; }
std::string_view page_script() { return {crowdbench_page_js_begin, crowdbench_page_js_end}; }

#else

namespace {
[[noreturn]] void refuse() {
  throw Error("report", "this program was built without the chart library",
              "run `npm ci` in the source folder and build again (./run build does both); the other exports work "
              "without it");
}
}  // namespace
const std::vector<Library>& chart_libraries() { refuse(); }
std::string_view page_style() { refuse(); }
std::string_view page_script() { refuse(); }

#endif

std::string inline_script(std::string_view script) {
  std::string text;
  text.reserve(script.size() + 64);
  for (size_t i = 0; i < script.size(); ++i) {
    const std::string_view rest = script.substr(i);
    if (rest.starts_with("\n//# sourceMappingURL=")) {
      const size_t end = rest.find('\n', 1);
      i += (end == std::string_view::npos ? rest.size() : end) - 1;
      continue;
    }
    // Both can only stand in strings and regular expressions of a valid script, where a backslash changes nothing.
    const bool tag = rest.size() >= 8 && rest[0] == '<' && rest[1] == '/' &&
                     (rest.substr(2, 6) == "script" || rest.substr(2, 6) == "SCRIPT" || rest.substr(2, 6) == "Script");
    if (tag) {
      text += "<\\/";
      ++i;
    } else if (rest.starts_with("<!--")) {
      text += "<\\!--";
      i += 3;
    } else {
      text += script[i];
    }
  }
  return text;
}

}  // namespace crowdbench::reports
