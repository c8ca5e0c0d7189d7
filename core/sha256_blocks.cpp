// Based on: NIST, FIPS 180-4 "Secure Hash Standard", section 6.2; Gulley et al., "Intel SHA Extensions" (2013), for
// what the instructions compute and how they want the state: as the words A, B, E, F and C, D, G, H, highest lane
// first.
#include "core/sha256_blocks.h"

#if defined(__x86_64__)
#include <cpuid.h>
#include <immintrin.h>

#include <array>

namespace crowdbench {
namespace {

// The first 32 bits of the fractional parts of the cube roots of the first 64 primes.
alignas(16) constexpr std::array<uint32_t, 64> kRound = {
    0x428a2f98, 0x71374491, 0xb5c0fbcf, 0xe9b5dba5, 0x3956c25b, 0x59f111f1, 0x923f82a4, 0xab1c5ed5,
    0xd807aa98, 0x12835b01, 0x243185be, 0x550c7dc3, 0x72be5d74, 0x80deb1fe, 0x9bdc06a7, 0xc19bf174,
    0xe49b69c1, 0xefbe4786, 0x0fc19dc6, 0x240ca1cc, 0x2de92c6f, 0x4a7484aa, 0x5cb0a9dc, 0x76f988da,
    0x983e5152, 0xa831c66d, 0xb00327c8, 0xbf597fc7, 0xc6e00bf3, 0xd5a79147, 0x06ca6351, 0x14292967,
    0x27b70a85, 0x2e1b2138, 0x4d2c6dfc, 0x53380d13, 0x650a7354, 0x766a0abb, 0x81c2c92e, 0x92722c85,
    0xa2bfe8a1, 0xa81a664b, 0xc24b8b70, 0xc76c51a3, 0xd192e819, 0xd6990624, 0xf40e3585, 0x106aa070,
    0x19a4c116, 0x1e376c08, 0x2748774c, 0x34b0bcb5, 0x391c0cb3, 0x4ed8aa4a, 0x5b9cca4f, 0x682e6ff3,
    0x748f82ee, 0x78a5636f, 0x84c87814, 0x8cc70208, 0x90befffa, 0xa4506ceb, 0xbef9a3f7, 0xc67178f2};

}  // namespace

bool has_sha256_instructions() {
  static const bool have = [] {
    unsigned a = 0;
    unsigned b = 0;
    unsigned c = 0;
    unsigned d = 0;
    if (!__get_cpuid(1, &a, &b, &c, &d) || (c & bit_SSSE3) == 0 || (c & bit_SSE4_1) == 0) return false;
    return __get_cpuid_count(7, 0, &a, &b, &c, &d) != 0 && (b >> 29 & 1U) != 0;
  }();
  return have;
}

__attribute__((target("sha,sse4.1,ssse3"))) void compress_sha256(uint32_t* state, const uint8_t* data, size_t blocks) {
  const __m128i big_endian = _mm_set_epi8(12, 13, 14, 15, 8, 9, 10, 11, 4, 5, 6, 7, 0, 1, 2, 3);
  const auto word = [&](int i) __attribute__((target("sha,sse4.1,ssse3"))) { return static_cast<int>(state[i]); };
  __m128i abef = _mm_set_epi32(word(0), word(1), word(4), word(5));
  __m128i cdgh = _mm_set_epi32(word(2), word(3), word(6), word(7));
  for (; blocks > 0; --blocks, data += 64) {
    const __m128i abef_before = abef;
    const __m128i cdgh_before = cdgh;
    __m128i w[4];  // the last sixteen words of the schedule, by fours
#pragma GCC unroll 16
    for (int four = 0; four < 16; ++four) {
      __m128i& now = w[four & 3];
      if (four < 4) {
        now = _mm_loadu_si128(reinterpret_cast<const __m128i*>(data + 16 * four));
        now = _mm_shuffle_epi8(now, big_endian);
      } else {
        const __m128i& before = w[(four + 3) & 3];
        const __m128i seven_ago = _mm_alignr_epi8(before, w[(four + 2) & 3], 4);
        now = _mm_add_epi32(_mm_sha256msg1_epu32(now, w[(four + 1) & 3]), seven_ago);
        now = _mm_sha256msg2_epu32(now, before);
      }
      const __m128i round = _mm_load_si128(reinterpret_cast<const __m128i*>(kRound.data() + 4 * four));
      const __m128i added = _mm_add_epi32(now, round);
      cdgh = _mm_sha256rnds2_epu32(cdgh, abef, added);
      abef = _mm_sha256rnds2_epu32(abef, cdgh, _mm_shuffle_epi32(added, 0x0E));
    }
    abef = _mm_add_epi32(abef, abef_before);
    cdgh = _mm_add_epi32(cdgh, cdgh_before);
  }
  alignas(16) std::array<uint32_t, 4> low;
  alignas(16) std::array<uint32_t, 4> high;
  _mm_store_si128(reinterpret_cast<__m128i*>(low.data()), abef);
  _mm_store_si128(reinterpret_cast<__m128i*>(high.data()), cdgh);
  state[0] = low[3];
  state[1] = low[2];
  state[2] = high[3];
  state[3] = high[2];
  state[4] = low[1];
  state[5] = low[0];
  state[6] = high[1];
  state[7] = high[0];
}

}  // namespace crowdbench
#else
namespace crowdbench {

bool has_sha256_instructions() { return false; }
void compress_sha256(uint32_t*, const uint8_t*, size_t) {}

}  // namespace crowdbench
#endif
