// Based on: Kavan et al. 2008 (the polygon's corners follow the contour, found by dynamic programming). Differs from
// the source: the corners start from where skinning carries them; they are then moved so that the whole outline,
// carried by the triangles, lies on the frame's outline (least squares); the triangulation is chosen over all frames.
#include "renderers/polypostor/polypostor_fit.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <numeric>

#include "renderers/polypostor/polypostor_torn.h"

namespace crowdbench::renderers {
namespace {

constexpr double kNever = std::numeric_limits<double>::infinity();

double square(double v) { return v * v; }

// The angle from one direction to another, in (-pi, pi].
double turning(const glm::dvec2& a, const glm::dvec2& b) { return std::atan2(cross(a, b), glm::dot(a, b)); }

// What one corner costs at each sample, and the lengths between samples. The samples go round twice, so that those from
// any on follow each other.
struct CostTable {
  size_t corners, samples;
  std::vector<double> unary;    // corners x twice the samples
  std::vector<double> lengths;  // samples x twice the samples
  std::vector<double> edges;    // of the prediction, from each corner to the next
  double edge_weight;

  CostTable(const Polyline& line, const Polyline& predicted, const CorrespondenceWeights& weights)
      : corners(predicted.size()),
        samples(line.size()),
        unary(corners * 2 * samples),
        lengths(samples * 2 * samples),
        edge_weight(weights.edge) {
    for (size_t i = 0; i < corners; ++i) edges.push_back(glm::distance(predicted[i], predicted[(i + 1) % corners]));
    for (size_t a = 0; a < samples; ++a)
      for (size_t b = 0; b < a; ++b) {
        const double length = glm::distance(line[a], line[b]);
        for (const size_t turn : {size_t{0}, samples}) {
          lengths[2 * a * samples + turn + b] = length;
          lengths[2 * b * samples + turn + a] = length;
        }
      }
    const double step = std::max(perimeter(line) / static_cast<double>(samples), 1e-9);
    for (size_t i = 0; i < corners; ++i) {
      const size_t before = (i + corners - 1) % corners;
      const size_t after = (i + 1) % corners;
      const double bend = turning(predicted[i] - predicted[before], predicted[after] - predicted[i]);
      const double arm = std::min(edges[before], edges[i]);
      const auto steps = [&](double length) {
        return static_cast<size_t>(std::clamp(std::round(length / step), 1.0, static_cast<double>(samples) / 3));
      };
      const size_t back = steps(edges[before]);
      const size_t on = steps(edges[i]);
      for (size_t j = 0; j < samples; ++j) {
        const glm::dvec2& p = line[j];
        const double here = turning(p - line[(j + samples - back) % samples], line[(j + on) % samples] - p);
        const glm::dvec2 off = p - predicted[i];
        at(i, j) = at(i, j + samples) = glm::dot(off, off) + weights.turn * square(arm * (here - bend));
      }
    }
  }
  double& at(size_t corner, size_t sample) { return unary[2 * corner * samples + sample]; }
  double at(size_t corner, size_t sample) const { return unary[2 * corner * samples + sample]; }
  // a: below the number of samples; b: below twice that.
  double edge(size_t corner, size_t a, size_t b) const {
    return edge_weight * square(lengths[2 * a * samples + b] - edges[corner]);
  }
};

double area_of(const Polyline& p, const Triangle& t) { return 0.5 * cross(p[t[1]] - p[t[0]], p[t[2]] - p[t[0]]); }

Polyline half_way(const Polyline& a, const Polyline& b) {
  Polyline out;
  for (size_t i = 0; i < a.size(); ++i) out.push_back(0.5 * (a[i] + b[i]));
  return out;
}

void quantise(Polyline& pose, double quantum) {
  if (quantum <= 0) return;
  for (glm::dvec2& p : pose) p = glm::round(p / quantum) * quantum;
}

// A point as a weighted sum of a triangulated polygon's corners.
struct Weights {
  Triangle corners{};
  std::array<double, 3> w{};
};
Weights barycentric(const Polyline& polygon, std::span<const Triangle> triangles, const glm::dvec2& p) {
  Weights best;
  double inmost = -kNever;
  for (const Triangle& t : triangles) {
    const glm::dvec2& a = polygon[t[0]];
    const glm::dvec2 ab = polygon[t[1]] - a;
    const glm::dvec2 ac = polygon[t[2]] - a;
    const double area = cross(ab, ac);
    if (area <= 0) continue;
    const double v = cross(p - a, ac) / area;
    const double w = cross(ab, p - a) / area;
    const double least = std::min({1 - v - w, v, w});
    if (least > inmost) {
      inmost = least;
      best = {t, {1 - v - w, v, w}};
    }
  }
  return best;
}

// Solves a symmetric positive definite system in place (Cholesky), of which only what is on and right of the diagonal
// is read. By rows, each taken from all below it at once: what lies beside each other in memory is reckoned together.
void solve(std::vector<double>& m, std::vector<double>& rhs) {
  const size_t n = rhs.size();
  for (size_t k = 0; k < n; ++k) {
    double* from = m.data() + k * n;
    from[k] = std::sqrt(std::max(from[k], 1e-12));
    for (size_t j = k + 1; j < n; ++j) from[j] /= from[k];
    for (size_t i = k + 1; i < n; ++i) {
      double* row = m.data() + i * n;
      const double by = from[i];
      for (size_t j = i; j < n; ++j) row[j] -= from[j] * by;
    }
  }
  for (size_t k = 0; k < n; ++k) {
    rhs[k] /= m[k * n + k];
    for (size_t i = k + 1; i < n; ++i) rhs[i] -= m[k * n + i] * rhs[k];
  }
  for (size_t i = n; i-- > 0;) {
    for (size_t k = i + 1; k < n; ++k) rhs[i] -= m[i * n + k] * rhs[k];
    rhs[i] /= m[i * n + i];
  }
}

// The key outline, as it is carried by the polygon's triangles.
struct Outline {
  std::vector<Weights> weights;
  std::vector<double> at;  // arc length on the key contour
  glm::dvec2 moved(size_t i, const Polyline& pose) const {
    const Weights& w = weights[i];
    return w.w[0] * pose[w.corners[0]] + w.w[1] * pose[w.corners[1]] + w.w[2] * pose[w.corners[2]];
  }
};

// Moves the corners so that the carried outline lies on the frame's: first each of its points to the point that the
// corners' correspondence says, then to the nearest, mostly across the line. weights: of the points.
Polyline refine(const Outline& outline, const IndexedLine& contour, const Polyline& start,
                const std::vector<glm::dvec2>& targets, const std::vector<double>& weights) {
  constexpr int kRounds = 4;
  constexpr double kStay = 0.1;  // of the outline's points, spread over the corners
  Polyline pose = start;
  const size_t n = pose.size();
  const double stay = kStay * static_cast<double>(outline.weights.size()) / static_cast<double>(n);
  std::vector<double> m(4 * n * n);
  std::vector<double> rhs(2 * n);
  for (int round = 0; round < kRounds; ++round) {
    std::fill(m.begin(), m.end(), 0.0);
    std::fill(rhs.begin(), rhs.end(), 0.0);
    const auto add = [&](const Weights& w, const glm::dvec2& axis, double target, double weight) {
      for (size_t i = 0; i < 3; ++i)
        for (int u = 0; u < 2; ++u) {
          const size_t row = 2 * w.corners[i] + static_cast<size_t>(u);
          const double gi = weight * w.w[i] * axis[u];
          rhs[row] += gi * target;
          for (size_t k = 0; k < 3; ++k) {
            const size_t column = 2 * size_t{w.corners[k]};
            for (size_t v = 0; v < 2; ++v)
              if (column + v <= row) m[(column + v) * 2 * n + row] += gi * w.w[k] * axis[static_cast<int>(v)];
          }
        }
    };
    size_t edge = 0;
    for (size_t i = 0; i < outline.weights.size(); ++i) {
      const glm::dvec2 now = outline.moved(i, pose);
      glm::dvec2 target = targets[i];
      glm::dvec2 normal(1, 0);
      double along = 1;
      if (round > 0) {
        const NearestPoint near = contour.nearest(now, edge);
        target = near.point;
        edge = near.edge;
        const glm::dvec2 off = now - target;
        const double length = glm::length(off);
        if (length > 1e-9) normal = off / length;
        along = 0.1;
      }
      const glm::dvec2 tangent(-normal.y, normal.x);
      add(outline.weights[i], normal, glm::dot(normal, target), weights[i]);
      add(outline.weights[i], tangent, glm::dot(tangent, target), along * weights[i]);
    }
    for (size_t i = 0; i < n; ++i)
      for (size_t u = 0; u < 2; ++u) {
        m[(2 * i + u) * 2 * n + 2 * i + u] += stay;
        rhs[2 * i + u] += stay * start[i][static_cast<int>(u)];
      }
    solve(m, rhs);
    for (size_t i = 0; i < n; ++i) pose[i] = {rhs[2 * i], rhs[2 * i + 1]};
  }
  return pose;
}

// What a pose costs: triangles that it inverts count before all else.
std::pair<size_t, double> cost_of(const Outline& outline, std::span<const Triangle> triangles, const Polyline& pose,
                                  size_t frame, const IndexedLine& contour, const Onlooker& onlooker) {
  Polyline moved;
  for (size_t k = 0; k < outline.weights.size(); ++k) moved.push_back(outline.moved(k, pose));
  return {inverted_triangles(pose, triangles),
          onlooker.cost ? onlooker.cost(frame, moved) : kHidden * area_between(moved, contour)};
}

// Whether the carried outline lies on the frame's, and nothing of the frame's lies elsewhere, within what the masks'
// samples can tell.
bool explains(const Outline& outline, const IndexedLine& contour, const Polyline& pose) {
  constexpr double kMean = 0.2;  // texels
  constexpr double kMost = 0.6;
  double sum = 0;
  Polyline moved;
  size_t edge = 0;
  for (size_t i = 0; i < outline.weights.size(); ++i) {
    moved.push_back(outline.moved(i, pose));
    const NearestPoint near = contour.nearest(moved.back(), edge);
    if (near.distance > kMost) return false;
    sum += near.distance;
    edge = near.edge;
  }
  return sum <= kMean * static_cast<double>(outline.weights.size()) &&
         std::abs(signed_area(moved) - signed_area(contour.line())) <= kMean * contour.perimeter();
}

// Arc lengths on the key contour (of the running `lengths`) of the polygon's corners: ascending, going round once, the
// first in [0, perimeter).
std::vector<double> anchor_arcs(const Polyline& contour, const std::vector<double>& lengths, const Polyline& polygon) {
  const double round = lengths.back();
  std::vector<double> arcs;
  for (const glm::dvec2& p : polygon) {
    const NearestPoint near = nearest_point(contour, p);
    double at = lengths[near.edge] + near.along * (lengths[near.edge + 1] - lengths[near.edge]);
    if (!arcs.empty()) at = arcs.back() + std::fmod(at - arcs.back() + 2 * round, round);
    arcs.push_back(at);
  }
  if (arcs.back() < arcs[0] + round) return arcs;
  // Corners whose nearest points do not follow each other: spread as the polygon's own edges are.
  const double whole = perimeter(polygon);
  double along = 0;
  for (size_t i = 0; i < polygon.size(); ++i) {
    arcs[i] = arcs[0] + along / whole * round;
    along += glm::distance(polygon[i], polygon[(i + 1) % polygon.size()]);
  }
  return arcs;
}

// A point at an arc length along a closed line; lengths beyond one round wrap.
glm::dvec2 point_at(const Polyline& line, const std::vector<double>& lengths, double at) {
  const double round = lengths.back();
  at = std::fmod(std::fmod(at, round) + round, round);
  auto edge = static_cast<size_t>(std::upper_bound(lengths.begin(), lengths.end(), at) - lengths.begin());
  edge = std::clamp<size_t>(edge, 1, line.size()) - 1;
  const double length = lengths[edge + 1] - lengths[edge];
  const double t = length > 0 ? (at - lengths[edge]) / length : 0;
  return line[edge] + (line[(edge + 1) % line.size()] - line[edge]) * t;
}

std::vector<double> running_lengths(const Polyline& line) {
  std::vector<double> lengths{0.0};
  for (size_t i = 0; i < line.size(); ++i)
    lengths.push_back(lengths.back() + glm::distance(line[i], line[(i + 1) % line.size()]));
  return lengths;
}

}  // namespace

double correspondence_cost(const Polyline& samples, const Polyline& predicted, std::span<const size_t> at,
                           const CorrespondenceWeights& weights) {
  const CostTable table(samples, predicted, weights);
  double sum = 0;
  for (size_t i = 0; i < at.size(); ++i) sum += table.at(i, at[i]) + table.edge(i, at[i], at[(i + 1) % at.size()]);
  return sum;
}

Correspondence correspond(const Polyline& samples, const Polyline& predicted, const CorrespondenceWeights& weights) {
  const CostTable table(samples, predicted, weights);
  const size_t n = table.corners;
  const size_t m = table.samples;
  assert(n >= 2 && n <= m);
  Correspondence best;
  best.cost = kNever;
  std::vector<size_t> starts(m);
  std::iota(starts.begin(), starts.end(), size_t{0});
  std::stable_sort(starts.begin(), starts.end(), [&](size_t a, size_t b) { return table.at(0, a) < table.at(0, b); });
  // What the corners from each on cost at least.
  std::vector<double> rest(n + 1, 0);
  for (size_t i = n; i-- > 0;) {
    const auto first = table.unary.begin() + static_cast<std::ptrdiff_t>(2 * i * m);
    rest[i] = rest[i + 1] + *std::min_element(first, first + static_cast<std::ptrdiff_t>(m));
  }
  // cost[i][k]: the least for corners 0 .. i with corner i at the k'th sample after the start.
  std::vector<double> cost(n * m);
  std::vector<size_t> from(n * m);
  for (const size_t start : starts) {
    if (table.at(0, start) + rest[1] >= best.cost) break;
    std::fill(cost.begin(), cost.end(), kNever);
    cost[0] = table.at(0, start);
    for (size_t i = 1; i < n; ++i)
      for (size_t before = i - 1; before + (n - i) < m; ++before) {
        const double so_far = cost[(i - 1) * m + before];
        if (so_far + rest[i] >= best.cost) continue;
        const size_t a = start + before < m ? start + before : start + before - m;
        for (size_t k = before + 1; k + (n - 1 - i) < m; ++k) {
          const double here = so_far + table.edge(i - 1, a, start + k) + table.at(i, start + k);
          if (here < cost[i * m + k]) {
            cost[i * m + k] = here;
            from[i * m + k] = before;
          }
        }
      }
    for (size_t k = n - 1; k < m; ++k) {
      const double whole = cost[(n - 1) * m + k] + table.edge(n - 1, (start + k) % m, start);
      if (whole >= best.cost) continue;
      best.cost = whole;
      best.at.assign(n, 0);
      size_t here = k;
      for (size_t i = n; i-- > 0;) {
        best.at[i] = (start + here) % m;
        here = from[i * m + here];
      }
    }
  }
  return best;
}

size_t inverted_triangles(const Polyline& pose, std::span<const Triangle> triangles) {
  return static_cast<size_t>(std::count_if(triangles.begin(), triangles.end(),
                                           [&](const Triangle& t) { return area_of(pose, t) < kLeastTriangle; }));
}

std::vector<Triangle> triangulate(const Polyline& key, std::span<const Polyline> poses) {
  const size_t n = key.size();
  if (n < 3) return {};
  constexpr double kFolded = 1e6;
  const auto cost_of = [&](const Triangle& t) {
    const double area = area_of(key, t);
    if (area < kLeastTriangle) return kNever;
    double cost = 0;
    for (size_t k = 0; k < 3; ++k) cost += 0.01 * glm::distance(key[t[k]], key[t[(k + 1) % 3]]);
    for (const Polyline& pose : poses) {
      const double there = area_of(pose, t);
      cost += there < kLeastTriangle ? kFolded : std::abs(std::log(there / area));
    }
    return cost;
  };
  // least[i][j]: of the polygon i, i + 1, ..., j.
  std::vector<double> least(n * n, 0);
  std::vector<size_t> apex(n * n, 0);
  for (size_t span = 2; span < n; ++span)
    for (size_t i = 0; i + span < n; ++i) {
      const size_t j = i + span;
      least[i * n + j] = kNever;
      for (size_t k = i + 1; k < j; ++k) {
        const double sides = least[i * n + k] + least[k * n + j];
        if (sides >= least[i * n + j]) continue;
        const double cost =
            sides + cost_of({static_cast<uint16_t>(i), static_cast<uint16_t>(k), static_cast<uint16_t>(j)});
        if (cost >= least[i * n + j]) continue;
        least[i * n + j] = cost;
        apex[i * n + j] = k;
      }
    }
  std::vector<Triangle> out;
  if (least[n - 1] == kNever) return out;
  std::vector<std::array<size_t, 2>> open{{0, n - 1}};
  while (!open.empty()) {
    const auto [i, j] = open.back();
    open.pop_back();
    if (j - i < 2) continue;
    const size_t k = apex[i * n + j];
    out.push_back({static_cast<uint16_t>(i), static_cast<uint16_t>(k), static_cast<uint16_t>(j)});
    open.push_back({i, k});
    open.push_back({k, j});
  }
  return out;
}

Similarity fit_similarity(const Polyline& from, const Polyline& to) {
  glm::dvec2 mean_from(0.0);
  glm::dvec2 mean_to(0.0);
  for (size_t i = 0; i < from.size(); ++i) {
    mean_from += from[i] / static_cast<double>(from.size());
    mean_to += to[i] / static_cast<double>(from.size());
  }
  double dots = 0;
  double crosses = 0;
  double squares = 0;
  for (size_t i = 0; i < from.size(); ++i) {
    const glm::dvec2 p = from[i] - mean_from;
    const glm::dvec2 q = to[i] - mean_to;
    dots += glm::dot(p, q);
    crosses += cross(p, q);
    squares += glm::dot(p, p);
  }
  Similarity s;
  if (squares > 0) {
    s.a = dots / squares;
    s.b = crosses / squares;
  }
  s.shift = mean_to - glm::dvec2(s.a * mean_from.x - s.b * mean_from.y, s.b * mean_from.x + s.a * mean_from.y);
  return s;
}

namespace {

// The polygon at the key, without poses.
Fit start_fit(const Polyline& contour, size_t key, const FitOptions& options) {
  Fit fit;
  fit.key = key;
  fit.polygon = outward_polygon(contour, options.corners, options.margin, options.room);
  quantise(fit.polygon, options.quantum);
  return fit;
}

// The points of the key contour that the polygon's corners hold on to.
struct Anchors {
  std::vector<double> lengths;  // running, of the contour
  std::vector<double> arcs;     // of the anchors, see anchor_arcs
  Polyline points;
  Anchors(const Polyline& contour, const Polyline& polygon)
      : lengths(running_lengths(contour)), arcs(anchor_arcs(contour, lengths, polygon)) {
    for (const double at : arcs) points.push_back(point_at(contour, lengths, at));
  }
};

// Where the part's own motion takes anchors and corners, by frame.
struct Carried {
  std::vector<Polyline> anchors;
  std::vector<Polyline> polygon;
  Carried(const Anchors& from, const Polyline& corners, const std::function<Polyline(const glm::dvec2& p)>& carry,
          size_t frames)
      : anchors(frames), polygon(frames) {
    const auto add = [&](const Polyline& points, std::vector<Polyline>& to) {
      for (const glm::dvec2& p : points) {
        const Polyline there = carry(p);
        for (size_t f = 0; f < frames; ++f) to[f].push_back(there[f]);
      }
    };
    add(from.points, anchors);
    add(corners, polygon);
  }
};

// A frame's outline, and where the anchors went on it; where the part is not seen, nothing but that.
struct Followed {
  bool seen = false;
  Polyline samples;          // of it, evenly spaced
  std::vector<size_t> at;    // by anchor, of the samples
  std::vector<double> arcs;  // by anchor, on the samples as Anchors::arcs on the key contour
};

void follow(const Polyline& contour, const Polyline& predicted, Followed& out) {
  const size_t samples = std::max<size_t>(64, 4 * predicted.size());
  out.samples = resample(contour, samples);
  out.at = correspond(out.samples, predicted).at;
  const double step = perimeter(out.samples) / static_cast<double>(samples);
  for (const size_t sample : out.at) {
    double at = static_cast<double>(sample) * step;
    if (!out.arcs.empty() && at <= out.arcs.back()) at += step * static_cast<double>(samples);
    out.arcs.push_back(at);
  }
}

// Every corner keeps its place beside the outline, turned as the outline is there.
Polyline corners_beside(const Polyline& polygon, const Anchors& anchors, const Followed& followed) {
  const size_t n = polygon.size();
  Polyline out;
  for (size_t i = 0; i < n; ++i) {
    const size_t before = (i + n - 1) % n;
    const size_t after = (i + 1) % n;
    const double turn = turning(anchors.points[after] - anchors.points[before],
                                followed.samples[followed.at[after]] - followed.samples[followed.at[before]]);
    const glm::dvec2 off = polygon[i] - anchors.points[i];
    const double c = std::cos(turn);
    const double s = std::sin(turn);
    out.push_back(followed.samples[followed.at[i]] + glm::dvec2(c * off.x - s * off.y, s * off.x + c * off.y));
  }
  return out;
}

// All corners at the middle: of a part that is not seen.
Polyline gathered(const Polyline& points) {
  glm::dvec2 middle(0.0);
  for (const glm::dvec2& p : points) middle += p / static_cast<double>(points.size());
  return Polyline(points.size(), middle);
}

// The poses in which no triangle may be inverted: those that are seen, and half-way between two that are.
std::vector<Polyline> poses_to_judge(const Fit& fit, std::span<const Followed> followed) {
  std::vector<Polyline> poses;
  for (size_t f = 0; f < fit.poses.size(); ++f) {
    if (!followed[f].seen) continue;
    poses.push_back(fit.poses[f]);
    const size_t next = (f + 1) % fit.poses.size();
    if (next != f && followed[next].seen) poses.push_back(half_way(fit.poses[f], fit.poses[next]));
  }
  return poses;
}

bool has_extent(const Polyline& contour) {
  return std::any_of(contour.begin(), contour.end(), [&](const glm::dvec2& p) { return p != contour[0]; });
}

Outline outline_of(const Polyline& contour, const Anchors& anchors, const Fit& fit) {
  constexpr size_t kPoints = 64;
  Outline outline;
  for (size_t k = 0; k < kPoints; ++k) {
    const double at = anchors.arcs[0] + anchors.lengths.back() * static_cast<double>(k) / kPoints;
    outline.at.push_back(at);
    outline.weights.push_back(barycentric(fit.polygon, fit.triangles, point_at(contour, anchors.lengths, at)));
  }
  return outline;
}

// Where the outline's points lie in a frame, as far along between two anchors as at the key.
std::vector<glm::dvec2> targets_of(const Outline& outline, const Anchors& anchors, const Followed& followed) {
  const size_t n = anchors.arcs.size();
  const std::vector<double> lengths = running_lengths(followed.samples);
  std::vector<glm::dvec2> targets;
  size_t i = 0;
  for (const double at : outline.at) {
    while (i + 1 < n && at >= anchors.arcs[i + 1]) ++i;
    const double begin = anchors.arcs[i];
    const double end = i + 1 < n ? anchors.arcs[i + 1] : anchors.arcs[0] + anchors.lengths.back();
    const double frame_end = i + 1 < n ? followed.arcs[i + 1] : followed.arcs[0] + lengths.back();
    const double t = end > begin ? (at - begin) / (end - begin) : 0;
    targets.push_back(point_at(followed.samples, lengths, followed.arcs[i] + t * (frame_end - followed.arcs[i])));
  }
  return targets;
}

// The outline that a frame is to have, and where the points of the key's go on it.
struct Wanted {
  size_t frame;
  const IndexedLine& contour;
  std::vector<glm::dvec2> targets;
};

// The corners moved onto the frame's outline from where the part's own motion takes them, or from beside it where that
// comes out better; or left where the motion takes them, where that is better still.
Polyline move_onto(const Outline& outline, const Wanted& wanted, const Polyline& carried, const Polyline& beside,
                   std::span<const Triangle> triangles, const Onlooker& onlooker) {
  constexpr double kEnough = 0.05;  // of the perimeter, texels: a fifth of a texel apart where nobody sees it
  std::vector<double> weights;
  for (const glm::dvec2& p : wanted.targets)
    weights.push_back(!onlooker.sees || onlooker.sees(wanted.frame, p) ? 1.0 : kHidden);
  const auto cost = [&](const Polyline& pose) {
    return cost_of(outline, triangles, pose, wanted.frame, wanted.contour, onlooker);
  };
  Polyline best = refine(outline, wanted.contour, carried, wanted.targets, weights);
  auto least = cost(best);
  if (least <= std::pair(size_t{0}, kEnough * wanted.contour.perimeter())) return best;
  for (const Polyline& other : {refine(outline, wanted.contour, beside, wanted.targets, weights), carried}) {
    const auto one = cost(other);
    if (one >= least) continue;
    least = one;
    best = other;
  }
  return best;
}

// Frames in which a triangle is inverted, or half-way to whose next one is, go towards the key's own shape until none
// is.
void unfold(std::span<const Followed> followed, double quantum, Fit& fit) {
  constexpr int kSteps = 4;
  const size_t frames = fit.poses.size();
  std::vector<int> steps(frames, 0);
  const std::vector<Polyline> refined = fit.poses;
  const auto step_back = [&](size_t f) {
    if (!followed[f].seen || steps[f] >= kSteps) return false;
    ++steps[f];
    const Similarity similar = fit_similarity(fit.polygon, refined[f]);
    const double shrink = std::hypot(similar.a, similar.b);
    for (size_t i = 0; i < fit.polygon.size(); ++i) {
      glm::dvec2 shape = similar(fit.polygon[i]);
      if (shrink < 0.05) shape = refined[f][0] + 0.05 * (fit.polygon[i] - fit.polygon[0]);
      fit.poses[f][i] = glm::mix(refined[f][i], shape, static_cast<double>(steps[f]) / kSteps);
    }
    quantise(fit.poses[f], steps[f] < kSteps ? quantum : 0);
    return true;
  };
  for (bool changed = true; changed;) {
    changed = false;
    for (size_t f = 0; f < frames; ++f) {
      if (!followed[f].seen) continue;
      if (inverted_triangles(fit.poses[f], fit.triangles) > 0) changed |= step_back(f);
      const size_t next = (f + 1) % frames;
      if (next == f || !followed[next].seen) continue;
      if (inverted_triangles(half_way(fit.poses[f], fit.poses[next]), fit.triangles) == 0) continue;
      changed |= step_back(f);
      changed |= step_back(next);
    }
  }
  fit.repaired = static_cast<size_t>(std::count_if(steps.begin(), steps.end(), [](int s) { return s > 0; }));
}

// How the part has turned, and how far the moved outline lies from each frame's own.
void judge(std::span<const IndexedLine> contours, const Outline& outline, Fit& fit) {
  const auto points = static_cast<double>(outline.weights.size());
  for (size_t f = 0; f < fit.poses.size(); ++f) {
    const Similarity similar = fit_similarity(fit.polygon, fit.poses[f]);
    const double scale = std::hypot(similar.a, similar.b);
    const bool seen = !contours[f].line().empty();
    fit.turns.push_back(seen && scale > 1e-6 ? glm::dvec2(similar.a, similar.b) / scale : glm::dvec2(1, 0));
    double error = 0;
    Polyline& moved = fit.outlines.emplace_back();
    size_t edge = 0;
    for (size_t k = 0; seen && k < outline.weights.size(); ++k) {
      moved.push_back(outline.moved(k, fit.poses[f]));
      const NearestPoint near = contours[f].nearest(moved.back(), edge);
      error += near.distance / points;
      edge = near.edge;
    }
    fit.errors.push_back(error);
  }
}

}  // namespace

Fit fit_part(const Polyline& image, std::span<const Polyline> contours, size_t key,
             const std::function<Polyline(const glm::dvec2& p)>& carry, const FitOptions& options,
             const Onlooker& onlooker) {
  Fit fit = start_fit(image, key, options);
  if (fit.polygon.size() < 3) return fit;
  const Anchors anchors(image, fit.polygon);
  const Carried carried(anchors, fit.polygon, carry, contours.size());
  std::vector<Followed> followed(contours.size());
  for (size_t f = 0; f < contours.size(); ++f) {
    followed[f].seen = !contours[f].empty();
    if (followed[f].seen) {
      follow(contours[f], carried.anchors[f], followed[f]);
      fit.poses.push_back(corners_beside(fit.polygon, anchors, followed[f]));
    } else {
      fit.poses.push_back(gathered(carried.anchors[f]));
    }
    quantise(fit.poses[f], options.quantum);
  }

  fit.triangles = triangulate(fit.polygon, poses_to_judge(fit, followed));
  if (fit.triangles.empty()) {
    // A corner pressed flat by rounding: the box never is.
    if (options.corners > 4 && has_extent(image))
      return fit_part(image, contours, key, carry, {4, options.margin, options.room, options.quantum}, onlooker);
    Fit empty;
    empty.key = key;
    return empty;
  }

  const Outline outline = outline_of(image, anchors, fit);
  const std::vector<IndexedLine> lines(contours.begin(), contours.end());
  for (size_t f = 0; f < contours.size(); ++f) {
    if (!followed[f].seen) continue;
    const Polyline& there = carried.polygon[f];
    if (explains(outline, lines[f], there) && inverted_triangles(there, fit.triangles) == 0) {
      fit.poses[f] = there;
    } else {
      fit.poses[f] = move_onto(outline, {f, lines[f], targets_of(outline, anchors, followed[f])}, there, fit.poses[f],
                               fit.triangles, onlooker);
    }
    quantise(fit.poses[f], options.quantum);
  }
  unfold(followed, options.quantum, fit);
  judge(lines, outline, fit);
  return fit;
}

}  // namespace crowdbench::renderers
