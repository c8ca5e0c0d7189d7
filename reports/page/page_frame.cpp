#include "reports/page/page_frame.h"

#include "reports/page/escape.h"
#include "reports/page/libraries.h"
#include "reports/page/page_files.h"

namespace crowdbench::reports {

std::string page_frame(std::string_view title, Html content, std::string_view source) {
  std::vector<TemplateValues> libraries;
  for (const Library& library : chart_libraries())
    libraries.push_back({{"name", std::string(library.name)},
                         {"licence", Html{comment_text(library.licence)}},
                         {"script", Html{inline_script(library.script)}}});
  std::vector<TemplateValues> source_name;
  if (!source.empty()) source_name.push_back({{"name", std::string(source)}});
  return fill_template(page_file("frame.html"), {{"title", std::string(title)},
                                                 {"style", Html{std::string(page_file("page.css"))}},
                                                 {"content", std::move(content)},
                                                 {"source", std::move(source_name)},
                                                 {"libraries", std::move(libraries)},
                                                 {"page_script", Html{inline_script(page_file("page.js"))}}})
             .text +
         "\n";
}

}  // namespace crowdbench::reports
