// The pyramid that splits a plane into bands of spatial frequency.
#pragma once
#include <vector>

#include "metrics/cvvdp/large_pages.h"
#include "metrics/cvvdp/parameters.h"

namespace crowdbench::metrics::vdp {

struct FloatPlane {
  int width = 0, height = 0;
  std::vector<float, LargePages<float>> data;

  void resize(int width_, int height_) {
    width = width_;
    height = height_;
    data.resize(static_cast<size_t>(width_) * static_cast<size_t>(height_));
  }
  float* row(int y) { return data.data() + static_cast<size_t>(y) * static_cast<size_t>(width); }
  const float* row(int y) const { return const_cast<FloatPlane*>(this)->row(y); }
};

// Cycles per degree at the middle of each band, the finest first, the base band (0.1) last. At least one. Both sides at
// least 2.
std::vector<double> band_frequencies(int width, int height, double pixels_per_degree);

// Half the size, odd sizes rounded up, by a 5-tap filter; the sides of `in` at least 4. Rows first_row .. last_row - 1
// of `out`, which has its size already. The last column is weighted as the reference weights it: by whether the number
// of *rows* is odd.
void reduce_rows(const FloatPlane& in, FloatPlane& out, int first_row, int last_row);

// Row y of `coarse` expanded to twice the size (less one where odd), `width` wide. scratch: kept between calls.
void expand_row(const FloatPlane& coarse, int y, int width, std::vector<float>& scratch, float* out);

}  // namespace crowdbench::metrics::vdp
