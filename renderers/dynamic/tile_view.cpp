#include "renderers/dynamic/tile_view.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace crowdbench::renderers {
namespace {

constexpr double kNearest = 0.1;  // of the distance: corners must be farther before the eye

// The unit vector across `axis`, of length 1, that is nearest to `wanted`.
glm::dvec3 across(const glm::dvec3& axis, const glm::dvec3& wanted) {
  const glm::dvec3 right = glm::normalize(wanted);
  const glm::dvec3 rest = right - glm::dot(right, axis) * axis;
  if (glm::length(rest) > 1e-6) return glm::normalize(rest);
  // What lies along the picture's edge is not in the picture: any will do.
  return glm::normalize(glm::cross(std::abs(axis.y) < 0.5 ? glm::dvec3(0, 1, 0) : glm::dvec3(0, 0, 1), axis));
}

}  // namespace

std::optional<TileView> tile_view(const Box& box, const glm::dvec3& eye, const glm::dvec3& picture_right,
                                  double texel) {
  TileView view;
  view.centre = box.centre();
  view.texel = texel;
  view.distance = glm::distance(eye, view.centre);
  if (!(view.distance > 0)) return std::nullopt;
  view.to_eye = (eye - view.centre) / view.distance;
  view.right = across(view.to_eye, picture_right);
  view.up = glm::cross(view.to_eye, view.right);
  view.nearest = std::numeric_limits<double>::infinity();
  view.low = glm::dvec2(std::numeric_limits<double>::infinity());
  view.high = -view.low;
  for (int corner = 0; corner < 8; ++corner) {
    const glm::dvec3 p = glm::dvec3(corner & 1 ? box.high.x : box.low.x, corner & 2 ? box.high.y : box.low.y,
                                    corner & 4 ? box.high.z : box.low.z) -
                         view.centre;
    const double depth = view.distance - glm::dot(view.to_eye, p);
    if (depth < kNearest * view.distance) return std::nullopt;
    const glm::dvec2 q = glm::dvec2(glm::dot(view.right, p), glm::dot(view.up, p)) * (view.distance / depth);
    view.nearest = std::min(view.nearest, depth);
    view.low = glm::min(view.low, q);
    view.high = glm::max(view.high, q);
  }
  return view;
}

glm::ivec2 tile_texels(const TileView& view) {
  const glm::dvec2 size = (view.high - view.low) / view.texel;
  return {static_cast<int>(std::ceil(size.x)), static_cast<int>(std::ceil(size.y))};
}

TileRows tile_rows(const TileView& view, const glm::vec2& heading, const glm::ivec2& corner, int side) {
  const glm::dvec3 centre = turned(view.centre, heading);
  const glm::dvec3 back = turned(view.to_eye, heading);
  const auto row = [&](const glm::dvec3& axis, double offset) {
    return glm::dvec4(axis, offset - glm::dot(axis, centre));
  };
  const glm::dvec4 w = row(-back, view.distance);
  const auto place = [&](const glm::dvec3& axis, double low, int from) {
    const double texels = view.distance / view.texel;
    return (row(turned(axis, heading), 0.0) * texels + w * (from - low / view.texel)) * (2.0 / side) - w;
  };
  return {glm::vec4(place(view.right, view.low.x, corner.x)), glm::vec4(place(view.up, view.low.y, corner.y)),
          glm::vec4(0.0F, 0.0F, 0.0F, static_cast<float>(0.5 * view.nearest)), glm::vec4(w)};
}

glm::dvec3 turned(const glm::dvec3& v, const glm::vec2& heading) {
  const double s = heading.x;
  const double c = heading.y;
  return {c * v.x + s * v.z, v.y, c * v.z - s * v.x};
}

glm::dvec3 turned_back(const glm::dvec3& v, const glm::vec2& heading) { return turned(v, {-heading.x, heading.y}); }

}  // namespace crowdbench::renderers
