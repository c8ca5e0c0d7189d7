// Image<T>: a plain interleaved picture in memory.
#pragma once
#include <cstddef>
#include <cstdint>
#include <vector>

namespace crowdbench {

// width x height x channels, row 0 on top, channels interleaved in the order R, G, B, A (or grey).
// 8-bit colour is sRGB-encoded, float colour is linear light, unless a function says otherwise.
template <typename T>
struct Image {
  int width = 0;
  int height = 0;
  int channels = 0;
  std::vector<T> data;

  Image() = default;
  Image(int width_, int height_, int channels_)
      : width(width_),
        height(height_),
        channels(channels_),
        data(static_cast<size_t>(width_) * static_cast<size_t>(height_) * static_cast<size_t>(channels_)) {}

  bool empty() const { return data.empty(); }
  size_t pixels() const { return static_cast<size_t>(width) * static_cast<size_t>(height); }
  T* at(int x, int y) {
    return data.data() + (static_cast<size_t>(y) * static_cast<size_t>(width) + static_cast<size_t>(x)) *
                             static_cast<size_t>(channels);
  }
  const T* at(int x, int y) const { return const_cast<Image*>(this)->at(x, y); }
  bool operator==(const Image&) const = default;
};

using Image8 = Image<uint8_t>;
using Image16 = Image<uint16_t>;
using ImageF = Image<float>;
using ImageU32 = Image<uint32_t>;

}  // namespace crowdbench
