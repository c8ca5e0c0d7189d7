// Based on: B. Ottosson, "A perceptual color space for image processing" (OKLab), 2020, for the spacing of the colours.
#include "metrics/pseudocolour.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "core/colour.h"
#include "metrics/mat.h"
#include "metrics/sizes.h"

namespace crowdbench::metrics {
namespace {

using Triple = std::array<double, 3>;

Triple oklab_of(const Triple& srgb8) {
  Triple linear{};
  for (size_t c = 0; c < 3; ++c) linear[c] = srgb_to_linear(srgb8[c] / 255);
  const auto [r, g, b] = linear;
  const double l = std::cbrt(0.4122214708 * r + 0.5363325363 * g + 0.0514459929 * b);
  const double m = std::cbrt(0.2119034982 * r + 0.6806995451 * g + 0.1073969566 * b);
  const double s = std::cbrt(0.0883024619 * r + 0.2817188376 * g + 0.6299787005 * b);
  return {0.2104542553 * l + 0.7936177850 * m - 0.0040720468 * s,
          1.9779984951 * l - 2.4285922050 * m + 0.4505937099 * s,
          0.0259040371 * l + 0.7827717662 * m - 0.8086757660 * s};
}

std::array<uint8_t, 3> srgb_of(const Triple& lab) {
  const double l = std::pow(lab[0] + 0.3963377774 * lab[1] + 0.2158037573 * lab[2], 3);
  const double m = std::pow(lab[0] - 0.1055613458 * lab[1] - 0.0638541728 * lab[2], 3);
  const double s = std::pow(lab[0] - 0.0894841775 * lab[1] - 1.2914855480 * lab[2], 3);
  return {linear_to_srgb8(4.0767416621 * l - 3.3077115913 * m + 0.2309699292 * s),
          linear_to_srgb8(-1.2684380046 * l + 2.6097574011 * m - 0.3413193965 * s),
          linear_to_srgb8(-0.0041960863 * l - 0.7034186147 * m + 1.7076147010 * s)};
}

double distance(const Triple& a, const Triple& b) { return std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]); }

// A polyline through OKLab, walked at constant speed. Its corners lie on the edge of what a display can show, which
// makes it long (0.9, about 45 steps that an eye can tell apart): small errors show.
ColourTable make_colours() {
  constexpr std::array<Triple, 6> kStops = {
      {{0, 0, 64}, {0, 0, 205}, {118, 0, 238}, {198, 0, 205}, {238, 0, 112}, {255, 0, 0}}};
  std::array<Triple, kStops.size()> lab{};
  std::array<double, kStops.size()> along{};
  for (size_t i = 0; i < kStops.size(); ++i) {
    lab[i] = oklab_of(kStops[i]);
    along[i] = i == 0 ? 0 : along[i - 1] + distance(lab[i - 1], lab[i]);
  }
  ColourTable colours{};
  size_t leg = 0;
  for (size_t i = 0; i < colours.size(); ++i) {
    const double at = along.back() * static_cast<double>(i) / 255;
    while (leg + 2 < kStops.size() && at > along[leg + 1]) ++leg;
    const double t = (at - along[leg]) / (along[leg + 1] - along[leg]);
    Triple mixed{};
    for (size_t c = 0; c < 3; ++c) mixed[c] = lab[leg][c] + t * (lab[leg + 1][c] - lab[leg][c]);
    colours[i] = srgb_of(mixed);
  }
  return colours;
}

template <typename T>
Image8 error_levels_of(const Image<T>& a, const Image<T>& b) {
  require_same_size(a, b);
  constexpr int kWhole = 3 * (std::numeric_limits<T>::max() / 255);
  const auto a1 = static_cast<size_t>(a.channels >= 3 ? 1 : 0);
  const auto b1 = static_cast<size_t>(b.channels >= 3 ? 1 : 0);
  Image8 out(a.width, a.height, 1);
  const T* p = a.data.data();
  const T* q = b.data.data();
  for (size_t i = 0; i < out.data.size(); ++i, p += a.channels, q += b.channels) {
    const int sum =
        std::abs(int{p[0]} - int{q[0]}) + std::abs(int{p[a1]} - int{q[b1]}) + std::abs(int{p[2 * a1]} - int{q[2 * b1]});
    out.data[i] = static_cast<uint8_t>((sum + kWhole / 2) / kWhole);
  }
  return out;
}

}  // namespace

const ColourTable& error_colours() {
  static const auto colours = make_colours();
  return colours;
}

const ColourTable& grey_colours() {
  static const auto colours = [] {
    ColourTable table{};
    for (size_t i = 0; i < table.size(); ++i) table[i].fill(static_cast<uint8_t>(255 - i));
    return table;
  }();
  return colours;
}

Image8 error_levels(const Image8& a, const Image8& b) { return error_levels_of(a, b); }
Image8 error_levels(const Image16& a, const Image16& b) { return error_levels_of(a, b); }

