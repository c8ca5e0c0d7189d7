#include "reports/page/page_files.h"

#include <fmt/format.h>

#include <stdexcept>

namespace crowdbench::reports {

std::string_view page_file(std::string_view name) {
  for (const PageFile& file : page_files())
    if (file.name == name) return file.text.substr(0, file.text.size() - (file.text.ends_with('\n') ? 1 : 0));
  throw std::logic_error(fmt::format("no file {} in reports/page", name));
}

}  // namespace crowdbench::reports
