// Counter-based random numbers: a hash of (seed, index, purpose), never a shared stream, so that the number of one
// agent does not depend on how many others were drawn before it, nor on the thread that asks. Based on: the finaliser
// of Steele, Lea and Flood, "Fast splittable pseudorandom number generators" (2014), variant 13 of D. Stafford's
// mixers. Pinned by literal tests: a change of any of these functions changes every crowd.
#pragma once
#include <cstdint>

namespace crowdbench {

constexpr uint64_t mix64(uint64_t x) {
  x ^= x >> 30;
  x *= 0xbf58476d1ce4e5b9ULL;
  x ^= x >> 27;
  x *= 0x94d049bb133111ebULL;
  x ^= x >> 31;
  return x;
}

// 64 random bits for one purpose of one index. purpose: a small constant of the caller (an enum), never reused for two
// uses.
constexpr uint64_t random_bits(uint64_t seed, uint64_t index, uint64_t purpose) {
  uint64_t h = mix64(seed + 0x9e3779b97f4a7c15ULL);
  h = mix64(h ^ (index * 0xd1342543de82ef95ULL + 0x9e3779b97f4a7c15ULL));
  return mix64(h ^ (purpose * 0xda942042e4dd58b5ULL + 0x2545f4914f6cdd1dULL));
}

// Uniform in [0, 1): 53 bits, exact on every machine.
constexpr double random_unit(uint64_t seed, uint64_t index, uint64_t purpose) {
  return static_cast<double>(random_bits(seed, index, purpose) >> 11) * 0x1.0p-53;
}

// Uniform integer in [0, n), n > 0, by the high half of a 128-bit product (bias below n / 2^64).
constexpr uint64_t random_below(uint64_t seed, uint64_t index, uint64_t purpose, uint64_t n) {
  __extension__ using uint128 = unsigned __int128;
  return static_cast<uint64_t>((static_cast<uint128>(random_bits(seed, index, purpose)) * n) >> 64);
}

}  // namespace crowdbench
