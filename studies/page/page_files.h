// The study page's own files, as they were embedded when the program was built.
#pragma once
#include <string_view>
#include <vector>

namespace crowdbench::studies {

struct PageFile {
  std::string_view name;  // in studies/page: "index.html"
  std::string_view text;
};
const std::vector<PageFile>& page_files();

}  // namespace crowdbench::studies
