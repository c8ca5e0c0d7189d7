#include "metrics/difference.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>

#include "core/float_traps.h"
#include "metrics/intermediates.h"
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
Image8 over_of(const Image<T>& image, const std::array<uint8_t, 3>& colour, OverRounding rounding) {
  constexpr uint64_t kMax = std::numeric_limits<T>::max();
  const uint64_t half = rounding == OverRounding::nearest ? kMax * kMax / 2 : 0;
  Image8 out(image.width, image.height, 3);
  const auto channels = static_cast<size_t>(image.channels);
  const size_t step = channels >= 3 ? 1 : 0;
  const T* p = image.data.data();
  for (size_t i = 0; i < out.pixels(); ++i, p += channels) {
    const uint64_t alpha = channels == 4 ? p[3] : kMax;
    for (size_t c = 0; c < 3; ++c) {
      // In units of 1 / kMax^2 of full scale.
      const uint64_t sum = p[c * step] * alpha + colour[c] * (kMax / 255) * (kMax - alpha);
      out.data[i * 3 + c] = static_cast<uint8_t>((sum * 255 + half) / (kMax * kMax));
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

Image8 over(const Image8& image, const std::array<uint8_t, 3>& colour, OverRounding rounding) {
  return over_of(image, colour, rounding);
}
Image8 over(const Image16& image, const std::array<uint8_t, 3>& colour, OverRounding rounding) {
  return over_of(image, colour, rounding);
}

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
  // Of equal infinities a compiler may form the difference that is not taken.
  const FloatFaultsMeant infinities;
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

namespace {

struct RegionDifference {
  std::optional<Difference> of;
};
struct LinearErrors {
  LinearDifference of;
};

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr std::string_view kEmptyRegion = "no pixel is in the region";

// Calls use(reference, test) with both pictures as they are, 8 or 16 bits.
template <typename Use>
auto with_codes(const ScoreInput& input, const Use& use) {
  return input.reference.codes && input.test.codes ? use(*input.reference.codes, *input.test.codes)
                                                   : use(*input.reference.codes16, *input.test.codes16);
}

// The sum over R, G, B of use(|difference|) at a pixel, the differences in code values.
template <typename T, typename Use>
double sum_at(const Image<T>& a, const Image<T>& b, int x, int y, const Use& use) {
  const T* p = a.at(x, y);
  const T* q = b.at(x, y);
  const size_t a1 = a.channels >= 3 ? 1 : 0;
  const size_t b1 = b.channels >= 3 ? 1 : 0;
  double sum = 0;
  for (size_t c = 0; c < 3; ++c) sum += use(std::abs(int{p[c * a1]} - int{q[c * b1]}) / kUnit<T>);
  return sum;
}
double itself(double d) { return d; }
double square(double d) { return d * d; }

// The mean of the same over an agent's pixels and R, G, B.
template <typename Use>
double mean_of_agent(const ScoreInput& input, const AgentPixels& agent, const Use& use) {
  return with_codes(input, [&](const auto& a, const auto& b) {
    double sum = 0;
    for (const auto& [x, y] : agent.pixels) sum += sum_at(a, b, x, y, use);
    return sum / (3 * static_cast<double>(agent.pixels.size()));
  });
}

ScoreResult of_region(const ScoreInput& input, Shared& shared, double Difference::*member) {
  const std::optional<Difference>& d = region_difference(input, shared);
  if (!d) return absent(std::string(kEmptyRegion));
  ScoreResult result;
  result.value = (*d).*member;
  return result;
}

ScoreResult mae(const ScoreInput& input, Shared& shared) {
  ScoreResult result = of_region(input, shared, &Difference::mae);
  if (!input.maps) return result;
  ScoreMap& map = result.map.emplace();
  map.worst = 255;
  map.unit = "code values";
  map.values = with_codes(input, [](const auto& a, const auto& b) {
    Plane values(a.width, a.height, 1);
    for (int y = 0; y < a.height; ++y)
      for (int x = 0; x < a.width; ++x) *values.at(x, y) = sum_at(a, b, x, y, itself) / 3;
    return values;
  });
  return result;
}

const LinearDifference& linear_errors(const ScoreInput& input, Shared& shared) {
  return shared
      .get<LinearErrors>([&] { return LinearErrors{linear_difference(*input.reference.linear, *input.test.linear)}; })
      .of;
}

// What is not finite has no distance from anything, from the same infinity either: it is counted and placed instead.
ScoreResult finite(double LinearDifference::*member, const ScoreInput& input, Shared& shared) {
  if (const std::string& reason = not_finite_reason(input, shared); !reason.empty()) return absent_not_finite(reason);
  ScoreResult result;
  result.value = linear_errors(input, shared).*member;
  return result;
}

constexpr std::string_view kNotFinite = "a pixel is not a number or infinite";

}  // namespace

const LumaPair& luma_pair(const ScoreInput& input, Shared& shared) {
  return shared.get<LumaPair>([&] {
    return with_codes(input, [](const auto& a, const auto& b) { return LumaPair{luma601(a), luma601(b)}; });
  });
}

const std::optional<Difference>& region_difference(const ScoreInput& input, Shared& shared) {
  return shared
      .get<RegionDifference>([&] {
        return with_codes(
            input, [&](const auto& a, const auto& b) { return RegionDifference{difference(a, b, input.region)}; });
      })
      .of;
}

extern const Score score_mae = {
    .name = "mae",
    .title = "mean absolute error",
    .column = "MAE",
    .unit = "code values",
    .direction = Direction::lower_is_better,
    .digits = 2,
    .least = 0,
    .greatest = 255,
    .needs = kNeedsCodes,
    .scope = Scope::region,
    .uses = kInTables | kRanking,
    .computes = "mean of abs(a - b) over pixels and R, G, B",
    .source = "",
    .absence = kEmptyRegion,
    .map_file = "error_pseudocolour",
    .compute = mae,
    .by_agent = [](const ScoreInput& input, Shared&, const AgentPixels& agent) -> std::optional<double> {
      return mean_of_agent(input, agent, itself);
    },
};

extern const Score score_mse = {
    .name = "mse",
    .title = "mean squared error",
    .column = "MSE",
    .unit = "code values squared",
    .direction = Direction::lower_is_better,
    .digits = 2,
    .least = 0,
    .greatest = 255.0 * 255.0,
    .needs = kNeedsCodes,
    .scope = Scope::region,
    .computes = "mean of (a - b)^2 over pixels and R, G, B",
    .source = "",
    .absence = kEmptyRegion,
    .compute = [](const ScoreInput& input, Shared& shared) { return of_region(input, shared, &Difference::mse); },
    .by_agent = [](const ScoreInput& input, Shared&, const AgentPixels& agent) -> std::optional<double> {
      return mean_of_agent(input, agent, square);
    },
};

extern const Score score_psnr = {
    .name = "psnr",
    .title = "PSNR",
    .column = "PSNR",
    .unit = "dB",
    .direction = Direction::higher_is_better,
    .digits = 2,
    .least = 0,
    .greatest = kInfinity,
    .needs = kNeedsCodes,
    .scope = Scope::region,
    .uses = kInTables,
    .computes = "10 log10(255^2 / mse); infinite where the pictures are equal",
    .source = "",
    .absence = kEmptyRegion,
    .compute = [](const ScoreInput& input, Shared& shared) { return of_region(input, shared, &Difference::psnr); },
    .by_agent = [](const ScoreInput& input, Shared&, const AgentPixels& agent) -> std::optional<double> {
      const double mse = mean_of_agent(input, agent, square);
      return mse == 0 ? kInfinity : 10 * std::log10(255.0 * 255.0 / mse);
    },
};

extern const Score score_linear_mae = {
    .name = "linear_mae",
    .title = "mean absolute error of floats",
    .column = "lin MAE",
    .unit = "",
    .direction = Direction::lower_is_better,
    .digits = 6,
    .least = 0,
    .greatest = kInfinity,
    .needs = kNeedsLinear,
    .computes = "mean of abs(a - b) over pixels and colours, in the pictures' own unit",
    .source = "",
    .absence = kNotFinite,
    .compute = [](const ScoreInput& input, Shared& shared) { return finite(&LinearDifference::mae, input, shared); },
};

extern const Score score_linear_rms = {
    .name = "linear_rms",
    .title = "root mean square error of floats",
    .column = "lin RMS",
    .unit = "",
    .direction = Direction::lower_is_better,
    .digits = 6,
    .least = 0,
    .greatest = kInfinity,
    .needs = kNeedsLinear,
    .computes = "root of the mean of (a - b)^2 over pixels and colours, in the pictures' own unit",
    .source = "",
    .absence = kNotFinite,
    .compute = [](const ScoreInput& input, Shared& shared) { return finite(&LinearDifference::rms, input, shared); },
};

}  // namespace crowdbench::metrics
