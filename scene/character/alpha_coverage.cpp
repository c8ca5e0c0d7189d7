#include "scene/character/alpha_coverage.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <utility>

namespace crowdbench::scene {
namespace {

constexpr int kCells = 16;          // a side, at most: places that are compared
constexpr int kTexelsOfCell = 4;    // a side, at least: a coarser level is compared in fewer cells
constexpr double kOff = 0.03;       // of the area that is there
constexpr double kElsewhere = 0.2;  // of what cells hold that are neither clear nor solid
constexpr int kLines = 4;           // looked at across a texel
constexpr int kHalvings = 14;       // of the logarithm of the scale

using Codes = std::array<float, 256>;  // alpha by stored code

// The share of [0, 1] in which a value that runs evenly from a to b is at least `threshold`.
double part_above(double a, double b, double threshold) {
  if (a >= threshold && b >= threshold) return 1;
  if (a < threshold && b < threshold) return 0;
  const double at = (threshold - a) / (b - a);
  return b > a ? 1 - at : at;
}

// The share of the square between four texels that is there: exactly along the axis on which alpha changes more, by
// lines across the other.
double part_of_square(const std::array<double, 4>& corners, double threshold) {
  const auto [least, most] = std::ranges::minmax(corners);
  if (least >= threshold) return 1;
  if (most < threshold) return 0;
  auto [a, b, c, d] = corners;  // a b above, c d below
  if (std::abs(b - a) + std::abs(d - c) < std::abs(c - a) + std::abs(d - b)) std::swap(b, c);
  double sum = 0;
  for (int line = 0; line < kLines; ++line) {
    const double down = (line + 0.5) / kLines;
    sum += part_above(a + (c - a) * down, b + (d - b) * down, threshold);
  }
  return sum / kLines;
}

size_t step(size_t at, int by, size_t size, bool repeat) {
  if (by < 0) return at > 0 ? at - 1 : repeat ? size - 1 : at;
  return by == 0 || at + 1 < size ? at + static_cast<size_t>(by) : repeat ? 0 : at;
}

// A level with what lies about each texel, so that few have to be looked at closely.
struct Prepared {
  const AlphaLevel& level;
  AlphaSampling sampling;
  std::vector<uint8_t> least, most;  // of a texel and, where what lies between counts, its eight neighbours

