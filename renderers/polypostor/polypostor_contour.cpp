// Based on: boundary following with the inside on the left (Freeman 1961); progressive hulls (Sander, Gu, Gortler,
// Hoppe and Snyder 2000), here in the plane: corners go where least area is added, and nothing is ever cut off.
#include "renderers/polypostor/polypostor_contour.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>

#include "renderers/impostor/tiles/half_plane.h"

namespace crowdbench::renderers {
namespace {

glm::dvec2 normalised(const glm::dvec2& v) {
  const double length = glm::length(v);
  return length > 1e-12 ? v / length : glm::dvec2(0.0);
}

struct Components {
  std::vector<int> label;  // -1: not covered
  std::vector<std::vector<std::array<int, 2>>> borders;
  std::vector<size_t> sizes;
};

Components label_components(const PartMask& mask) {
  Components out;
  out.label.assign(mask.on.size(), -1);
  std::vector<std::array<int, 2>> open;
  for (int row = 0; row < mask.height; ++row)
    for (int column = 0; column < mask.width; ++column) {
      const auto index = [&](int c, int r) {
        return static_cast<size_t>(r) * static_cast<size_t>(mask.width) + static_cast<size_t>(c);
      };
      if (!mask.at(column, row) || out.label[index(column, row)] >= 0) continue;
      const int label = static_cast<int>(out.sizes.size());
      out.sizes.push_back(0);
      out.borders.emplace_back();
      out.label[index(column, row)] = label;
      open.push_back({column, row});
      while (!open.empty()) {
        const auto [c, r] = open.back();
        open.pop_back();
        ++out.sizes.back();
        if (!mask.at(c - 1, r) || !mask.at(c + 1, r) || !mask.at(c, r - 1) || !mask.at(c, r + 1))
          out.borders.back().push_back({c, r});
        for (int j = -1; j <= 1; ++j)
          for (int i = -1; i <= 1; ++i) {
            if (!mask.at(c + i, r + j) || out.label[index(c + i, r + j)] >= 0) continue;
            out.label[index(c + i, r + j)] = label;
            open.push_back({c + i, r + j});
          }
      }
    }
  return out;
}

// Joins all components by straight bridges, each to the nearest that is joined already; specks go.
void join_components(PartMask& mask) {
  constexpr double kSpeck = 0.01;  // of the covered area
  for (;;) {
    const Components parts = label_components(mask);
    if (parts.sizes.size() < 2) return;
    size_t total = 0;
    for (const size_t s : parts.sizes) total += s;
    size_t main = 0;
    for (size_t i = 1; i < parts.sizes.size(); ++i)
      if (parts.sizes[i] > parts.sizes[main]) main = i;
    bool dropped = false;
    for (size_t i = 0; i < mask.on.size(); ++i) {
      const int label = parts.label[i];
      if (label < 0 || static_cast<size_t>(label) == main) continue;
      if (static_cast<double>(parts.sizes[static_cast<size_t>(label)]) >= kSpeck * static_cast<double>(total)) continue;
      mask.on[i] = 0;
      dropped = true;
    }
    if (dropped) continue;
    std::array<int, 2> from{};
    std::array<int, 2> to{};
    int64_t least = std::numeric_limits<int64_t>::max();
    for (size_t i = 0; i < parts.borders.size(); ++i) {
      if (i == main) continue;
      for (const auto& a : parts.borders[main])
        for (const auto& b : parts.borders[i]) {
          const int64_t dx = a[0] - b[0];
          const int64_t dy = a[1] - b[1];
          if (dx * dx + dy * dy >= least) continue;
          least = dx * dx + dy * dy;
          from = a;
          to = b;
        }
    }
    const int steps = std::max(std::abs(to[0] - from[0]), std::abs(to[1] - from[1]));
    for (int s = 0; s <= steps; ++s) {
      const auto along = [&](int a, int b) {
        return a + static_cast<int>(std::lround(static_cast<double>(b - a) * s / steps));
      };
      mask.on[static_cast<size_t>(along(from[1], to[1])) * static_cast<size_t>(mask.width) +
              static_cast<size_t>(along(from[0], to[0]))] |= 1;
    }
  }
}

bool segments_meet(const glm::dvec2& a, const glm::dvec2& b, const glm::dvec2& c, const glm::dvec2& d) {
  const double o1 = cross(b - a, c - a);
  const double o2 = cross(b - a, d - a);
  const double o3 = cross(d - c, a - c);
  const double o4 = cross(d - c, b - c);
  const auto within = [](const glm::dvec2& p, const glm::dvec2& q, const glm::dvec2& r) {
    return r.x >= std::min(p.x, q.x) && r.x <= std::max(p.x, q.x) && r.y >= std::min(p.y, q.y) &&
           r.y <= std::max(p.y, q.y);
  };
  if (((o1 > 0) != (o2 > 0)) && ((o3 > 0) != (o4 > 0)) && o1 != 0 && o2 != 0 && o3 != 0 && o4 != 0) return true;
  return (o1 == 0 && within(a, b, c)) || (o2 == 0 && within(a, b, d)) || (o3 == 0 && within(c, d, a)) ||
         (o4 == 0 && within(c, d, b));
}

struct Box {
  glm::dvec2 low{std::numeric_limits<double>::infinity()};
  glm::dvec2 high{-std::numeric_limits<double>::infinity()};
};

Box bounds(const Polyline& points) {
  Box box;
  for (const glm::dvec2& p : points) {
    box.low = glm::min(box.low, p);
    box.high = glm::max(box.high, p);
  }
  return box;
}

// Where the lines through (a, b) and (c, d) meet beyond b and c.
std::optional<glm::dvec2> meeting(const glm::dvec2& a, const glm::dvec2& b, const glm::dvec2& c, const glm::dvec2& d) {
  const glm::dvec2 u = normalised(b - a);
  const glm::dvec2 v = normalised(d - c);
  const double turn = cross(u, v);
  if (turn < 1e-6) return std::nullopt;
  const double along = cross(c - b, v) / turn;
  if (along < 0) return std::nullopt;
  return b + u * along;
}

// Takes away corners, always what adds the least area, until `corners` are left or none can go: a corner that points
// inward goes, or an edge whose neighbours, made longer, meet outside. The polygon only ever grows.
Polyline grow_simpler(Polyline polygon, size_t corners, const Box& box) {
  struct Step {
    double area = std::numeric_limits<double>::infinity();
    glm::dvec2 corner{0.0};
    bool edge = false;  // the edge from this corner on goes, and `corner` takes its place; else this corner goes
  };
  const auto step_at = [&](size_t i) {
    const size_t n = polygon.size();
    const glm::dvec2& before = polygon[(i + n - 1) % n];
    const glm::dvec2& a = polygon[i];
    const glm::dvec2& b = polygon[(i + 1) % n];
    const glm::dvec2& after = polygon[(i + 2) % n];
    Step step;
    const double bend = cross(a - before, b - a);
    if (bend <= 0) {
      step.area = -0.5 * bend;
      return step;
    }
    if (cross(b - a, after - b) <= 0) return step;
    const auto met = meeting(before, a, b, after);
    if (!met || met->x < box.low.x || met->y < box.low.y || met->x > box.high.x || met->y > box.high.y) return step;
    return Step{0.5 * std::abs(cross(b - a, *met - a)), *met, true};
  };
  std::vector<Step> steps;
  for (size_t i = 0; i < polygon.size(); ++i) steps.push_back(step_at(i));
  while (polygon.size() > corners) {
    const auto least =
        std::min_element(steps.begin(), steps.end(), [](const Step& a, const Step& b) { return a.area < b.area; });
    if (!std::isfinite(least->area)) break;
    const auto i = static_cast<size_t>(least - steps.begin());
    size_t gone = i;
    if (least->edge) {
      polygon[i] = least->corner;
      gone = (i + 1) % polygon.size();
    }
    polygon.erase(polygon.begin() + static_cast<std::ptrdiff_t>(gone));
    steps.erase(steps.begin() + static_cast<std::ptrdiff_t>(gone));
    const size_t n = polygon.size();
    const size_t here = gone < i ? i - 1 : i;
    for (size_t k = n + here - 3; k <= n + here + 2; ++k) steps[k % n] = step_at(k % n);
  }
  return polygon;
}

// Every edge moved outward.
Polyline widen(const Polyline& polygon, double margin, const Box& box) {
  const size_t n = polygon.size();
  Polyline out(n);
  for (size_t i = 0; i < n; ++i) {
    const glm::dvec2 u = normalised(polygon[i] - polygon[(i + n - 1) % n]);
    const glm::dvec2 v = normalised(polygon[(i + 1) % n] - polygon[i]);
    // Along the bisector of the edges' normals; a sharp corner goes three margins out at most.
    const glm::dvec2 bisector = normalised(glm::dvec2(u.y, -u.x) + glm::dvec2(v.y, -v.x));
    const double reach = margin / std::max(glm::dot(bisector, glm::dvec2(v.y, -v.x)), 1.0 / 3);
    out[i] = glm::clamp(polygon[i] + bisector * reach, box.low, box.high);
  }
  return out;
}

// The box cut by half-planes in evenly spread directions: convex.
Polyline convex_around(const Polyline& contour, int corners, double margin, const Box& box) {
  Polyline polygon{box.low, {box.high.x, box.low.y}, box.high, {box.low.x, box.high.y}};
  const int cuts = corners - 4;
  for (int i = 0; i < cuts; ++i) {
    const double angle = 2 * std::numbers::pi * (i + 0.5) / cuts;
    const glm::dvec2 out{std::cos(angle), std::sin(angle)};
    double reach = -std::numeric_limits<double>::infinity();
    for (const glm::dvec2& p : contour) reach = std::max(reach, glm::dot(p, out));
    reach += margin;
    polygon = cut_by_half_plane(polygon, out, reach);
  }
  return polygon;
}

// Corners that coincide are one.
void drop_doubles(Polyline& polygon) {
  for (size_t i = 0; i < polygon.size() && polygon.size() > 3;)
    if (glm::distance(polygon[i], polygon[(i + 1) % polygon.size()]) < 1e-3)
      polygon.erase(polygon.begin() + static_cast<std::ptrdiff_t>(i));
    else
      ++i;
}

}  // namespace

PartMask rasterise(std::span<const glm::dvec2> corners) {
  PartMask mask;
  if (corners.size() < 3) return mask;
  Box box;
  for (const glm::dvec2& p : corners) {
    box.low = glm::min(box.low, p);
    box.high = glm::max(box.high, p);
  }
  mask.x = static_cast<int>(std::floor(box.low.x * kMaskSamples));
  mask.y = static_cast<int>(std::floor(box.low.y * kMaskSamples));
  mask.width = static_cast<int>(std::ceil(box.high.x * kMaskSamples)) - mask.x;
  mask.height = static_cast<int>(std::ceil(box.high.y * kMaskSamples)) - mask.y;
  mask.on.assign(static_cast<size_t>(mask.width) * static_cast<size_t>(mask.height), 0);
  const glm::dvec2 origin(mask.x + 0.5, mask.y + 0.5);
  for (size_t t = 0; t + 2 < corners.size(); t += 3) {
    const std::array<glm::dvec2, 3> p = {corners[t] * double{kMaskSamples} - origin,
                                         corners[t + 1] * double{kMaskSamples} - origin,
                                         corners[t + 2] * double{kMaskSamples} - origin};
    const double area = cross(p[1] - p[0], p[2] - p[0]);
    if (std::abs(area) < 1e-12) continue;
    const uint8_t bits = area > 0 ? 3 : 1;
    const int r0 = std::max(0, static_cast<int>(std::ceil(std::min({p[0].y, p[1].y, p[2].y}))));
    const int r1 = std::min(mask.height - 1, static_cast<int>(std::floor(std::max({p[0].y, p[1].y, p[2].y}))));
    for (int row = r0; row <= r1; ++row) {
      double left = std::numeric_limits<double>::infinity();
      double right = -left;
      for (size_t k = 0; k < 3; ++k) {
        const glm::dvec2& a = p[k];
        const glm::dvec2& b = p[(k + 1) % 3];
        if ((a.y > row && b.y > row) || (a.y < row && b.y < row)) continue;
        const double span = b.y - a.y;
        for (const double x :
             span == 0 ? std::array{a.x, b.x}
                       : std::array{a.x + (b.x - a.x) * (row - a.y) / span, a.x + (b.x - a.x) * (row - a.y) / span}) {
          left = std::min(left, x);
          right = std::max(right, x);
        }
      }
      const int c0 = std::max(0, static_cast<int>(std::ceil(left)));
      const int c1 = std::min(mask.width - 1, static_cast<int>(std::floor(right)));
      uint8_t* line = mask.on.data() + static_cast<size_t>(row) * static_cast<size_t>(mask.width);
      for (int c = c0; c <= c1; ++c) line[c] |= bits;
    }
  }
  return mask;
}

double covered_area(const PartMask& mask) {
  return static_cast<double>(std::count_if(mask.on.begin(), mask.on.end(), [](uint8_t v) { return v != 0; })) /
         (kMaskSamples * kMaskSamples);
}

double facing_area(const PartMask& mask) {
  return static_cast<double>(std::count_if(mask.on.begin(), mask.on.end(), [](uint8_t v) { return (v & 2) != 0; })) /
         (kMaskSamples * kMaskSamples);
}

Polyline trace_contour(PartMask mask) {
  join_components(mask);
  const auto first = std::find_if(mask.on.begin(), mask.on.end(), [](uint8_t v) { return v != 0; });
  if (first == mask.on.end()) return {};
  const auto index = static_cast<int>(first - mask.on.begin());
  // Corner (x, y) of the lattice lies between samples (x - 1, y - 1) and (x, y). The first sample's lower edge, walked
  // to the right, has the inside on the left.
  const int start_x = index % mask.width;
  const int start_y = index / mask.width;
  int x = start_x;
  int y = start_y;
  int dx = 1;
  int dy = 0;
  Polyline contour;
  do {
    contour.emplace_back((mask.x + x + 0.5 * dx) / kMaskSamples, (mask.y + y + 0.5 * dy) / kMaskSamples);
    x += dx;
    y += dy;
    // The samples ahead, on the left and on the right of the walk.
    const auto ahead = [&](int side) {  // 1: left
      const int nx = -dy * side;
      const int ny = dx * side;
      return mask.at((2 * x + dx + nx - 1) >> 1, (2 * y + dy + ny - 1) >> 1);
    };
    if (ahead(-1)) {
      const int turned = -dx;
      dx = dy;
      dy = turned;
    } else if (!ahead(1)) {
      const int turned = dx;
      dx = -dy;
      dy = turned;
    }
  } while (x != start_x || y != start_y || dx != 1 || dy != 0);
  return contour;
}

double signed_area(const Polyline& polygon) {
  double twice = 0;
  for (size_t i = 0; i < polygon.size(); ++i) twice += cross(polygon[i], polygon[(i + 1) % polygon.size()]);
  return twice / 2;
}

double perimeter(const Polyline& polygon) {
  double sum = 0;
  for (size_t i = 0; i < polygon.size(); ++i) sum += glm::distance(polygon[i], polygon[(i + 1) % polygon.size()]);
  return sum;
}

bool contains(const Polyline& polygon, const glm::dvec2& p) {
  bool inside = false;
  for (size_t i = 0; i < polygon.size(); ++i) {
    const glm::dvec2& a = polygon[i];
    const glm::dvec2& b = polygon[(i + 1) % polygon.size()];
    if ((a.y > p.y) != (b.y > p.y) && p.x < a.x + (b.x - a.x) * (p.y - a.y) / (b.y - a.y)) inside = !inside;
  }
  return inside;
}

bool is_simple(const Polyline& polygon) {
  const size_t n = polygon.size();
  if (n < 3) return false;
  for (size_t i = 0; i < n; ++i)
    for (size_t j = i + 2; j < n; ++j) {
      if (i == 0 && j == n - 1) continue;
      if (segments_meet(polygon[i], polygon[i + 1], polygon[j], polygon[(j + 1) % n])) return false;
    }
  return true;
}

Polyline simplify(const Polyline& closed, double tolerance) {
  const size_t n = closed.size();
  if (n < 5) return closed;
  size_t far = 0;
  for (size_t i = 1; i < n; ++i)
    if (glm::distance(closed[i], closed[0]) > glm::distance(closed[far], closed[0])) far = i;
  std::vector<uint8_t> kept(n, 0);
  kept[0] = kept[far] = 1;
  std::vector<std::array<size_t, 2>> open{{0, far}, {far, n}};
  while (!open.empty()) {
    const auto [first, last] = open.back();
    open.pop_back();
    const glm::dvec2& a = closed[first];
    const glm::dvec2 ab = closed[last % n] - a;
    const double square = glm::dot(ab, ab);
    double most = tolerance * tolerance;
    size_t at = first;
    for (size_t i = first + 1; i < last; ++i) {
      const glm::dvec2 ap = closed[i] - a;
      const double t = square > 0 ? std::clamp(glm::dot(ap, ab) / square, 0.0, 1.0) : 0.0;
      const glm::dvec2 off = ap - ab * t;
      if (glm::dot(off, off) <= most) continue;
      most = glm::dot(off, off);
      at = i;
    }
    if (at == first) continue;
    kept[at] = 1;
    open.push_back({first, at});
    open.push_back({at, last});
  }
  Polyline out;
  for (size_t i = 0; i < n; ++i)
    if (kept[i] != 0) out.push_back(closed[i]);
  return out;
}

PartMask unite(std::span<const PartMask> masks) {
  PartMask out;
  bool any = false;
  for (const PartMask& m : masks) {
    if (m.on.empty()) continue;
    const int right = any ? std::max(out.x + out.width, m.x + m.width) : m.x + m.width;
    const int top = any ? std::max(out.y + out.height, m.y + m.height) : m.y + m.height;
    out.x = any ? std::min(out.x, m.x) : m.x;
    out.y = any ? std::min(out.y, m.y) : m.y;
    out.width = right - out.x;
    out.height = top - out.y;
    any = true;
  }
  out.on.assign(static_cast<size_t>(out.width) * static_cast<size_t>(out.height), 0);
  for (const PartMask& m : masks)
    for (int row = 0; row < m.height; ++row)
      for (int column = 0; column < m.width; ++column)
        out.on[static_cast<size_t>(m.y + row - out.y) * static_cast<size_t>(out.width) +
               static_cast<size_t>(m.x + column - out.x)] |=
            m.on[static_cast<size_t>(row) * static_cast<size_t>(m.width) + static_cast<size_t>(column)];
  return out;
}

Polyline resample(const Polyline& closed, size_t count) {
  Polyline out;
  if (closed.empty()) return out;
  const double step = perimeter(closed) / static_cast<double>(count);
  size_t edge = 0;
  double before = 0;
  for (size_t i = 0; i < count; ++i) {
    const double at = step * static_cast<double>(i);
    double length = glm::distance(closed[edge], closed[(edge + 1) % closed.size()]);
    while (before + length < at && edge + 1 < closed.size()) {
      before += length;
      ++edge;
      length = glm::distance(closed[edge], closed[(edge + 1) % closed.size()]);
    }
    const double t = length > 0 ? std::clamp((at - before) / length, 0.0, 1.0) : 0.0;
    out.push_back(closed[edge] + (closed[(edge + 1) % closed.size()] - closed[edge]) * t);
  }
  return out;
}

namespace {

// The nearest edge so far. This is where bakes spend their time: squares only, and a division only for an edge that is
// the nearest.
struct NearestEdge {
  double least = std::numeric_limits<double>::infinity();  // squared
  size_t edge = 0;
  double along = 0;

