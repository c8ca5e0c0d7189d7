#include "metrics/hdr_flip.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>

#include "metrics/not_finite.h"
#include "metrics/sizes.h"

namespace crowdbench::metrics {
namespace {

// (k0 x^2 + k1 x + k2) / (k3 x^2 + k4 x + k5)
using Curve = std::array<double, 6>;
constexpr Curve kCurves[] = {{0.36 * 2.51, 0.6 * 0.03, 0, 0.36 * 2.43, 0.6 * 0.59, 0.14},
                             {0.231683, 0.013791, 0, 0.18, 0.3, 0.018},
                             {0, 1, 0, 0, 1, 1}};
const Curve& curve_of(ToneMapper mapper) { return kCurves[static_cast<size_t>(mapper)]; }

double luminance(double r, double g, double b) { return 0.2126 * r + 0.7152 * g + 0.0722 * b; }
double luminance(const ImageF& image, const float* p) {
  return image.channels >= 3 ? luminance(p[0], p[1], p[2]) : luminance(p[0], p[0], p[0]);
}

// The greater x at which the curve is 0.85.
double bright_value(const Curve& k) {
  constexpr double kBright = 0.85;
  const double a = k[0] - kBright * k[3];
  const double b = k[1] - kBright * k[4];
  const double c = k[2] - kBright * k[5];
  if (a == 0) return -c / b;
  const double root = std::sqrt(b * b - 4 * a * c);
  return std::max((-b + root) / (2 * a), (-b - root) / (2 * a));
}

// In double: squares of what a float holds, brightened, do not overflow.
std::array<double, 3> tone_mapped(const std::array<double, 3>& rgb, ToneMapper mapper) {
  if (mapper == ToneMapper::reinhard) {
    const double over = 1 / (1 + luminance(rgb[0], rgb[1], rgb[2]));
    return {rgb[0] * over, rgb[1] * over, rgb[2] * over};
  }
  const Curve& k = curve_of(mapper);
  std::array<double, 3> out{};
  for (size_t c = 0; c < 3; ++c)
    out[c] = (k[0] * rgb[c] * rgb[c] + k[1] * rgb[c] + k[2]) / (k[3] * rgb[c] * rgb[c] + k[4] * rgb[c] + k[5]);
  return out;
}

LinearRow exposed(const ImageF& image, double exposure, ToneMapper mapper) {
  const double factor = std::exp2(exposure);
  const int g = image.channels >= 3 ? 1 : 0;
  return [&image, factor, g, mapper](int y, int first, int last, float* red, float* green, float* blue) {
    const float* p = image.at(first, y);
    for (int x = first; x < last; ++x, p += image.channels) {
      const auto rgb = tone_mapped({factor * p[0], factor * p[g], factor * p[2 * g]}, mapper);
      const auto held = [](double v) { return static_cast<float>(std::clamp(v, 0.0, 1.0)); };
      *red++ = held(rgb[0]);
      *green++ = held(rgb[1]);
      *blue++ = held(rgb[2]);
    }
  };
}

ExposureRange none(ExposureRange range, std::string reason) {
  range.reason = std::move(reason);
  return range;
}

}  // namespace

ExposureRange exposure_range(const ImageF& reference, const HdrFlipSettings& settings) {
  ExposureRange range;
  if (!settings.start || !settings.stop) {
    std::vector<double> all;
    all.reserve(reference.pixels());
    for (size_t i = 0; i < reference.pixels(); ++i)
      all.push_back(luminance(reference, reference.data.data() + i * static_cast<size_t>(reference.channels)));
    const double most = *std::max_element(all.begin(), all.end());
    const auto middle = all.begin() + static_cast<std::ptrdiff_t>(all.size() / 2);
    std::nth_element(all.begin(), middle, all.end());
    const double bright = bright_value(curve_of(settings.tone_mapper));
    if (!settings.start && most <= 0) return none(range, "the reference is black, so that no exposure follows from it");
    if (!settings.stop && *middle <= 0)
      return none(range, "the reference's median luminance is 0, so that no exposure follows from it");
    if (!settings.start) range.start = std::log2(bright / most);
    if (!settings.stop) range.stop = std::log2(bright / *middle);
  }
  range.start = settings.start.value_or(range.start);
  range.stop = settings.stop.value_or(range.stop);
  if (range.start > range.stop) return none(range, "the exposures would start above where they stop");
  range.exposures = settings.exposures.value_or(std::max(2, static_cast<int>(std::ceil(range.stop - range.start))));
  assert(range.exposures >= 2);
  return range;
}

HdrFlip hdr_flip(const ImageF& reference, const ImageF& test, const HdrFlipSettings& settings) {
  require_same_size(reference, test);
  assert(not_finite(reference).pixels() == 0 && not_finite(test).pixels() == 0);
  HdrFlip out;
  out.range = exposure_range(reference, settings);
  if (!out.range.reason.empty()) return out;
  out.map = out.exposure = ImageF(reference.width, reference.height, 1);
  for (int i = 0; i < out.range.exposures; ++i) {
    const double exposure = out.range.at(i);
    const ImageF one = flip_map(reference.width, reference.height, exposed(reference, exposure, settings.tone_mapper),
                                exposed(test, exposure, settings.tone_mapper), settings.flip);
    const float place = static_cast<float>(i) / static_cast<float>(out.range.exposures - 1);
    for (size_t p = 0; p < one.data.size(); ++p) {
      if (one.data[p] <= out.map.data[p]) continue;
      out.map.data[p] = one.data[p];
      out.exposure.data[p] = place;
    }
  }
  return out;
}

}  // namespace crowdbench::metrics
