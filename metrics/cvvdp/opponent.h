// From a picture to the three opponent planes that the eye's channels carry.
#pragma once
#include <array>
#include <vector>

#include "core/image.h"
#include "metrics/cvvdp/pyramid.h"
#include "metrics/display.h"

namespace crowdbench::metrics::vdp {

// A (close to luminance, cd/m2), RG, YV of one picture.
using OpponentPlanes = std::array<FloatPlane, kStillChannels>;

// R, G, B in cd/m2 to A, RG, YV: cone responses (LMS of 2006) in the DKL space of D65.
Matrix3 opponent_matrix(const ColourSpace& space);

// Pictures of one display. Grey counts as R = G = B, alpha is left out.
class OpponentColours {
 public:
  explicit OpponentColours(const Display& display);
  // Code values of 8 and 16 bits, and floats as light_of() takes them. threads: as parallel_for.
  void planes(const Image8& image, OpponentPlanes& out, unsigned threads);
  void planes(const Image16& image, OpponentPlanes& out, unsigned threads);
  void planes(const ImageF& image, OpponentPlanes& out, unsigned threads) const;

 private:
  template <typename T>
  void by_table(const Image<T>& image, std::vector<float>& table, OpponentPlanes& out, unsigned threads) const;

  Display display_;
  std::array<std::array<float, 3>, 3> matrix_{};
  std::vector<float> table8_, table16_;  // light by code value, made at the first use
};

}  // namespace crowdbench::metrics::vdp
