// Heat maps: tables of numbers as coloured cells, several panels on one scale.
#pragma once
#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "core/image.h"

namespace crowdbench::metrics {

struct HeatPanel {
  std::string title;
  std::vector<std::string> columns, rows;  // labels; rows from top to bottom
  std::vector<double> values;              // rows x columns, row by row; NaN: no value, drawn grey
};

// Panels row by row (rows of panels may differ in length), each cell in error_colours() of value / high (held within 0
// and 1) with its number in it, and below all the colour bar from 0 to `high` with `caption`. RGB, white around, wide
// enough for every title and the caption. high > 0. Throws nothing; a panel whose values do not fill its table is a bug
// and asserts.
Image8 heat_map(const std::vector<std::vector<HeatPanel>>& panels, double high, const std::string& caption);

// The colour that heat_map gives a value.
std::array<uint8_t, 3> heat_colour(double value, double high);

}  // namespace crowdbench::metrics
