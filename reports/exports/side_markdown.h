// Several result files beside each other in Markdown.
#pragma once
#include <string>

#include "reports/model/side_by_side.h"

namespace crowdbench::reports {

// A heading and a table a group; empty where there is one file.
std::string side_markdown(const SideBySide& sides);

}  // namespace crowdbench::reports
