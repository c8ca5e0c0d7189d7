#include "renderers/polypostor/polypostor_torn.h"

#include <algorithm>
#include <cmath>

namespace crowdbench::renderers {
namespace {

constexpr size_t kPoints = 96;  // of an outline, that are looked at

// Whether a line lies within a distance of a point at one edge of it.
bool lies_within(const Polyline& closed, size_t edge, const glm::dvec2& p, double distance) {
  const glm::dvec2& a = closed[edge];
  const glm::dvec2 ab = closed[edge + 1 < closed.size() ? edge + 1 : 0] - a;
  const glm::dvec2 ap = p - a;
  const double square = glm::dot(ab, ab);
  const double t = square > 0 ? std::clamp(glm::dot(ap, ab) / square, 0.0, 1.0) : 0.0;
  const glm::dvec2 off = ap - ab * t;
  return glm::dot(off, off) <= distance * distance;
}

// How many of the places `reach` to the left, right, above and below of a point are covered; from `enough` on it is
// `enough`.
int covered_around(const PartMask& figure, const glm::dvec2& p, double reach, int enough) {
  const auto floor = [](double v) {
    const int towards_zero = static_cast<int>(v);
    return v < towards_zero ? towards_zero - 1 : towards_zero;
  };
  int count = 0;
  for (const glm::dvec2& side :
       {glm::dvec2(reach, 0), glm::dvec2(-reach, 0), glm::dvec2(0, reach), glm::dvec2(0, -reach)}) {
    const glm::dvec2 q = (p + side) * double{kMaskSamples};
    count += figure.at(floor(q.x) - figure.x, floor(q.y) - figure.y) ? 1 : 0;
    if (count == enough) break;
  }
  return count;
}

}  // namespace

double area_between(const Polyline& points, const IndexedLine& wanted) {
  double apart = 0;
  size_t edge = 0;
  for (const glm::dvec2& p : points) {
    const NearestPoint near = wanted.nearest(p, edge);
    apart += near.distance;
    edge = near.edge;
  }
  return points.empty() ? 0 : apart / static_cast<double>(points.size()) * wanted.perimeter();
}

WantedOutline::WantedOutline(const Polyline& wanted, const PartMask& figure, double slack)
    : line_(wanted), figure_(&figure), slack_(slack) {
  for (const glm::dvec2& p : resample(wanted, kPoints))
    if (shows(p)) seen_.push_back(p);
}

bool WantedOutline::shows(const glm::dvec2& p) const { return covered_around(*figure_, p, 1, 4) < 4; }

double WantedOutline::area_between(const Polyline& points) const { return renderers::area_between(points, line_); }

double WantedOutline::torn(const Polyline& shown) const {
  if (shown.empty() || line().empty()) return 0;
  // Of the points of one line: what lies beyond the other.
  const auto beyond = [&](const Polyline& points, const IndexedLine& other, const auto& seen) {
    double area = 0;
    size_t edge = 0;
    for (const glm::dvec2& p : points) {
      if (!seen(p) || lies_within(other.line(), edge, p, slack_)) continue;
      const NearestPoint near = other.nearest(p, edge);
      edge = near.edge;
      if (near.distance > slack_ && !contains(other.line(), p)) area += near.distance - slack_;
    }
    return area;
  };
  const auto outside = [&](const glm::dvec2& p) { return covered_around(*figure_, p, slack_, 1) == 0; };
  const auto any = [](const glm::dvec2&) { return true; };
  return beyond(resample(shown, kPoints), line_, outside) * renderers::perimeter(shown) / kPoints +
         beyond(seen_, IndexedLine(shown), any) * perimeter() / kPoints;
}

}  // namespace crowdbench::renderers
