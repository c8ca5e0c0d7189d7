// The ordered dither of cross-fades, for C++ and GLSL alike.
// Based on: B. E. Bayer, "An optimum method for two-level rendition of continuous-tone pictures" (1973).
#ifndef CROWDBENCH_DITHER_SHARED_H
#define CROWDBENCH_DITHER_SHARED_H

#define CB_DITHER_RANKS 64

#ifdef __cplusplus
namespace crowdbench::renderers {
using uint = unsigned;
#define CB_CONSTEXPR constexpr
#else
#define CB_CONSTEXPR
#endif

// The rank of a pixel in the 8 x 8 Bayer matrix, 0..63; a share s of the pixels has (rank + 0.5) / 64 < s. Pixels count
// from the lower left.
CB_CONSTEXPR uint dither_rank(uint x, uint y) {
  uint m = x ^ y;
  return (m & 1u) << 5u | (y & 1u) << 4u | (m & 2u) << 2u | (y & 2u) << 1u | (m & 4u) >> 1u | (y & 4u) >> 2u;
}

#ifdef __cplusplus
}  // namespace crowdbench::renderers
#endif

#endif
