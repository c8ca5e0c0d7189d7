// Based on: Andrew's monotone chain for the hull; "particle trimming" (Persson 2009) for the idea that fill is saved by
// an optimised polygon: edges of the hull are dropped, their neighbours extended, where that adds the least area.
#include "renderers/impostor/tiles/outline.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <optional>

#include "renderers/impostor/tiles/half_plane.h"

namespace crowdbench::renderers {
namespace {

using Polygon = std::vector<glm::dvec2>;

double cross(const glm::dvec2& a, const glm::dvec2& b) { return a.x * b.y - a.y * b.x; }

Polygon convex_hull(Polygon points) {
  std::sort(points.begin(), points.end(),
            [](const glm::dvec2& a, const glm::dvec2& b) { return a.x != b.x ? a.x < b.x : a.y < b.y; });
  points.erase(std::unique(points.begin(), points.end()), points.end());
  if (points.size() < 3) return points;
  Polygon hull(2 * points.size());
  size_t k = 0;
  const auto add = [&](const glm::dvec2& p, size_t least) {
    while (k >= least && cross(hull[k - 1] - hull[k - 2], p - hull[k - 1]) <= 1e-9) --k;
    hull[k++] = p;
  };
  for (const glm::dvec2& p : points) add(p, 2);
  const size_t lower = k + 1;
  for (size_t i = points.size() - 1; i-- > 0;) add(points[i], lower);
  hull.resize(k - 1);
  return hull;
}

// Where the lines through (a, b) and (c, d) meet.
std::optional<glm::dvec2> meeting(const glm::dvec2& a, const glm::dvec2& b, const glm::dvec2& c, const glm::dvec2& d) {
  const double turn = cross(b - a, d - c);
  if (turn <= 1e-9) return std::nullopt;
  return a + (b - a) * (cross(c - a, d - c) / turn);
}

struct Box {
  glm::dvec2 low, high;
  bool holds(const glm::dvec2& p) const { return p.x >= low.x && p.y >= low.y && p.x <= high.x && p.y <= high.y; }
};

// Drops edges until `corners` are left or none can go without leaving the box.
Polygon drop_edges(Polygon polygon, size_t corners, const Box& box) {
  while (polygon.size() > corners) {
    const size_t n = polygon.size();
    double least = std::numeric_limits<double>::infinity();
    size_t best = 0;
    glm::dvec2 corner{};
    for (size_t i = 0; i < n; ++i) {
      // Edge i runs from corner i to i + 1; without it the edges before and after meet.
      const glm::dvec2& b = polygon[i];
      const glm::dvec2& c = polygon[(i + 1) % n];
      const auto met = meeting(polygon[(i + n - 1) % n], b, c, polygon[(i + 2) % n]);
      if (!met || !box.holds(*met)) continue;
      const double added = 0.5 * std::abs(cross(c - b, *met - b));
      if (added < least) {
        least = added;
        best = i;
        corner = *met;
      }
    }
    if (!std::isfinite(least)) break;
    polygon[best] = corner;
    polygon.erase(polygon.begin() + static_cast<std::ptrdiff_t>((best + 1) % n));
  }
  return polygon;
}

// The hull's bounds along `directions` evenly spread half-planes, clipped to the box: at most that many corners.
Polygon bounded(const Polygon& hull, size_t directions, const Box& box) {
  Polygon polygon{box.low, {box.high.x, box.low.y}, box.high, {box.low.x, box.high.y}};
  for (size_t i = 0; i < directions; ++i) {
    const double angle = 2 * 3.14159265358979323846 * static_cast<double>(i) / static_cast<double>(directions);
    const glm::dvec2 out{std::cos(angle), std::sin(angle)};
    double reach = -std::numeric_limits<double>::infinity();
    for (const glm::dvec2& p : hull) reach = std::max(reach, glm::dot(p, out));
    polygon = cut_by_half_plane(polygon, out, reach);
  }
  return convex_hull(polygon);
}

// All points with filtered alpha >= 1/2, up to the margin: texel centres, crossings between neighbours, and the inside
// of the cells that the contour passes through.
Polygon covered_points(const Tile& tile) {
  Polygon points;
  if (tile.rect.width == 0) return points;
  const auto value = [&](int column, int row) {
    return tile.albedo[4 * (static_cast<size_t>(row) * static_cast<size_t>(tile.stride()) +
                            static_cast<size_t>(column)) +
                       3] -
           127.5;
  };
  const auto at = [&](double column, double row) {
    return glm::dvec2(tile.rect.x + column - kTileGutter + 0.5, tile.rect.y + row - kTileGutter + 0.5);
  };
  for (int row = 0; row + 1 < tile.rows(); ++row)
    for (int column = 0; column + 1 < tile.stride(); ++column) {
      const double a = value(column, row);
      const double b = value(column + 1, row);
      const double c = value(column, row + 1);
      const double d = value(column + 1, row + 1);
      const int inside = (a >= 0) + (b >= 0) + (c >= 0) + (d >= 0);
      if (inside == 0 || inside == 4) continue;
      if (a >= 0) points.push_back(at(column, row));
      if ((a >= 0) != (b >= 0)) points.push_back(at(column + a / (a - b), row));
      if ((c >= 0) != (d >= 0)) points.push_back(at(column + c / (c - d), row + 1));
      if ((a >= 0) != (c >= 0)) points.push_back(at(column, row + a / (a - c)));
      if ((b >= 0) != (d >= 0)) points.push_back(at(column + 1, row + b / (b - d)));
      constexpr int kInside = 4;
      for (int j = 1; j < kInside; ++j)
        for (int i = 1; i < kInside; ++i) {
          const double u = static_cast<double>(i) / kInside;
          const double v = static_cast<double>(j) / kInside;
          if ((a * (1 - u) + b * u) * (1 - v) + (c * (1 - u) + d * u) * v >= 0)
            points.push_back(at(column + u, row + v));
        }
    }
  return points;
}

// The hull of what a tile covers, a little wider. The contour inside a cell is a hyperbola that may bulge past the
// points sampled on it. Widening by a small square also gives area to a hull that is a point or a line.
Polygon covering_hull(const Tile& tile) {
  constexpr double kMargin = 0.08;
  Polygon wide;
  for (const glm::dvec2& p : convex_hull(covered_points(tile)))
    for (const double dx : {-kMargin, kMargin})
      for (const double dy : {-kMargin, kMargin}) wide.push_back(p + glm::dvec2(dx, dy));
  return convex_hull(wide);
}

}  // namespace

double polygon_area(const std::vector<glm::dvec2>& p) {
  double twice = 0;
  for (size_t i = 0; i < p.size(); ++i) twice += cross(p[i], p[(i + 1) % p.size()]);
  return twice / 2;
}

std::vector<glm::vec2> rectangle_strip(const glm::vec2& low, const glm::vec2& high) {
  return {low, {high.x, low.y}, {low.x, high.y}, high};
}

std::vector<glm::vec2> tile_outline(const Tile& tile, int corners) {
  assert(corners >= 4);
  const auto count = static_cast<size_t>(corners);
  const Polygon hull = covering_hull(tile);
  if (hull.empty()) return std::vector<glm::vec2>(count, glm::vec2(tile.rect.x, tile.rect.y));
  const Box box{glm::dvec2(tile.rect.x - 1, tile.rect.y - 1),
                glm::dvec2(tile.rect.x + tile.rect.width + 1, tile.rect.y + tile.rect.height + 1)};
  Polygon best = bounded(hull, count >= 8 ? 8 : 4, box);
  const Polygon greedy = drop_edges(hull, count, box);
  if (best.size() > count || (greedy.size() <= count && polygon_area(greedy) < polygon_area(best))) best = greedy;
  if (best.size() > count) best = bounded(hull, 4, box);
  assert(best.size() >= 3 && best.size() <= count);

  // A strip that zigzags across the polygon; of all places to start, the one with the shortest inner edges, since
  // blocks of pixels along an inner edge are shaded twice.
  const auto n = static_cast<int>(best.size());
  const auto corner = [&](int start, int i) {
    // start, start + 1, start - 1, start + 2, start - 2, ...
    const int offset = i % 2 == 1 ? (i + 1) / 2 : -(i / 2);
    return best[static_cast<size_t>(((start + offset) % n + n) % n)];
  };
  int first = 0;
  double shortest = std::numeric_limits<double>::infinity();
  for (int start = 0; start < n; ++start) {
    double length = 0;
    for (int i = 1; i + 2 < n; ++i) length += glm::distance(corner(start, i), corner(start, i + 1));
    if (length < shortest - 1e-9) {
      shortest = length;
      first = start;
    }
  }
  std::vector<glm::vec2> strip;
  for (int i = 0; i < corners; ++i) strip.emplace_back(corner(first, std::min(i, n - 1)));
  return strip;
}

std::vector<glm::vec2> tile_triangle(const Tile& tile) {
  const Polygon hull = covering_hull(tile);
  if (hull.empty()) return std::vector<glm::vec2>(3, glm::vec2(tile.rect.x, tile.rect.y));
  // Lines that the hull lies left of and touches: along its edges, and in evenly spread directions, without which no
  // three might close around a rectangle.
  struct Line {
    double angle;  // of its direction
    glm::dvec2 at, along;
  };
  std::vector<Line> lines;
  const auto touching = [&](const glm::dvec2& along) {
    const glm::dvec2 at = *std::min_element(hull.begin(), hull.end(), [&](const glm::dvec2& a, const glm::dvec2& b) {
      return cross(along, a) < cross(along, b);
    });
    lines.push_back({std::atan2(along.y, along.x), at, along});
  };
  for (size_t i = 0; i < hull.size(); ++i) touching(glm::normalize(hull[(i + 1) % hull.size()] - hull[i]));
  constexpr int kSpread = 12;
  for (int i = 0; i < kSpread; ++i) {
    const double angle = 2 * 3.14159265358979323846 * i / kSpread;
    touching({std::cos(angle), std::sin(angle)});
  }
  std::sort(lines.begin(), lines.end(), [](const Line& a, const Line& b) { return a.angle < b.angle; });

  constexpr double kCell = 4;
  double least = std::numeric_limits<double>::infinity();
  std::vector<glm::vec2> best;
  const auto corner = [&](size_t i, size_t j) {
    return meeting(lines[i].at, lines[i].at + lines[i].along, lines[j].at, lines[j].at + lines[j].along);
  };
  for (size_t i = 0; i < lines.size(); ++i)
    for (size_t j = i + 1; j < lines.size(); ++j) {
      const auto a = corner(i, j);
      if (!a) continue;
      for (size_t k = j + 1; k < lines.size(); ++k) {
        const auto b = corner(j, k);
        const auto c = corner(k, i);
        if (!b || !c) continue;
        const glm::dvec2 size = glm::max(*a, glm::max(*b, *c)) - glm::min(*a, glm::min(*b, *c));
        // A convex figure touches (area + block * (width + height) + block^2) / block^2 cells of a grid on average.
        const double cost = 0.5 * std::abs(cross(*b - *a, *c - *a)) + kCell * (size.x + size.y);
        if (cost >= least) continue;
        least = cost;
        best = {glm::vec2(*a), glm::vec2(*b), glm::vec2(*c)};
      }
    }
  assert(best.size() == 3);
  return best;
}

}  // namespace crowdbench::renderers
