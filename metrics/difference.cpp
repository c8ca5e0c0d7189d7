#include "metrics/difference.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>

#include "metrics/sizes.h"

namespace crowdbench::metrics {
namespace {

// Code values are the stored ones over this.
template <typename T>
constexpr double kUnit = std::numeric_limits<T>::max() / 255.0;

// Calls use(x, y, dr, dg, db) with the absolute differences of every pixel in reading order; grey is repeated.
template <typename T, typename Use>
void for_each_pair(const Image<T>& a, const Image<T>& b, const Use& use) {
  const size_t a1 = a.channels >= 3 ? 1 : 0;
  const size_t b1 = b.channels >= 3 ? 1 : 0;
  for (int y = 0; y < a.height; ++y) {
    const T* p = a.at(0, y);
    const T* q = b.at(0, y);
    for (int x = 0; x < a.width; ++x, p += a.channels, q += b.channels)
      use(x, y, std::abs(int{p[0]} - int{q[0]}), std::abs(int{p[a1]} - int{q[b1]}),
          std::abs(int{p[2 * a1]} - int{q[2 * b1]}));
  }
}

template <typename T>
Plane luma_of(const Image<T>& image) {
  Plane plane(image.width, image.height, 1);
  const auto channels = static_cast<size_t>(image.channels);
  const T* p = image.data.data();
  if (channels < 3) {
    for (size_t i = 0; i < plane.data.size(); ++i) plane.data[i] = p[i * channels] / kUnit<T>;
    return plane;
  }
  for (size_t i = 0; i < plane.data.size(); ++i, p += channels)
    plane.data[i] = (0.299 * p[0] + 0.587 * p[1] + 0.114 * p[2]) / kUnit<T>;
  return plane;
}

template <typename T>
std::optional<Difference> difference_of(const Image<T>& a, const Image<T>& b, const Mask* mask) {
  require_same_size(a, b);
  if (mask) require_same_size(a, *mask);
  uint64_t sum = 0;
  uint64_t squares = 0;
  int worst = -1;
  Difference out;
  for_each_pair(a, b, [&](int x, int y, int d0, int d1, int d2) {
    if (mask && *mask->at(x, y) == 0) return;
    ++out.pixels;
    const auto u0 = static_cast<uint64_t>(d0);
    const auto u1 = static_cast<uint64_t>(d1);
    const auto u2 = static_cast<uint64_t>(d2);
    sum += u0 + u1 + u2;
    squares += u0 * u0 + u1 * u1 + u2 * u2;
    const int most = std::max({d0, d1, d2});
    if (most > worst) {
      worst = most;
      out.worst_x = x;
      out.worst_y = y;
    }
  });
  if (out.pixels == 0) return std::nullopt;
  const double samples = 3.0 * static_cast<double>(out.pixels);
  out.mae = static_cast<double>(sum) / samples / kUnit<T>;
  out.mse = static_cast<double>(squares) / samples / (kUnit<T> * kUnit<T>);
  out.psnr = squares == 0 ? std::numeric_limits<double>::infinity() : 10 * std::log10(255.0 * 255.0 / out.mse);
  out.worst = worst / kUnit<T>;
  return out;
}

template <typename T>
Image8 absolute_difference_of(const Image<T>& a, const Image<T>& b) {
  require_same_size(a, b);
  Image8 out(a.width, a.height, 3);
  uint8_t* o = out.data.data();
  constexpr int kStep = std::numeric_limits<T>::max() / 255;
  const auto rounded = [](int d) { return static_cast<uint8_t>((d + kStep / 2) / kStep); };
  for_each_pair(a, b, [&](int, int, int d0, int d1, int d2) {
    *o++ = rounded(d0);
    *o++ = rounded(d1);
    *o++ = rounded(d2);
  });
  return out;
}

template <typename T>
Image8 over_of(const Image<T>& image, const std::array<uint8_t, 3>& colour) {
  constexpr uint64_t kMax = std::numeric_limits<T>::max();
  Image8 out(image.width, image.height, 3);
  const auto channels = static_cast<size_t>(image.channels);
  const size_t step = channels >= 3 ? 1 : 0;
  const T* p = image.data.data();
  for (size_t i = 0; i < out.pixels(); ++i, p += channels) {
    const uint64_t alpha = channels == 4 ? p[3] : kMax;
    for (size_t c = 0; c < 3; ++c) {
      // In units of 1 / kMax^2 of full scale.
      const uint64_t sum = p[c * step] * alpha + colour[c] * (kMax / 255) * (kMax - alpha);
      out.data[i * 3 + c] = static_cast<uint8_t>(sum * 255 / (kMax * kMax));
    }
  }
  return out;
}

}  // namespace

Plane luma601(const Image8& image) { return luma_of(image); }
Plane luma601(const Image16& image) { return luma_of(image); }

Image16 widen(const Image8& image) {
  Image16 out(image.width, image.height, image.channels);
  for (size_t i = 0; i < out.data.size(); ++i) out.data[i] = static_cast<uint16_t>(image.data[i] * 257);
  return out;
}

Image8 over(const Image8& image, const std::array<uint8_t, 3>& colour) { return over_of(image, colour); }
Image8 over(const Image16& image, const std::array<uint8_t, 3>& colour) { return over_of(image, colour); }

std::optional<Difference> difference(const Image8& a, const Image8& b, const Mask* mask) {
  return difference_of(a, b, mask);
}
std::optional<Difference> difference(const Image16& a, const Image16& b, const Mask* mask) {
  return difference_of(a, b, mask);
}

Image8 absolute_difference(const Image8& a, const Image8& b) { return absolute_difference_of(a, b); }
Image8 absolute_difference(const Image16& a, const Image16& b) { return absolute_difference_of(a, b); }

LinearDifference linear_difference(const ImageF& a, const ImageF& b) {
  require_same_size(a, b);
  const size_t colours = a.channels >= 3 || b.channels >= 3 ? 3 : 1;
  const size_t a1 = a.channels >= 3 ? 1 : 0;
  const size_t b1 = b.channels >= 3 ? 1 : 0;
  double sum = 0;
  double squares = 0;
  for (int y = 0; y < a.height; ++y) {
    const float* p = a.at(0, y);
    const float* q = b.at(0, y);
    for (int x = 0; x < a.width; ++x, p += a.channels, q += b.channels) {
      for (size_t c = 0; c < colours; ++c) {
        const double u = p[c * a1];
        const double v = q[c * b1];
        const double d = u == v ? 0 : std::abs(u - v);
        sum += d;
        squares += d * d;
      }
    }
  }
  const double samples = static_cast<double>(a.pixels() * colours);
  return {sum / samples, std::sqrt(squares / samples)};
}

}  // namespace crowdbench::metrics
