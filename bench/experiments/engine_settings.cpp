#include "bench/experiments/engine_settings.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <glm/geometric.hpp>

namespace crowdbench::bench {
namespace {

double pixel_metres(double distance, int rows, double fov_y) { return 2 * distance * std::tan(fov_y / 2) / rows; }

}  // namespace

double sphere_pixels(const glm::dvec3& bounds, double distance, int rows, double fov_y) {
  return glm::length(bounds) / pixel_metres(distance, rows, fov_y);
}

std::optional<MeshLodCurve> mesh_lod_curve(std::span<const double> sphere_px) {
  if (sphere_px.empty()) return std::nullopt;
  if (sphere_px.size() == 1) return MeshLodCurve{1, 1 + std::log2(sphere_px[0])};
  // level = bias + slope x, x = -log2(diameter).
  double mean_x = 0;
  double mean_level = 0;
  for (size_t i = 0; i < sphere_px.size(); ++i) {
    if (i > 0 && !(sphere_px[i] < sphere_px[i - 1])) return std::nullopt;
    mean_x -= std::log2(sphere_px[i]);
    mean_level += static_cast<double>(i + 1);
  }
  const auto n = static_cast<double>(sphere_px.size());
  mean_x /= n;
  mean_level /= n;
  double xx = 0;
  double xy = 0;
  for (size_t i = 0; i < sphere_px.size(); ++i) {
    const double x = -std::log2(sphere_px[i]) - mean_x;
    xx += x * x;
    xy += x * (static_cast<double>(i + 1) - mean_level);
  }
  const double slope = xy / xx;
  return MeshLodCurve{slope, mean_level - slope * mean_x};
}

double mesh_lod_begins(const MeshLodCurve& curve, size_t level, double threshold) {
  assert(level >= 1);
  return threshold * std::exp2((curve.bias - static_cast<double>(level)) / curve.slope);
}

double mesh_lod_level(const MeshLodCurve& curve, double sphere_px, double threshold) {
  return std::max(0.0, curve.bias - curve.slope * std::log2(sphere_px / threshold));
}

double godot_threshold_pixels(double error, const glm::dvec3& bounds, double distance, int rows, double fov_y) {
  return error / pixel_metres(std::max(distance - bounds.z / 2, 1e-6), rows, fov_y);
}

double godot_lod_distance(double error, const glm::dvec3& bounds, double threshold_px, int rows, double fov_y) {
  return error / (threshold_px * pixel_metres(1, rows, fov_y)) + bounds.z / 2;
}

}  // namespace crowdbench::bench
