// The page of what holds at the extremes: every row beside its bound, those that do not hold with their worst pixel.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

namespace crowdbench::reports {

struct StabilityPageRow {
  std::string name, representation, asked, measured, bound, unit, bound_from, place, expected, got, note;  // plain text
  bool pass = false;
  bool bound_seen = false;  // the bound was set after seeing what is reached
  // The surroundings of the worst pixel in both pictures, enlarged, as PNG; may be empty.
  std::vector<uint8_t> before, after;
  int width = 0, height = 0;  // of each
};

// One self-contained HTML page that opens without a network; failing rows first, with pictures, then the table of all.
// renderer, program: what drew, and who says so. Throws Error when the program was built without the chart library.
std::string stability_page(const std::vector<StabilityPageRow>& rows, const std::string& renderer,
                           const std::string& program);

}  // namespace crowdbench::reports
