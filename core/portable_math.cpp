// Based on: the Taylor series of sine and cosine on [-1/8, 1/8] turn, after exact reduction by whole eighths.
#include "core/portable_math.h"

namespace crowdbench {
namespace {

// floor() by conversion: exact for |x| < 2^62, and no libm call whose rounding could differ.
double floor_exact(double x) {
  const auto truncated = static_cast<double>(static_cast<long long>(x));
  return truncated > x ? truncated - 1.0 : truncated;
}

}  // namespace

SinCos sincos_turns(double turns) {
  const double whole = turns - floor_exact(turns);           // [0, 1)
  const auto quarter = static_cast<int>(whole * 4.0 + 0.5);  // nearest quarter turn, 0..4
  const double x = (whole - quarter * 0.25) * 6.283185307179586476925286766559;
  const double xx = x * x;
  double s = 0.0;
  double c = 0.0;
  for (int n = 8; n >= 1; --n) {  // |x| <= pi/4: the first dropped terms are below 1e-17
    s = (s + 1.0) * (-xx / ((2.0 * n) * (2.0 * n + 1.0)));
    c = (c + 1.0) * (-xx / ((2.0 * n - 1.0) * (2.0 * n)));
  }
  s = x * (1.0 + s);
  c = 1.0 + c;
  switch (quarter & 3) {
    case 0: return {s, c};
    case 1: return {c, -s};
    case 2: return {-s, -c};
    default: return {-c, s};
  }
}

}  // namespace crowdbench
