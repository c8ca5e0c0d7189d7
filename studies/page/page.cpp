#include "studies/page/page.h"

#include <array>
#include <string>
#include <string_view>

#include "core/error.h"
#include "core/files.h"
#include "studies/page/page_files.h"

#ifdef CROWDBENCH_HAS_JSPSYCH
extern "C" {
extern const char crowdbench_jspsych_js_begin[], crowdbench_jspsych_js_end[];
extern const char crowdbench_plugin_html_button_response_js_begin[], crowdbench_plugin_html_button_response_js_end[];
extern const char crowdbench_plugin_survey_html_form_js_begin[], crowdbench_plugin_survey_html_form_js_end[];
}
#endif

namespace crowdbench::studies {
namespace {

struct Script {
  std::string_view name;
  std::string_view text;
};

#ifdef CROWDBENCH_HAS_JSPSYCH
const std::array<Script, 3>& scripts() {
  static const std::array<Script, 3> all = {
      Script{"jspsych.js", {crowdbench_jspsych_js_begin, crowdbench_jspsych_js_end}},
      Script{"plugin-html-button-response.js",
             {crowdbench_plugin_html_button_response_js_begin, crowdbench_plugin_html_button_response_js_end}},
      Script{"plugin-survey-html-form.js",
             {crowdbench_plugin_survey_html_form_js_begin, crowdbench_plugin_survey_html_form_js_end}}};
  return all;
}
#else
const std::array<Script, 3>& scripts() {
  throw Error("study page", "this program was built without jsPsych",
              "run `npm ci` in the source folder and build again (./run build does both)");
}
#endif

// Without the last line's reference to a source map, which a browser's tools would ask another host for.
std::string_view without_map(std::string_view script) {
  const size_t at = script.rfind("//# sourceMappingURL=");
  return at == std::string_view::npos ? script : script.substr(0, at);
}

}  // namespace

void require_page() { scripts(); }

void write_page(const std::filesystem::path& folder) {
  const std::array<Script, 3>& vendored = scripts();
  for (const PageFile& file : page_files()) write_file(folder / file.name, file.text);
  make_folder(folder / "vendor");
  for (const Script& script : vendored) write_file(folder / "vendor" / script.name, without_map(script.text));
}

}  // namespace crowdbench::studies
