#include "reports/model/amplified.h"

#include <algorithm>
#include <array>
#include <cstdlib>

namespace crowdbench::reports {

std::optional<Amplified> amplified_difference(const Image8& a, const Image8& b) {
  if (a.width != b.width || a.height != b.height || a.channels != b.channels || a.channels < 3) return std::nullopt;
  Amplified out;
  out.picture = Image8(a.width, a.height, 3);
  std::array<size_t, 256> count{};
  for (size_t i = 0; i < a.pixels(); ++i)
    for (size_t c = 0; c < 3; ++c) {
      const size_t at = i * static_cast<size_t>(a.channels) + c;
      const int difference = std::abs(int{a.data[at]} - int{b.data[at]});
      out.picture.data[i * 3 + c] = static_cast<uint8_t>(difference);
      ++count[static_cast<size_t>(difference)];
      out.largest = std::max(out.largest, difference);
    }
  if (out.largest == 0) return std::nullopt;
  const size_t differing = 3 * a.pixels() - count[0];
  const auto cut_by = [&](int factor) {
    size_t cut = 0;
    for (int d = 255 / factor + 1; d < 256; ++d) cut += count[static_cast<size_t>(d)];
    return cut;
  };
  constexpr int kMostFactor = 64;
  while (out.factor < kMostFactor && 100 * cut_by(2 * out.factor) <= differing) out.factor *= 2;
  for (uint8_t& value : out.picture.data) value = static_cast<uint8_t>(std::min(255, value * out.factor));
  return out;
}

}  // namespace crowdbench::reports
