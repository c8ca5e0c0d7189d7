// Masks of a part's projection, their outlines, and the polygons around them. Everything is in texels of level 0 on a
// view's capture plane, y up; polygons are closed, counter-clockwise, and name each corner once.
#pragma once
#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <vector>

namespace crowdbench::renderers {

using Polyline = std::vector<glm::dvec2>;

// Samples a side of a texel.
inline constexpr int kMaskSamples = 3;

// Samples on a lattice: (column, row) stands at ((x + column + 1/2) / kMaskSamples, ...) texels.
struct PartMask {
  int x = 0, y = 0;  // of the first column and row, samples
  int width = 0, height = 0;
  std::vector<uint8_t> on;  // rows bottom first; bit 0: covered, bit 1: covered by a triangle that faces the eye
  bool at(int column, int row) const {
    return column >= 0 && row >= 0 && column < width && row < height &&
           on[static_cast<size_t>(row) * static_cast<size_t>(width) + static_cast<size_t>(column)] != 0;
  }
};

// Triangles projected by an orthographic view: three points each, texels. Counter-clockwise ones face the eye.
PartMask rasterise(std::span<const glm::dvec2> corners);
// Area in texels of what is covered; of what faces the eye.
double covered_area(const PartMask& mask);
double facing_area(const PartMask& mask);

// The outer outline of all that is covered, through the middles of the samples' borders; holes are passed over.
// Diagonal neighbours touch. Components that do not are joined by bridges one sample wide, the nearest first. Empty for
// an empty mask; four points for a single sample.
Polyline trace_contour(PartMask mask);

// A closed line of fewer points: none of the line's own lies farther than `tolerance` from it.
Polyline simplify(const Polyline& closed, double tolerance);

// What any of the masks covers.
PartMask unite(std::span<const PartMask> masks);

// Twice the signed area of the triangle (0, a, b): positive where b is counter-clockwise of a.
inline double cross(const glm::dvec2& a, const glm::dvec2& b) { return a.x * b.y - a.y * b.x; }

// Signed area, positive when counter-clockwise.
double signed_area(const Polyline& polygon);
double perimeter(const Polyline& polygon);
bool contains(const Polyline& polygon, const glm::dvec2& p);
// No two edges cross or touch but neighbours at their common corner.
bool is_simple(const Polyline& polygon);

// `count` points evenly spaced along a closed line, the first at its first point.
Polyline resample(const Polyline& closed, size_t count);
// The point of a closed line that lies nearest: on which edge, and which share of the way along it.
struct NearestPoint {
  glm::dvec2 point{0.0};
  double distance = 0;
  size_t edge = 0;
  double along = 0;
};
NearestPoint nearest_point(const Polyline& closed, const glm::dvec2& p);

// A closed line that is asked often: runs of edges whose bounding box lies farther than what was found are passed over.
// It refers to the line. The answers are nearest_point's.
class IndexedLine {
 public:
  explicit IndexedLine(const Polyline& closed);
  const Polyline& line() const { return *line_; }
  double perimeter() const { return perimeter_; }
  // hint: an edge that may be near, as that of the point asked for before; any number is sound.
  NearestPoint nearest(const glm::dvec2& p, size_t hint) const;

 private:
  struct Run {  // of edges
    glm::dvec2 low, high;
  };
  const Polyline* line_;
  std::vector<Run> runs_;
  double perimeter_ = 0;
};

// A simple polygon of at most `corners` (4..32) that holds every point of the contour, `margin` texels wider than it
// need be, and reaches at most `room` texels beyond the contour's bounding box. Corners go where that adds the least
// area, and never cut anything off; where the outcome crosses itself, has too many corners or is the larger, the
// polygon is the convex one of evenly spread directions.
Polyline outward_polygon(const Polyline& contour, int corners, double margin, double room);

}  // namespace crowdbench::renderers
