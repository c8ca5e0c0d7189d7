// What a pop map found, as its page and its charts show it.
#pragma once
#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace crowdbench::reports {

// The four kinds of switch, in this order everywhere: the mesh in its own pose or in the stored frame's, at a cut or
// by the worst step of a cross-fade.
constexpr size_t kPopSwitchKinds = 4;
extern const std::array<const char*, kPopSwitchKinds> kPopSwitchTitles;

// One view and moment. Scores are over the union of the silhouettes, in the order of the page's descriptions; nothing
// where one does not exist.
struct PopPoint {
  double ratio = 0;      // pixels a texel spans; 0: the representation has no texels
  double height_px = 0;  // the character's
  double azimuth_deg = 0, elevation_deg = 0, phase = 0;
  std::vector<std::array<std::optional<double>, kPopSwitchKinds>> scores;
};

// Of one score over points. tail: the 95th percentile where lower is better, else the 5th.
struct PopSummary {
  double mean = 0, tail = 0, worst = 0;
  PopPoint worst_at;
};
struct PopPicture {
  std::string caption;
  int width = 0, height = 0;
  std::vector<uint8_t> png;
};
// One size of the figure.
struct PopSize {
  std::vector<PopPoint> points;
  std::vector<std::array<std::optional<PopSummary>, kPopSwitchKinds>> summaries;  // by score, as in the points
  std::vector<PopPicture> worst;  // of the point whose own-pose cut is the worst by the ranking score
  std::vector<PopPicture> fade;   // the cross-fade at that cell, first to last tick
};

// "1 px a texel, 114 px tall"
std::string pop_size_text(const PopPoint& point);

}  // namespace crowdbench::reports
