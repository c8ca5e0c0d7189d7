// Powers and roots in float from + - * / alone, so that a loop over pixels becomes vector instructions and its results
// are the same bytes on every machine.
//
// Based on: Halley's iteration for the cube root from a first guess by the exponent's bits; the series of the inverse
// hyperbolic tangent for the logarithm, and Taylor's for the power of two, each after exact reduction.
#pragma once
#include <bit>
#include <cstdint>

namespace crowdbench::metrics {

// Cube root of 1e-30 .. 1e30; relative error below 2.5e-7.
inline float fast_cbrt(float t) {
  // A third of the bits is a third of the exponent; the constant makes up for its bias.
  const auto third = static_cast<int32_t>(static_cast<float>(std::bit_cast<int32_t>(t)) * (1.0F / 3.0F));
  float root = std::bit_cast<float>(third + 709921077);  // within 3.5 per cent
  for (int i = 0; i < 2; ++i) {
    const float cube = root * root * root;
    root *= (cube + 2 * t) / (2 * cube + t);
  }
  return root;
}

// Logarithm to the base 2 of a normal number above 0; absolute error below 2e-7 beside the rounding of the result.
inline float fast_log2(float t) {
  const auto bits = std::bit_cast<int32_t>(t);
  const int32_t exponent = (bits - 0x3f3504f3) >> 23;  // so that the rest is in [sqrt(1/2), sqrt(2))
  const auto rest = std::bit_cast<float>(bits - exponent * (int32_t{1} << 23));
  const float s = (rest - 1) / (rest + 1);
  const float ss = s * s;
  constexpr float kTwoOverLn2 = 2.885390082F;
  const float series = 1 + ss * (1.0F / 3 + ss * (1.0F / 5 + ss * (1.0F / 7 + ss * (1.0F / 9))));
  return static_cast<float>(exponent) + kTwoOverLn2 * s * series;
}

// 2^p; relative error below 3e-7. p: at most 127; below -126 as -126.
inline float fast_exp2(float p) {
  const float held = p < -126 ? -126.0F : p;
  constexpr float kRound = 12582912;  // 1.5 * 2^23: adding it rounds to whole numbers
  const float whole = (held + kRound) - kRound;
  const float x = (held - whole) * 0.693147181F;
  const float series = 1 + x * (1 + x * (1.0F / 2 + x * (1.0F / 6 + x * (1.0F / 24 + x * (1.0F / 120 + x / 720)))));
  return series * std::bit_cast<float>((static_cast<int32_t>(whole) + 127) * (int32_t{1} << 23));
}

// base^exponent for base of 0 or above (0 gives 0). Relative error below 1e-6 where the result is within 2^-8 .. 2^8.
inline float fast_pow(float base, float exponent) {
  const float power = fast_exp2(exponent * fast_log2(base));
  return base > 0 ? power : 0.0F;
}

}  // namespace crowdbench::metrics
