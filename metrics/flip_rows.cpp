// Compiled without math errno and floating-point traps (CMakeLists.txt), which changes no result: square roots and
// selections become vector instructions.
#include "metrics/flip_rows.h"

#include <cmath>

#include "metrics/fast_math.h"

namespace crowdbench::metrics {
namespace {

using Matrix = std::array<std::array<double, 3>, 3>;

// FLIP's matrices of sRGB's primaries and of D65, and its rounded inverses.
constexpr Matrix kToXyz = {{{10135552.0 / 24577794, 8788810.0 / 24577794, 4435075.0 / 24577794},
                            {2613072.0 / 12288897, 8788810.0 / 12288897, 887015.0 / 12288897},
                            {1425312.0 / 73733382, 8788810.0 / 73733382, 70074185.0 / 73733382}}};
constexpr Matrix kFromXyz = {{{3.241003275, -1.537398934, -0.498615861},
                              {-0.969224334, 1.875930071, 0.041554224},
                              {0.055639423, -0.204011202, 1.057148933}}};
constexpr std::array<double, 3> kWhite = {0.950428545, 1, 1.088900371};
constexpr std::array<double, 3> kOverWhite = {1.052156925, 1, 0.918357670};

using FloatMatrix = std::array<std::array<float, 3>, 3>;

// From linear RGB to what is relative to white.
constexpr FloatMatrix relative() {
  FloatMatrix out{};
  for (size_t r = 0; r < 3; ++r)
    for (size_t c = 0; c < 3; ++c) out[r][c] = static_cast<float>(kOverWhite[r] * kToXyz[r][c]);
  return out;
}

// From linear RGB to y, dx, dz.
constexpr FloatMatrix to_opponents() {
  FloatMatrix out{};
  for (size_t c = 0; c < 3; ++c) {
    const double y = kOverWhite[1] * kToXyz[1][c];
    out[0][c] = static_cast<float>(y);
    out[1][c] = static_cast<float>(kOverWhite[0] * kToXyz[0][c] - y);
    out[2][c] = static_cast<float>(y - kOverWhite[2] * kToXyz[2][c]);
  }
  return out;
}

// From y, dx, dz to linear RGB: X = (y + dx) Xw, Y = y, Z = (y - dz) Zw.
constexpr FloatMatrix from_opponents() {
  FloatMatrix out{};
  for (size_t r = 0; r < 3; ++r) {
    const double x = kFromXyz[r][0] * kWhite[0];
    const double z = kFromXyz[r][2] * kWhite[2];
    out[r] = {static_cast<float>(x + kFromXyz[r][1] * kWhite[1] + z), static_cast<float>(x), static_cast<float>(-z)};
  }
  return out;
}

constexpr FloatMatrix kRelative = relative();
constexpr FloatMatrix kToOpponents = to_opponents();
constexpr FloatMatrix kFromOpponents = from_opponents();

inline float row_of(const std::array<float, 3>& row, float a, float b, float c) {
  return row[0] * a + row[1] * b + row[2] * c;
}
inline float unit(float v) {
  const float above = v > 0 ? v : 0.0F;
  return above < 1 ? above : 1.0F;
}

struct Hunt {
  float l, a, b;
};

// f of CIE L*a*b*.
inline float lab_f(float t) {
  constexpr double kDelta = 6.0 / 29;
  constexpr auto kCorner = static_cast<float>(kDelta * kDelta * kDelta);
  constexpr auto kSlope = static_cast<float>(1 / (3 * kDelta * kDelta));
  const float root = fast_cbrt(t > kCorner ? t : kCorner);
  const float line = kSlope * t + static_cast<float>(4.0 / 29);
  return t > kCorner ? root : line;
}

// L*a*b* of linear RGB with a and b weakened in the dark.
inline Hunt hunt_of(float r, float g, float b) {
  const float fx = lab_f(row_of(kRelative[0], r, g, b));
  const float fy = lab_f(row_of(kRelative[1], r, g, b));
  const float fz = lab_f(row_of(kRelative[2], r, g, b));
  const float l = 116 * fy - 16;
  return {l, 0.01F * l * (500 * (fx - fy)), 0.01F * l * (200 * (fy - fz))};
}

[[gnu::always_inline]] inline Hunt hunt_of_opponents(float y, float dx, float dz) {
  return hunt_of(unit(row_of(kFromOpponents[0], y, dx, dz)), unit(row_of(kFromOpponents[1], y, dx, dz)),
                 unit(row_of(kFromOpponents[2], y, dx, dz)));
}

inline float hyab(const Hunt& p, const Hunt& q) {
  const float a = p.a - q.a;
  const float b = p.b - q.b;
  return std::abs(p.l - q.l) + std::sqrt(a * a + b * b);
}

constexpr float kPower = 0.7F;

}  // namespace

double greatest_colour_distance() {
  static const double distance = std::pow(double{hyab(hunt_of(0, 1, 0), hunt_of(0, 0, 1))}, 0.7);
  return distance;
}

void opponents_of(const float* __restrict red, const float* __restrict green, const float* __restrict blue,
                  const std::array<float*, 3>& out, size_t count) {
  float* __restrict y = out[0];
  float* __restrict dx = out[1];
  float* __restrict dz = out[2];
  for (size_t x = 0; x < in_blocks(count); ++x) {
    y[x] = row_of(kToOpponents[0], red[x], green[x], blue[x]);
    dx[x] = row_of(kToOpponents[1], red[x], green[x], blue[x]);
    dz[x] = row_of(kToOpponents[2], red[x], green[x], blue[x]);
  }
}

void filter_even(const Taps& taps, const float* const* centre, float* __restrict out, size_t count) {
  const auto radius = static_cast<std::ptrdiff_t>(taps.size()) - 1;
  for (size_t x = 0; x < count; x += kRowBlock) {
    std::array<float, kRowBlock> sum;
    for (size_t k = 0; k < kRowBlock; ++k) sum[k] = taps[0] * centre[0][x + k];
    for (std::ptrdiff_t i = 1; i <= radius; ++i) {
      const float tap = taps[static_cast<size_t>(i)];
      const float* __restrict before = centre[-i] + x;
      const float* __restrict after = centre[i] + x;
      for (size_t k = 0; k < kRowBlock; ++k) sum[k] += tap * (before[k] + after[k]);
    }
    for (size_t k = 0; k < kRowBlock; ++k) out[x + k] = sum[k];
  }
}

void filter_odd(const Taps& taps, const float* const* centre, float* __restrict out, size_t count) {
  const auto radius = static_cast<std::ptrdiff_t>(taps.size()) - 1;
  for (size_t x = 0; x < count; x += kRowBlock) {
    std::array<float, kRowBlock> sum{};
    for (std::ptrdiff_t i = 1; i <= radius; ++i) {
      const float tap = taps[static_cast<size_t>(i)];
      const float* __restrict before = centre[-i] + x;
      const float* __restrict after = centre[i] + x;
      for (size_t k = 0; k < kRowBlock; ++k) sum[k] += tap * (after[k] - before[k]);
    }
    for (size_t k = 0; k < kRowBlock; ++k) out[x + k] = sum[k];
  }
}

void add_row(const float* __restrict more, float* __restrict out, size_t count) {
  for (size_t x = 0; x < in_blocks(count); ++x) out[x] += more[x];
}

void colour_difference(const OpponentRow& reference, const OpponentRow& test, float* __restrict out, size_t count) {
  const auto greatest = static_cast<float>(greatest_colour_distance());
  constexpr float kSpread = 0.4F;  // of the greatest distance takes
  constexpr float kOver = 0.95F;   // of the result
  const float corner = kSpread * greatest;
  const float steep = kOver / corner;
  const float flat = (1 - kOver) / (greatest - corner);
  const float* __restrict y0 = reference[0];
  const float* __restrict dx0 = reference[1];
  const float* __restrict dz0 = reference[2];
  const float* __restrict y1 = test[0];
  const float* __restrict dx1 = test[1];
  const float* __restrict dz1 = test[2];
  for (size_t x = 0; x < in_blocks(count); ++x) {
    const Hunt p = hunt_of_opponents(y0[x], dx0[x], dz0[x]);
    const Hunt q = hunt_of_opponents(y1[x], dx1[x], dz1[x]);
    const float error = fast_pow(hyab(p, q), kPower);
    const float small = error * steep;
    const float large = kOver + (error - corner) * flat;
    out[x] = error < corner ? small : large;
  }
}

void length_difference(const std::array<const float*, 2>& reference, const std::array<const float*, 2>& test,
                       float* __restrict out, size_t count) {
  const float* __restrict x0 = reference[0];
  const float* __restrict y0 = reference[1];
  const float* __restrict x1 = test[0];
  const float* __restrict y1 = test[1];
  for (size_t x = 0; x < in_blocks(count); ++x)
    out[x] = std::abs(std::sqrt(x0[x] * x0[x] + y0[x] * y0[x]) - std::sqrt(x1[x] * x1[x] + y1[x] * y1[x]));
}

void combine_errors(const float* __restrict colour, const float* __restrict edge, const float* __restrict point,
                    float* __restrict out, size_t count) {
  constexpr float kOverRoot2 = 0.70710678F;
  for (size_t x = 0; x < in_blocks(count); ++x) {
    const float most = edge[x] > point[x] ? edge[x] : point[x];
    const float error = fast_pow(colour[x], 1 - std::sqrt(most * kOverRoot2));
    out[x] = error < 1 ? error : 1.0F;
  }
}

}  // namespace crowdbench::metrics
