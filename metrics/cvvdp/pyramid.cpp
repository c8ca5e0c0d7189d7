// Based on: P. J. Burt, E. H. Adelson, "The Laplacian pyramid as a compact image code", IEEE Trans. Comm. 31(4), 1983,
// with the borders of ColorVideoVDP (Mantiuk et al. 2024).
#include "metrics/cvvdp/pyramid.h"

#include <algorithm>
#include <cmath>

#include "metrics/cvvdp/fast_math.h"

namespace crowdbench::metrics::vdp {
namespace {

constexpr float kOuter = 0.05F, kInner = 0.25F, kCentre = 0.4F;

CROWDBENCH_VECTORISED
void combine_five(const float* const* rows, float* __restrict out, size_t count) {
  const float* __restrict a = rows[0];
  const float* __restrict b = rows[1];
  const float* __restrict c = rows[2];
  const float* __restrict d = rows[3];
  const float* __restrict e = rows[4];
  for (size_t x = 0; x < count; ++x) out[x] = kOuter * (a[x] + e[x]) + kInner * (b[x] + d[x]) + kCentre * c[x];
}

// out[i] around in[2 i], which has two elements before and two behind.
CROWDBENCH_VECTORISED
void halve(const float* __restrict in, float* __restrict out, size_t count) {
  for (size_t i = 0; i < count; ++i) {
    const float* c = in + 2 * i;
    out[i] = kOuter * (c[-2] + c[2]) + kInner * (c[-1] + c[1]) + kCentre * c[0];
  }
}

CROWDBENCH_VECTORISED
void expand_even(const float* __restrict a, const float* __restrict b, const float* __restrict c, float* __restrict out,
                 size_t count) {
  for (size_t x = 0; x < count; ++x) out[x] = 2 * kOuter * (a[x] + c[x]) + 2 * kCentre * b[x];
}

CROWDBENCH_VECTORISED
void expand_odd(const float* __restrict a, const float* __restrict b, float* __restrict out, size_t count) {
  for (size_t x = 0; x < count; ++x) out[x] = 2 * kInner * (a[x] + b[x]);
}

// out[2 i] around in[i], out[2 i + 1] between in[i] and the next; `in` has one element before and one behind.
CROWDBENCH_VECTORISED
void interleave(const float* __restrict in, float* __restrict out, size_t pairs) {
  const float* before = in - 1;
  for (size_t i = 0; i < pairs; ++i) {
    out[2 * i] = 2 * kOuter * (before[i] + before[i + 2]) + 2 * kCentre * in[i];
    out[2 * i + 1] = 2 * kInner * (in[i] + in[i + 1]);
  }
}

int mirrored(int i, int count) { return i < 0 ? -1 - i : i >= count ? 2 * count - 1 - i : i; }

}  // namespace

std::vector<double> band_frequencies(int width, int height, double pixels_per_degree) {
  constexpr double kCoarsest = 0.2;  // cycles per degree
  constexpr double kBase = 0.1;
  const int by_size = static_cast<int>(std::floor(std::log2(std::min(width, height)))) - 1;
  std::vector<double> out;
  double frequency = pixels_per_degree / 2;
  for (double scale = 0.3228; static_cast<int>(out.size()) < by_size; scale /= 2) {
    out.push_back(frequency);
    if (frequency <= kCoarsest) break;
    frequency = scale * pixels_per_degree / 2;
  }
  out.push_back(kBase);
  return out;
}

void reduce_rows(const FloatPlane& in, FloatPlane& out, int first_row, int last_row) {
  const auto width = static_cast<size_t>(in.width);
  // Two elements before and three behind.
  std::vector<float> padded(width + 5);
  float* line = padded.data() + 2;
  for (int y = first_row; y < last_row; ++y) {
    const float* rows[5];
    for (int k = 0; k < 5; ++k) rows[k] = in.row(mirrored(2 * y - 2 + k, in.height));
    combine_five(rows, line, width);
    line[-1] = line[0];
    line[-2] = line[1];
    std::fill(line + width, line + width + 3, 0.0F);
    float* o = out.row(y);
    halve(line, o, static_cast<size_t>(out.width));
    // What lies behind the last column counted as 0 so far.
    float& last = o[out.width - 1];
    if (in.height % 2 == 1)
      last += kInner * line[width - 1] + kOuter * line[width - 2];
    else
      last += kOuter * line[width - 1];
  }
}

void expand_row(const FloatPlane& coarse, int y, int width, std::vector<float>& scratch, float* out) {
  const auto count = static_cast<size_t>(coarse.width);
  scratch.resize(count + 2);
  float* line = scratch.data() + 1;
  const int i = y / 2;
  const float* centre = coarse.row(i);
  const float* next = coarse.row(std::min(i + 1, coarse.height - 1));
  if (y % 2 == 0)
    expand_even(coarse.row(std::max(i - 1, 0)), centre, next, line, count);
  else
    expand_odd(centre, next, line, count);
  line[-1] = line[0];
  line[count] = line[count - 1];
  const size_t pairs = static_cast<size_t>(width) / 2;
  interleave(line, out, pairs);
  if (width % 2 == 1) out[width - 1] = 2 * kOuter * (line[pairs - 1] + line[pairs + 1]) + 2 * kCentre * line[pairs];
}

}  // namespace crowdbench::metrics::vdp
