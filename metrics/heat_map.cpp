#include "metrics/heat_map.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "metrics/mat.h"
#include "metrics/pseudocolour.h"

namespace crowdbench::metrics {
namespace {

constexpr int kCellWidth = 44;
constexpr int kCellHeight = 26;
constexpr int kLabel = 40;  // left of a panel, for its rows
constexpr int kTitle = 24;
constexpr int kFoot = 20;  // below a panel, for its columns
constexpr int kGap = 14;
constexpr int kBar = 64;
constexpr double kText = 0.38;

int text_width(const std::string& words) {
  int below = 0;
  return cv::getTextSize(words, cv::FONT_HERSHEY_SIMPLEX, kText, 1, &below).width;
}

int panel_width(const HeatPanel& p) {
  return kLabel + std::max(kCellWidth * static_cast<int>(p.columns.size()), text_width(p.title)) + kGap;
}
int panel_height(const HeatPanel& p) { return kTitle + kCellHeight * static_cast<int>(p.rows.size()) + kFoot + kGap; }

void write(const cv::Mat& canvas, const std::string& words, int x, int baseline, const cv::Scalar& ink, bool centred) {
  cv::putText(canvas, words, {centred ? x - text_width(words) / 2 : x, baseline}, cv::FONT_HERSHEY_SIMPLEX, kText, ink,
              1, cv::LINE_AA);
}

const cv::Scalar kInk(40, 40, 40);

void draw_panel(const cv::Mat& canvas, const HeatPanel& panel, int left, int top, double high) {
  assert(panel.values.size() == panel.rows.size() * panel.columns.size());
  write(canvas, panel.title, left + kLabel, top + 16, kInk, false);
  for (size_t r = 0; r < panel.rows.size(); ++r) {
    const int y = top + kTitle + kCellHeight * static_cast<int>(r);
    write(canvas, panel.rows[r], left + 4, y + 17, kInk, false);
    for (size_t c = 0; c < panel.columns.size(); ++c) {
      const double value = panel.values[r * panel.columns.size() + c];
      const int x = left + kLabel + kCellWidth * static_cast<int>(c);
      const std::array<uint8_t, 3> rgb = heat_colour(value, high);
      cv::rectangle(canvas, cv::Rect(x, y, kCellWidth - 1, kCellHeight - 1), cv::Scalar(rgb[0], rgb[1], rgb[2]),
                    cv::FILLED);
      const double luma = 0.299 * rgb[0] + 0.587 * rgb[1] + 0.114 * rgb[2];
      const cv::Scalar ink = luma > 140 ? cv::Scalar(0, 0, 0) : cv::Scalar(255, 255, 255);
      if (!std::isnan(value)) write(canvas, fmt::format("{:.3g}", value), x + kCellWidth / 2, y + 17, ink, true);
    }
  }
  for (size_t c = 0; c < panel.columns.size(); ++c)
    write(canvas, panel.columns[c], left + kLabel + kCellWidth * static_cast<int>(c) + kCellWidth / 2,
          top + kTitle + kCellHeight * static_cast<int>(panel.rows.size()) + 14, kInk, true);
}

}  // namespace

std::array<uint8_t, 3> heat_colour(double value, double high) {
  if (std::isnan(value)) return {200, 200, 200};
  return error_colours()[static_cast<size_t>(std::lround(255 * std::clamp(value / high, 0.0, 1.0)))];
}

Image8 heat_map(const std::vector<std::vector<HeatPanel>>& panels, double high, const std::string& caption) {
  assert(high > 0);
  int width = std::max(420, text_width(caption) + 2 * kGap);
  int height = kGap;
  std::vector<int> heights;
  for (const auto& row : panels) {
    int across = kGap;
    int tallest = 0;
    for (const HeatPanel& p : row) {
      across += panel_width(p);
      tallest = std::max(tallest, panel_height(p));
    }
    width = std::max(width, across);
    heights.push_back(tallest);
    height += tallest;
  }
  Image8 out(width, height + kBar, 3);
  std::fill(out.data.begin(), out.data.end(), uint8_t{255});
  const cv::Mat canvas = view(out);
  int top = kGap;
  for (size_t r = 0; r < panels.size(); ++r) {
    int left = kGap;
    for (const HeatPanel& p : panels[r]) {
      draw_panel(canvas, p, left, top, high);
      left += panel_width(p);
    }
    top += heights[r];
  }
  const int bar_width = std::min(width - 2 * kLabel, 640);
  const int bar_left = (width - bar_width) / 2;
  for (int x = 0; x < bar_width; ++x) {
    const std::array<uint8_t, 3> rgb = heat_colour(x, bar_width - 1);
    for (int y = 0; y < 12; ++y) std::copy(rgb.begin(), rgb.end(), out.at(bar_left + x, height + y));
  }
  for (int quarter = 0; quarter <= 4; ++quarter)
    write(canvas, fmt::format("{:.3g}", high * quarter / 4), bar_left + quarter * (bar_width - 1) / 4, height + 28,
          kInk, true);
  write(canvas, caption, width / 2, height + 48, kInk, true);
  return out;
}

}  // namespace crowdbench::metrics
