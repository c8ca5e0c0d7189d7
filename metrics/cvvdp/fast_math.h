// Powers in single precision, written so that a compiler turns a loop over them into vector instructions: no branch, no
// table, no call. The same bits on every machine (no fused multiply-add: -ffp-contract=off).
//
// Based on: minimax polynomials by the exchange of Remez, for the logarithm in s = (m - 1) / (m + 1).
#pragma once
#include <bit>
#include <cstdint>

#include "core/sanitizer.h"

// A loop of these functions is compiled twice, for any x86-64 and for AVX2, and the machine's kind is chosen when the
// program starts. Neither has operations that the other rounds differently, so that the bits are the same. Sanitizers
// cannot instrument what runs that early.
#if defined(__x86_64__) && defined(__GNUC__) && !CROWDBENCH_HAS_SANITIZER
#define CROWDBENCH_VECTORISED __attribute__((target_clones("avx2", "default")))
#else
#define CROWDBENCH_VECTORISED
#endif

namespace crowdbench::metrics::vdp {

// log2 of a normal, positive number. Absolute error below 1.5e-7 for results within [-1, 1], else below one unit in the
// result's last place.
inline float fast_log2(float x) {
  constexpr int32_t kSqrtHalf = 0x3f3504f3;  // 0.70710677: the mantissa is brought to [sqrt(1/2), sqrt(2))
  const auto bits = std::bit_cast<int32_t>(x);
  const int32_t exponent = (bits - kSqrtHalf) >> 23;
  const auto m = std::bit_cast<float>(bits - (exponent << 23));
  const float s = (m - 1.0F) / (m + 1.0F);
  const float s2 = s * s;
  return static_cast<float>(exponent) + s * (2.88539129F + s2 * (0.961470809F + s2 * 0.598973886F));
}

// 2^x for -126 <= x <= 127. Relative error below 2.5e-7.
inline float fast_exp2(float x) {
  const int32_t n = static_cast<int32_t>(x + 126.5F) - 126;  // the nearest whole number
  const float f = x - static_cast<float>(n);
  const float p =
      1.00000007F +
      f * (0.693146967F + f * (0.240221197F + f * (0.0555071327F + f * (0.00967554133F + f * 0.0013276472F))));
  return std::bit_cast<float>(std::bit_cast<int32_t>(p) + (n << 23));
}

// x^p for a normal, positive x.
inline float fast_pow(float x, float p) { return fast_exp2(p * fast_log2(x)); }

}  // namespace crowdbench::metrics::vdp
