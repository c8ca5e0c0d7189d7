// The arithmetic of FLIP, row by row: loops over pixels that become vector instructions. Private to flip.cpp and its
// test; metrics/flip.h is what to use.
#pragma once
#include <array>
#include <cstddef>

#include "metrics/flip_filters.h"

namespace crowdbench::metrics {

// Rows are worked on in whole blocks: every row that is given to these functions has room for a count that is rounded
// up to this, and what lies beyond the count is read and written but means nothing.
constexpr size_t kRowBlock = 16;
constexpr size_t in_blocks(size_t count) { return (count + kRowBlock - 1) / kRowBlock * kRowBlock; }

// A colour by opponents, each relative to the white of D65: y = Y / Yw, dx = X / Xw - y, dz = y - Z / Zw. FLIP's YCxCz
// is 116 y - 16, 500 dx, 200 dz; filters, whose taps add up to 1, commute with that.
using OpponentRow = std::array<const float*, 3>;

// From linear RGB (BT.709) of 0..1.
void opponents_of(const float* red, const float* green, const float* blue, const std::array<float*, 3>& out,
                  size_t count);

// out[x] = taps[0] c[0][x] + sum over i of taps[i] (c[-i][x] + c[i][x]). centre: the pointer to c[0] among those to
// rows, or to one row moved by a pixel each.
void filter_even(const Taps& taps, const float* const* centre, float* out, size_t count);
// The same with c[i] - c[-i]: for odd filters.
void filter_odd(const Taps& taps, const float* const* centre, float* out, size_t count);
// out += more
void add_row(const float* more, float* out, size_t count);

// FLIP's colour difference, 0..1, of filtered colours: back to RGB, held within 0 and 1, to L*a*b* with Hunt's
// adjustment; HyAB distance to the power 0.7; of which 0.4 of the greatest is spread over 0 .. 0.95.
void colour_difference(const OpponentRow& reference, const OpponentRow& test, float* out, size_t count);

// |length of (reference x, y) - length of (test x, y)|
void length_difference(const std::array<const float*, 2>& reference, const std::array<const float*, 2>& test,
                       float* out, size_t count);

// FLIP's error: colour^(1 - F), F = sqrt(max(edge, point) / sqrt 2).
void combine_errors(const float* colour, const float* edge, const float* point, float* out, size_t count);

// The HyAB distance of green and blue to the power 0.7, by which colour differences are measured.
double greatest_colour_distance();

}  // namespace crowdbench::metrics