Image8 pseudocolour(const Image8& levels, const ColourTable& colours) {
  Image8 out(levels.width, levels.height, 3);
  for (size_t i = 0; i < levels.data.size(); ++i)
    std::copy_n(colours[levels.data[i]].begin(), 3, out.data.begin() + static_cast<ptrdiff_t>(3 * i));
  return out;
}

namespace {

// The caption in lines: broken at the "; " nearest to its middle where it does not fit.
std::vector<std::string> lines_of(const std::string& caption, bool fits) {
  size_t best = std::string::npos;
  const auto off_middle = [&](size_t at) {
    const auto twice = static_cast<int64_t>(2 * at);
    return std::abs(twice - static_cast<int64_t>(caption.size()));
  };
  for (size_t at = caption.find("; "); !fits && at != std::string::npos; at = caption.find("; ", at + 1))
    if (best == std::string::npos || off_middle(at) < off_middle(best)) best = at;
  if (best == std::string::npos) return {caption};
  return {caption.substr(0, best), caption.substr(best + 2)};
}

std::string label_of(const BarRange& range, int quarter) {
  const std::string text = fmt::format("{:.3g}", range.first + quarter / 4.0 * (range.last - range.first));
  if (quarter < 4 || !range.open) return text;
  return (range.last > range.first ? ">= " : "<= ") + text;
}

}  // namespace

Image8 colour_bar(int width, const std::string& caption, const BarRange& range, const ColourTable& colours,
                  double scale) {
  const auto scaled = [&](double pixels) { return static_cast<int>(std::lround(pixels * scale)); };
  const int thickness = std::max(1, scaled(1));
  const auto extent_of = [&](const std::string& words) {
    int below = 0;
    return cv::getTextSize(words, cv::FONT_HERSHEY_SIMPLEX, 0.4 * scale, thickness, &below).width;
  };
  const int bar_left = scaled(20);
  const std::vector<std::string> lines = lines_of(caption, extent_of(caption) + 2 * scaled(6) <= width);
  for (const std::string& line : lines) width = std::max(width, extent_of(line) + 2 * scaled(6));
  const int bar_top = scaled(10);
  const int bar_height = scaled(14);
  const int bar_width = width - 2 * bar_left;
  const int line_height = scaled(16);
  Image8 out(width, scaled(66) + static_cast<int>(lines.size() - 1) * line_height, 3);
  std::fill(out.data.begin(), out.data.end(), uint8_t{255});
  for (int x = 0; x < bar_width; ++x) {
    const auto level = static_cast<size_t>(std::lround(255.0 * x / (bar_width - 1)));
    for (int y = 0; y < bar_height; ++y) std::copy_n(colours[level].begin(), 3, out.at(bar_left + x, bar_top + y));
  }
  cv::Mat canvas = view(out);
  const cv::Scalar ink(40, 40, 40);
  // A white end of the bar would have no edge.
  cv::rectangle(canvas, {bar_left - 1, bar_top - 1}, {bar_left + bar_width, bar_top + bar_height},
                cv::Scalar(160, 160, 160), 1);
  const auto text = [&](const std::string& words, int centre, int baseline) {
    cv::putText(canvas, words, {centre - extent_of(words) / 2, baseline}, cv::FONT_HERSHEY_SIMPLEX, 0.4 * scale, ink,
                thickness, cv::LINE_AA);
  };
  for (int quarter = 0; quarter <= 4; ++quarter) {
    const int x = bar_left + static_cast<int>(std::lround(quarter / 4.0 * (bar_width - 1)));
    cv::line(canvas, {x, bar_top + bar_height}, {x, bar_top + bar_height + scaled(4)}, ink, thickness);
    const std::string label = label_of(range, quarter);
    // The last one may be wide: it stays within the picture.
    const int centre = std::min(x, width - scaled(3) - (extent_of(label) + 1) / 2);
    text(label, centre, bar_top + bar_height + scaled(17));
  }
  for (size_t line = 0; line < lines.size(); ++line)
    text(lines[line], width / 2, bar_top + bar_height + scaled(34) + static_cast<int>(line) * line_height);
  return out;
}

Image8 with_colour_bar(const Image8& picture, const std::string& caption, const BarRange& range,
                       const ColourTable& colours) {
  constexpr int kNarrowest = 360;
  const double scale = std::max(1.0, std::min(picture.width, picture.height * 2) / 960.0);
  const int least = std::max(picture.width, static_cast<int>(std::lround(kNarrowest * scale)));
  const Image8 bar = colour_bar(least, caption, range, colours, scale);
  Image8 out(bar.width, picture.height + bar.height, 3);
  std::fill(out.data.begin(), out.data.end(), uint8_t{255});
  const int left = (out.width - picture.width) / 2;
  for (int y = 0; y < picture.height; ++y)
    std::copy_n(picture.at(0, y), static_cast<size_t>(picture.width) * 3, out.at(left, y));
  std::copy(bar.data.begin(), bar.data.end(), out.at(0, picture.height));
  return out;
}

}  // namespace crowdbench::metrics