  Prepared(const AlphaLevel& level_, const AlphaSampling& sampling_)
      : level(level_), sampling(sampling_), least(level_.alpha), most(level_.alpha) {
    if (!sampling.linear) return;
    for (const bool across : {true, false}) {
      const std::vector<uint8_t> low = least;
      const std::vector<uint8_t> high = most;
      for (size_t y = 0; y < height(); ++y)
        for (size_t x = 0; x < width(); ++x)
          for (const int by : {-1, 1}) {
            const size_t other = across ? at(x, y, by, 0) : at(x, y, 0, by);
            const size_t own = y * width() + x;
            least[own] = std::min(least[own], low[other]);
            most[own] = std::max(most[own], high[other]);
          }
    }
  }
  size_t width() const { return static_cast<size_t>(level.width); }
  size_t height() const { return static_cast<size_t>(level.height); }
  size_t at(size_t x, size_t y, int right, int down) const {
    return step(y, down, height(), sampling.repeat_v) * width() + step(x, right, width(), sampling.repeat_u);
  }
};

// The share of a texel that is there: of the four quarters to its neighbours.
double part_of_texel(const Prepared& of, const Codes& codes, size_t x, size_t y, double threshold) {
  const auto value = [&](int right, int down) {
    return static_cast<double>(codes[of.level.alpha[of.at(x, y, right, down)]]);
  };
  const double own = value(0, 0);
  double sum = 0;
  for (const int down : {-1, 1})
    for (const int right : {-1, 1}) {
      const double beside = value(right, 0);
      const double below = value(0, down);
      sum += part_of_square(
          {own, 0.5 * (own + beside), 0.5 * (own + below), 0.25 * (own + beside + below + value(right, down))},
          threshold);
    }
  return sum / 4;
}

// The share that is there, by cells of side x side.
std::vector<double> cells_of(const Prepared& of, const Codes& codes, double threshold, int side) {
  const auto cells = static_cast<size_t>(side);
  std::vector<double> sums(cells * cells, 0.0);
  std::vector<double> counts(cells * cells, 0.0);
  const auto there = [&](uint8_t code) { return static_cast<double>(codes[code]) >= threshold; };
  for (size_t y = 0; y < of.height(); ++y)
    for (size_t x = 0; x < of.width(); ++x) {
      const size_t cell = y * cells / of.height() * cells + x * cells / of.width();
      const size_t own = y * of.width() + x;
      counts[cell] += 1;
      if (there(of.least[own]))
        sums[cell] += 1;
      else if (there(of.most[own]))
        sums[cell] += part_of_texel(of, codes, x, y, threshold);
    }
  for (size_t i = 0; i < sums.size(); ++i) sums[i] /= counts[i];
  return sums;
}

int side_for(const AlphaLevel& level, int most) {
  int side = most;
  while (side > 1 && std::min(level.width, level.height) < side * kTexelsOfCell) side /= 2;
  return side;
}

double mean(const std::vector<double>& values) {
  return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

std::vector<double> merged(const std::vector<double>& cells, int from, int to) {
  const int each = from / to;
  std::vector<double> out(static_cast<size_t>(to) * static_cast<size_t>(to), 0.0);
  for (int y = 0; y < from; ++y)
    for (int x = 0; x < from; ++x)
      out[static_cast<size_t>(y / each * to + x / each)] += cells[static_cast<size_t>(y * from + x)] / (each * each);
  return out;
}

uint8_t scaled(int code, double scale) {
  return static_cast<uint8_t>(std::lround(std::min(static_cast<double>(code) * scale, 255.0)));
}

Codes codes_of(double scale) {
  Codes codes{};
  for (int code = 0; code < 256; ++code)
    codes[static_cast<size_t>(code)] = static_cast<float>(scaled(code, scale)) / 255.0F;
  return codes;
}

}  // namespace

float alpha_threshold(const Material& material) {
  if (material.alpha_cutoff <= 0) return 0;
  return material.base_colour.a > 0 ? std::min(material.alpha_cutoff / material.base_colour.a, 2.0F) : 2.0F;
}

double alpha_coverage(std::span<const uint8_t> rgba, float threshold) {
  size_t there = 0;
  for (size_t i = 3; i < rgba.size(); i += 4) there += static_cast<float>(rgba[i]) / 255.0F >= threshold ? 1 : 0;
  return static_cast<double>(there) / (0.25 * static_cast<double>(rgba.size()));
}

CoverageKeeper::CoverageKeeper(const AlphaLevel& base, float threshold, const AlphaSampling& near,
                               const AlphaSampling& far)
    : threshold_(threshold),
      far_(far),
      side_(side_for(base, kCells)),
      cells_(cells_of(Prepared(base, near), codes_of(1), static_cast<double>(threshold), side_)) {}

double CoverageKeeper::covered() const { return mean(cells_); }

bool CoverageKeeper::keep(AlphaLevel& level) const {
  const int side = side_for(level, side_);
  const std::vector<double> wanted = merged(cells_, side_, side);
  const double area = mean(wanted);
  const Prepared prepared(level, far_);
  const auto cells_at = [&](double scale) {
    return cells_of(prepared, codes_of(scale), static_cast<double>(threshold_), side);
  };
  double low = -8;  // logarithms to the base of 2
  double high = 8;
  for (int i = 0; i < kHalvings; ++i) {
    const double middle = 0.5 * (low + high);
    (mean(cells_at(std::exp2(middle))) < area ? low : high) = middle;
  }
  const auto off_by = [&](const std::vector<double>& cells) { return std::abs(mean(cells) - area); };
  std::vector<double> cells = cells_at(std::exp2(high));
  double scale = std::exp2(high);
  if (std::vector<double> lower = cells_at(std::exp2(low)); off_by(lower) < off_by(cells)) {
    cells = std::move(lower);
    scale = std::exp2(low);
  }
  double elsewhere = 0;
  double partly = 0;
  for (size_t i = 0; i < cells.size(); ++i) {
    elsewhere += std::abs(cells[i] - wanted[i]);
    partly += std::min(wanted[i], 1 - wanted[i]);
  }
  if (off_by(cells) > kOff * area || elsewhere > kElsewhere * partly + 1e-9) return false;
  for (uint8_t& alpha : level.alpha) alpha = scaled(alpha, scale);
  return true;
}

}  // namespace crowdbench::scene
