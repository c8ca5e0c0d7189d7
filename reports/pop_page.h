// The page of a pop map: what a switch from the mesh to another representation would show, over views, phases and
// sizes.
#pragma once
#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace crowdbench::reports {

// The four ways of switching, in this order everywhere: the mesh in its own pose or in the stored frame's, at a cut or
// by the worst step of a cross-fade.
constexpr size_t kPopWays = 4;
extern const std::array<const char*, kPopWays> kPopWayTitles;

// Mean over the union of the silhouettes; nothing where it does not exist. mae in code values, ssim_union in [-1, 1].
struct PopPoint {
  double ratio = 0;      // pixels a texel spans; 0: the representation has no texels
  double height_px = 0;  // the character's
  double azimuth_deg = 0, elevation_deg = 0, phase = 0;
  std::array<std::optional<double>, kPopWays> mae, ssim_union;
};

// tail: the 95th percentile of mae, the 5th of ssim_union.
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
  std::array<std::optional<PopSummary>, kPopWays> mae, ssim_union;
  std::vector<PopPicture> worst;  // of the cell whose own-pose cut has the largest mae
  std::vector<PopPicture> fade;   // the cross-fade at that cell, first to last tick
};

struct PopPage {
  std::string representation, character, clip, renderer, program;  // program: name, version and revision
  bool software = false;                                           // drawn by a software rasteriser
  int fade = 0;                                                    // ticks
  std::vector<PopSize> sizes;
};

// "1 px a texel, 114 px tall"
std::string pop_size_text(const PopPoint& point);
// Azimuth by elevation, a panel a clip phase and way; colours from 0 to `high` code values, the same in every chart.
std::string pop_chart(const PopSize& size, double high);
// One self-contained HTML page that opens without a network. Throws Error when the program was built without the chart
// library.
std::string pop_page(const PopPage& page);

}  // namespace crowdbench::reports
