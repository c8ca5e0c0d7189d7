#include "reports/exports/markdown_cell.h"

namespace crowdbench::reports {

// "|" would end a cell of a Markdown table, "<" could open HTML.
std::string markdown_cell(const std::string& text) {
  std::string out;
  for (const char c : text) {
    if (c == '|')
      out += "\\|";
    else if (c == '<')
      out += "&lt;";
    else
      out += c == '\n' || c == '\r' ? ' ' : c;
  }
  return out;
}

}  // namespace crowdbench::reports
