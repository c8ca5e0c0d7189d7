// Text in a cell of a Markdown table.
#pragma once
#include <string>

namespace crowdbench::reports {

// On one line, without what would end the cell or open HTML.
std::string markdown_cell(const std::string& text);

}  // namespace crowdbench::reports
