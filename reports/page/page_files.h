// The pages' templates, style sheet and script, as they were embedded when the program was built.
#pragma once
#include <string_view>
#include <vector>

namespace crowdbench::reports {

struct PageFile {
  std::string_view name;  // in reports/page: "report.html"
  std::string_view text;
};
const std::vector<PageFile>& page_files();

// The text of one, without its last line break. Throws std::logic_error where there is none of that name: names are the
// program's own.
std::string_view page_file(std::string_view name);

}  // namespace crowdbench::reports
