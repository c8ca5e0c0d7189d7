// The chart library (Vega, Vega-Lite, Vega-Embed; BSD-3-Clause) as it was embedded when the program was built.
#pragma once
#include <string_view>
#include <vector>

namespace crowdbench::reports {

struct Library {
  std::string_view name;
  std::string_view script;   // minified JavaScript
  std::string_view licence;  // its licence text
};
// In the order in which a page must load them. Throws Error when the program was built without the npm packages.
const std::vector<Library>& chart_libraries();

}  // namespace crowdbench::reports
