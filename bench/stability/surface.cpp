#include "bench/stability/surface.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

namespace crowdbench::bench {
namespace {

using renderers::Capture;

// Largest of the (2 r + 1) x (2 r + 1) pixels around each; outside the picture counts for nothing.
std::vector<uint8_t> grown(const std::vector<uint8_t>& mask, int width, int height, int r) {
  std::vector<uint8_t> rows(mask.size());
  std::vector<uint8_t> out(mask.size());
  const auto at = [&](int x, int y) {
    return static_cast<size_t>(y) * static_cast<size_t>(width) + static_cast<size_t>(x);
  };
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      for (int i = std::max(0, x - r); i <= std::min(width - 1, x + r); ++i) rows[at(x, y)] |= mask[at(i, y)];
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      for (int j = std::max(0, y - r); j <= std::min(height - 1, y + r); ++j) out[at(x, y)] |= rows[at(x, j)];
  return out;
}

struct Silhouette {
  uint64_t holes = 0, strays = 0;
  int x = 0, y = 0;  // the first
};

// Holes farther than r pixels inside the mesh's figure, and strays farther than r outside.
Silhouette compare_silhouettes(const Capture& mesh, const Capture& drawn, int r) {
  const int width = mesh.ids.width;
  const int height = mesh.ids.height;
  std::vector<uint8_t> inside(mesh.ids.data.size());
  std::vector<uint8_t> outside(mesh.ids.data.size());
  for (size_t i = 0; i < inside.size(); ++i) {
    inside[i] = mesh.ids.data[i] != 0 ? 1 : 0;
    outside[i] = mesh.ids.data[i] == 0 ? 1 : 0;
  }
  const std::vector<uint8_t> near_figure = grown(inside, width, height, r);
  const std::vector<uint8_t> near_air = grown(outside, width, height, r);
  Silhouette out;
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const size_t i = static_cast<size_t>(y) * static_cast<size_t>(width) + static_cast<size_t>(x);
      const bool shown = drawn.ids.data[i] != 0;
      const bool hole = !shown && near_air[i] == 0;
      const bool stray = shown && near_figure[i] == 0;
      if ((hole || stray) && out.holes + out.strays == 0) {
        out.x = x;
        out.y = y;
      }
      out.holes += hole ? 1U : 0U;
      out.strays += stray ? 1U : 0U;
    }
  return out;
}

}  // namespace

double nearest_depth(const Capture& capture) {
  float least = std::numeric_limits<float>::infinity();
  for (const float depth : capture.depth.data) least = std::min(least, depth);
  return static_cast<double>(least);
}

Found wrong_beside(const Capture& mesh, const Capture& drawn, const scene::Frame& frame, int band) {
  const Insane insane = insane_pixels(drawn, frame);
  Found found;
  found.measured = static_cast<double>(insane.pixels);
  if (insane.pixels > 0) {
    found.place = fmt::format("pixel ({}, {})", insane.x, insane.y);
    found.expected = "a finite depth of an agent between the planes, or nothing";
    found.got = insane.what;
  }
  if (2 * band >= std::min(frame.width, frame.height)) {
    found.note = "numbers alone: a texel is wider than the picture";
    return found;
  }
  const Silhouette off = compare_silhouettes(mesh, drawn, band);
  found.note = fmt::format("outlines to {} pixels", band);
  if (off.holes + off.strays == 0) return found;
  found.measured += static_cast<double>(off.holes + off.strays);
  found.place = fmt::format("pixel ({}, {})", off.x, off.y);
  found.expected = fmt::format("id {}", *mesh.ids.at(off.x, off.y));
  found.got = fmt::format("id {}", *drawn.ids.at(off.x, off.y));
  found.note += fmt::format("; {} holes, {} strays", off.holes, off.strays);
  found.before = enlarged(mesh.colour, off.x, off.y);
  found.after = enlarged(drawn.colour, off.x, off.y);
  return found;
}

Found wrong_pixels(Fixture& fixture, const scene::Frame& frame) {
  const Capture drawn = fixture.draw(frame, true);
  if (fixture.stores_views()) {
    Found found = wrong_beside(drawn, drawn, frame, 0);
    found.note = "numbers alone: pictures stored from afar claim no surface here";
    return found;
  }
  const Capture mesh = fixture.draw_mesh(frame);
  const double texel = fixture.representation().texel_metres(0);
  const double pixel = scene::pixel_size_at(frame.camera, nearest_depth(mesh), frame.height);
  const int band = std::isfinite(pixel) ? static_cast<int>(std::min(1e4, std::ceil(2 + 2 * texel / pixel))) : 2;
  return wrong_beside(mesh, drawn, frame, band);
}

}  // namespace crowdbench::bench