  void try_edge(const Polyline& closed, size_t i, const glm::dvec2& p) {
    const glm::dvec2& a = closed[i];
    const glm::dvec2 ab = closed[i + 1 < closed.size() ? i + 1 : 0] - a;
    const glm::dvec2 ap = p - a;
    const double dot = glm::dot(ap, ab);
    const double square = glm::dot(ab, ab);
    double t = 0;
    if (dot > 0 && dot < square) {
      const double off = cross(ab, ap);
      if (off * off >= least * square) return;
      t = dot / square;
    } else if (dot > 0) {
      t = 1;
    }
    const glm::dvec2 away = ap - ab * t;
    const double distance = glm::dot(away, away);
    if (distance >= least) return;
    least = distance;
    edge = i;
    along = t;
  }
  NearestPoint point(const Polyline& closed, const glm::dvec2& p) const {
    const glm::dvec2& a = closed[edge];
    NearestPoint out;
    out.edge = edge;
    out.along = along;
    out.point = a + (closed[(edge + 1) % closed.size()] - a) * along;
    out.distance = glm::distance(out.point, p);
    return out;
  }
};

constexpr size_t kRun = 8;  // edges

}  // namespace

NearestPoint nearest_point(const Polyline& closed, const glm::dvec2& p) {
  NearestPoint none;
  none.distance = std::numeric_limits<double>::infinity();
  if (closed.empty()) return none;
  NearestEdge best;
  for (size_t i = 0; i < closed.size(); ++i) best.try_edge(closed, i, p);
  return best.point(closed, p);
}

IndexedLine::IndexedLine(const Polyline& closed) : line_(&closed), perimeter_(renderers::perimeter(closed)) {
  for (size_t first = 0; first < closed.size(); first += kRun) {
    Run run{closed[first], closed[first]};
    for (size_t i = first + 1; i <= std::min(first + kRun, closed.size()); ++i) {
      const glm::dvec2& p = closed[i < closed.size() ? i : 0];
      run.low = glm::min(run.low, p);
      run.high = glm::max(run.high, p);
    }
    runs_.push_back(run);
  }
}

NearestPoint IndexedLine::nearest(const glm::dvec2& p, size_t hint) const {
  const Polyline& closed = *line_;
  NearestPoint none;
  none.distance = std::numeric_limits<double>::infinity();
  if (closed.empty()) return none;
  // The hint only bounds the search, wider than it is by more than rounding makes of a point that lies on its edge: of
  // edges equally near the first is taken, whatever the hint.
  NearestEdge bound;
  bound.try_edge(closed, std::min(hint, closed.size() - 1), p);
  NearestEdge best;
  best.least = bound.least * (1 + 1e-9) + 1e-18;
  for (size_t r = 0; r < runs_.size(); ++r) {
    const glm::dvec2 off = glm::max(glm::max(runs_[r].low - p, p - runs_[r].high), glm::dvec2(0.0));
    if (glm::dot(off, off) > best.least) continue;
    const size_t end = std::min((r + 1) * kRun, closed.size());
    for (size_t i = r * kRun; i < end; ++i) best.try_edge(closed, i, p);
  }
  return best.point(closed, p);
}

Polyline outward_polygon(const Polyline& contour, int corners, double margin, double room) {
  if (contour.empty()) return {};
  Box box = bounds(contour);
  box.low -= room;
  box.high += room;
  const auto holds = [&](const Polyline& polygon) {
    return std::all_of(contour.begin(), contour.end(), [&](const glm::dvec2& p) { return contains(polygon, p); });
  };
  Polyline best;
  Polyline simpler = contour;
  drop_doubles(simpler);
  if (simpler.size() >= 3) simpler = grow_simpler(std::move(simpler), static_cast<size_t>(corners), box);
  if (simpler.size() >= 3 && simpler.size() <= static_cast<size_t>(corners)) {
    Polyline polygon = widen(simpler, margin, box);
    drop_doubles(polygon);
    if (polygon.size() >= 3 && signed_area(polygon) > 0 && is_simple(polygon) && holds(polygon)) best = polygon;
  }
  Polyline convex = convex_around(contour, corners, margin, box);
  drop_doubles(convex);
  return best.empty() || signed_area(convex) < signed_area(best) ? convex : best;
}

}  // namespace crowdbench::renderers
