// The surface of the built-in character: swept cross-sections, joined where a body is one surface (a shirt's sleeves
// leave its torso through an armhole, a pair of trousers parts at the crotch), hidden inside each other where clothes
// meet skin. Every piece is closed.
#include <algorithm>
#include <cassert>
#include <cmath>
#include <functional>
#include <map>
#include <span>
#include <tuple>

#include "scene/mannequin/mannequin_shape.h"
#include "scene/mannequin/mannequin_weights.h"

namespace crowdbench::scene::mannequin {
namespace {

using glm::dvec2;
using glm::dvec3;

// ---------------------------------------------------------------------------------------------------------------
// Assembly.

struct Corner {
  int point;
  dvec2 uv;
};
using Triangle = std::array<Corner, 3>;

struct Point {
  dvec3 position;
  Influences influences;
};

// One closed row of a swept surface and where it lies in its chart.
struct Ring {
  std::vector<int> points;
  double v = 0;
};

class Builder {
 public:
  Builder(int joints) : full_(joints == kFullJoints) {}
  bool full() const { return full_; }

  int add(const dvec3& position, Influences influences) {
    points_.push_back({position, std::move(influences)});
    return static_cast<int>(points_.size()) - 1;
  }
  const dvec3& at(int point) const { return points_[static_cast<size_t>(point)].position; }

  void triangle(const Corner& a, const Corner& b, const Corner& c) {
    if (a.point != b.point && b.point != c.point && c.point != a.point) piece_.push_back({a, b, c});
  }
  // Split along the shorter diagonal, which follows the surface better.
  void quad(const Corner& a, const Corner& b, const Corner& c, const Corner& d) {
    if (glm::distance(at(a.point), at(c.point)) <= glm::distance(at(b.point), at(d.point)) + 1e-9) {
      triangle(a, b, c);
      triangle(a, c, d);
    } else {
      triangle(a, b, d);
      triangle(b, c, d);
    }
  }
  // Between two rings of equal size.
  void band(const Ring& low, const Ring& high, int chart_id) {
    const size_t n = low.points.size();
    assert(high.points.size() == n);
    for (size_t i = 0; i < n; ++i) {
      const size_t next = (i + 1) % n;
      const double u0 = static_cast<double>(i) / static_cast<double>(n);
      const double u1 = static_cast<double>(i + 1) / static_cast<double>(n);
      quad({low.points[i], chart_uv(chart_id, u0, 1 - low.v)}, {low.points[next], chart_uv(chart_id, u1, 1 - low.v)},
           {high.points[next], chart_uv(chart_id, u1, 1 - high.v)},
           {high.points[i], chart_uv(chart_id, u0, 1 - high.v)});
    }
  }
  // Closes a ring without a middle point: a strip across it. `uv` places each of its points.
  void cap(const Ring& ring, const std::function<dvec2(size_t)>& uv) {
    const size_t n = ring.points.size();
    size_t low = 0;
    size_t high = n - 1;
    while (high - low >= 2) {
      const Corner a{ring.points[low], uv(low)};
      const Corner b{ring.points[low + 1], uv(low + 1)};
      const Corner c{ring.points[high], uv(high)};
      triangle(a, b, c);
      ++low;
      if (high - low >= 2) {
        triangle(b, {ring.points[high - 1], uv(high - 1)}, c);
        --high;
      }
    }
  }
  void cap(const Ring& ring, int chart_id) {
    cap(ring, [&](size_t i) {
      return chart_uv(chart_id, static_cast<double>(i) / static_cast<double>(ring.points.size()), 1 - ring.v);
    });
  }
  // A ring shut to one point.
  void tip(const Ring& ring, int point, double v, int chart_id) {
    const size_t n = ring.points.size();
    for (size_t i = 0; i < n; ++i) {
      const double u0 = static_cast<double>(i) / static_cast<double>(n);
      const double u1 = static_cast<double>(i + 1) / static_cast<double>(n);
      triangle({ring.points[i], chart_uv(chart_id, u0, 1 - ring.v)},
               {ring.points[(i + 1) % n], chart_uv(chart_id, u1, 1 - ring.v)},
               {point, chart_uv(chart_id, 0.5 * (u0 + u1), 1 - v)});
    }
  }

  // Ends one closed piece: turns every triangle so that its front is outside and files it under its material.
  void finish(Slot slot);

  Mesh mesh() const;

 private:
  bool full_;
  std::vector<Point> points_;
  std::vector<Triangle> piece_;
  std::array<std::vector<Triangle>, kSlotCount> by_slot_;
};

void Builder::finish(Slot slot) {
  // Neighbours agree when they run along their common edge in opposite directions: from the first triangle outwards,
  // each one is turned to agree with the neighbour that it was reached from.
  std::map<std::pair<int, int>, std::vector<size_t>> by_edge;
  for (size_t t = 0; t < piece_.size(); ++t) {
    for (size_t i = 0; i < 3; ++i) {
      by_edge[std::minmax(piece_[t][i].point, piece_[t][(i + 1) % 3].point)].push_back(t);
    }
  }
  const auto runs = [&](size_t t, int from, int to) {
    for (size_t i = 0; i < 3; ++i) {
      if (piece_[t][i].point == from && piece_[t][(i + 1) % 3].point == to) return true;
    }
    return false;
  };
  std::vector<bool> seen(piece_.size(), false);
  std::vector<size_t> queue{0};
  seen[0] = true;
  while (!queue.empty()) {
    const size_t t = queue.back();
    queue.pop_back();
    const Triangle here = piece_[t];
    for (size_t i = 0; i < 3; ++i) {
      const int a = here[i].point;
      const int b = here[(i + 1) % 3].point;
      for (const size_t other : by_edge[std::minmax(a, b)]) {
        if (seen[other]) continue;
        seen[other] = true;
        if (runs(other, a, b)) std::swap(piece_[other][1], piece_[other][2]);
        queue.push_back(other);
      }
    }
  }
  double volume = 0;
  for (const Triangle& t : piece_) {
    volume += glm::dot(at(t[0].point), glm::cross(at(t[1].point), at(t[2].point)));
  }
  for (Triangle& t : piece_) {
    if (volume < 0.0) std::swap(t[1], t[2]);
    by_slot_[slot].push_back(t);
  }
  piece_.clear();
}

Mesh Builder::mesh() const {
  std::vector<dvec3> normals(points_.size(), dvec3(0.0));
  for (const auto& slot : by_slot_) {
    for (const Triangle& t : slot) {
      const dvec3 area = glm::cross(at(t[1].point) - at(t[0].point), at(t[2].point) - at(t[0].point));
      for (const Corner& c : t) normals[static_cast<size_t>(c.point)] += area;
    }
  }
  Mesh mesh;
  for (int slot = 0; slot < kSlotCount; ++slot) {
    Primitive primitive;
    primitive.first_index = static_cast<uint32_t>(mesh.indices.size());
    primitive.first_vertex = static_cast<uint32_t>(mesh.positions.size());
    primitive.material = slot;
    std::map<std::tuple<int, double, double>, uint32_t> made;
    for (const Triangle& t : by_slot_[static_cast<size_t>(slot)]) {
      for (const Corner& c : t) {
        const auto [it, fresh] =
            made.try_emplace({c.point, c.uv.x, c.uv.y}, static_cast<uint32_t>(mesh.positions.size()));
        mesh.indices.push_back(it->second);
        if (!fresh) continue;
        const Point& point = points_[static_cast<size_t>(c.point)];
        mesh.positions.emplace_back(point.position);
        mesh.normals.emplace_back(glm::normalize(normals[static_cast<size_t>(c.point)]));
        mesh.uvs.emplace_back(c.uv);
        Influences kept = point.influences;
        std::ranges::stable_sort(kept, [](const Influence& a, const Influence& b) { return a.weight > b.weight; });
        kept.resize(std::max(kept.size(), size_t{kInfluences}), {0, 0.0});
        double sum = 0;
        for (int i = 0; i < kInfluences; ++i) sum += kept[static_cast<size_t>(i)].weight;
        glm::u16vec4 joints{0};
        glm::vec4 weights{0.0F};
        for (int i = 0; i < kInfluences; ++i) {
          const Influence& k = kept[static_cast<size_t>(i)];
          if (k.weight / sum < 1e-4) continue;
          joints[i] = static_cast<uint16_t>(k.joint);
          weights[i] = static_cast<float>(k.weight / sum);
        }
        mesh.joints.push_back(joints);
        mesh.weights.push_back(weights / (weights.x + weights.y + weights.z + weights.w));
      }
    }
    primitive.index_count = static_cast<uint32_t>(mesh.indices.size()) - primitive.first_index;
    primitive.vertex_count = static_cast<uint32_t>(mesh.positions.size()) - primitive.first_vertex;
    mesh.primitives.push_back(primitive);
  }
  return mesh;
}

// ---------------------------------------------------------------------------------------------------------------
// Levels of detail: how many columns, and which rows.

struct Detail {
  int head_columns;
  std::vector<double> head_rows;  // y
  int hair_columns, hair_rows;
  bool ears;
  bool folds;                      // hems and collar turn inwards before they are closed
  int torso_columns;               // a multiple of 4
  int hole_half;                   // half the armhole's width in columns
  std::vector<double> torso_low;   // y below the armhole; the last is its bottom
  std::vector<double> torso_hole;  // y inside the armhole
  std::vector<double> torso_high;  // y from the armhole's top upwards
  std::vector<double> sleeve;      // t
  int arm_columns;
  std::vector<double> arm_rows;  // t
  bool fingers;
  int thumb_columns;
  std::vector<double> pelvis_rows;  // y, upwards from the crotch's ring
  int crotch_points;                // between front and back
  std::vector<double> leg_rows;     // y, downwards
  int shoe_columns;                 // even
  std::vector<double> shoe_rows;    // into kShoe
};

Detail finest() {
  return {
      24,
      {1.435, 1.475, 1.505, 1.524, 1.536, 1.548, 1.562, 1.577, 1.590, 1.604, 1.613, 1.628, 1.644, 1.660, 1.682, 1.712},
      24,
      7,
      true,
      true,
      24,
      2,
      {0.960, 1.008, 1.036, 1.085, 1.135, 1.190, 1.250, 1.308},
      {1.352, 1.398},
      {1.442, 1.455, 1.467, 1.477, 1.486, 1.501},
      {.026, .052, .082, .115, .155, .195, .230},
      10,
      {.150, .235, .265, .300, .335, .375, .430, .490, .530, .560, .587, .617, .636, .646},
      true,
      6,
      {0.858, 0.890, 0.930, 0.968, 1.000, 1.017},
      3,
      {0.785, 0.715, 0.635, 0.570, 0.525, 0.485, 0.445, 0.390, 0.315, 0.215, 0.115, 0.046, 0.028},
      16,
      {0, 1, 2, 3, 4, 5, 6, 8}};
}

Detail middle() {
  return {16,
          {1.440, 1.485, 1.522, 1.540, 1.560, 1.584, 1.602, 1.613, 1.640, 1.668, 1.705},
          14,
          4,
          false,
          true,
          16,
          1,
          {0.965, 1.036, 1.120, 1.220, 1.308},
          {1.370},
          {1.442, 1.464, 1.482, 1.500},
          {.060, .115, .190, .230},
          8,
          {.160, .245, .290, .335, .410, .510, .548, .590, .632, .680, .722},
          false,
          5,
          {0.858, 0.900, 0.955, 1.016},
          2,
          {0.770, 0.670, 0.565, 0.500, 0.440, 0.360, 0.220, 0.100, 0.030},
          10,
          {0, 1.5, 3, 4, 5.5, 8}};
}

Detail coarsest() {
  return {8,
          {1.460, 1.525, 1.552, 1.611, 1.680},
          6,
          2,
          false,
          false,
          8,
          1,
          {0.990, 1.130, 1.308},
          {},
          {1.440, 1.488},
          {.080, .225},
          5,
          {.190, .285, .520, .610, .715},
          false,
          0,
          {0.858, 1.012},
          1,
          {0.740, 0.500, 0.330, 0.040},
          6,
          {0, 3, 8}};
}

Detail detail(int triangles) { return triangles == 5000 ? finest() : triangles == 2200 ? middle() : coarsest(); }

// ---------------------------------------------------------------------------------------------------------------
// Pieces.

// A thick leaf leaning back and out, its root inside the head.
void build_ear(Builder& b, int side) {
  struct Row {
    double out, scale;
  };
  constexpr Row kRows[] = {{-.006, .70}, {.004, .95}, {.0105, 1.08}, {.0125, .66}};
  std::vector<Ring> ear;
  for (const Row& row : kRows) {
    Ring ring;
    ring.v = (row.out + .006) / .0185;
    for (int i = 0; i < 8; ++i) {
      const SinCos turn = sincos_turns(i / 8.0);
      dvec3 p{0.0728 + row.out, 1.628 + 0.0285 * row.scale * turn.cos,
              -0.008 - row.out * 0.80 + 0.0160 * row.scale * turn.sin * (1.0 + 0.25 * turn.cos)};
      p.z -= 0.004 * turn.cos;
      p = mirrored(p, side);
      ring.points.push_back(b.add(p, head_weights(p, b.full())));
    }
    ear.push_back(std::move(ring));
  }
  b.cap(ear.front(), chart_ear);
  for (size_t r = 0; r + 1 < ear.size(); ++r) b.band(ear[r], ear[r + 1], chart_ear);
  b.cap(ear.back(), chart_ear);
  b.finish(skin);
}

void build_head(Builder& b, const Detail& d) {
  const auto weights = [&](const dvec3& p) { return head_weights(p, b.full()); };
  std::vector<Ring> rings;
  for (const double y : d.head_rows) {
    Ring ring;
    ring.v = (y - kHeadLow) / (kHeadHigh - kHeadLow);
    for (int i = 0; i < d.head_columns; ++i) {
      const dvec3 p = head_shape(static_cast<double>(i) / d.head_columns, y);
      ring.points.push_back(b.add(p, weights(p)));
    }
    rings.push_back(std::move(ring));
  }
  b.cap(rings.front(), chart_head);
  for (size_t r = 0; r + 1 < rings.size(); ++r) b.band(rings[r], rings[r + 1], chart_head);
  const dvec3 crown{0.0, kHeadHigh + 0.002, -0.010};
  b.tip(rings.back(), b.add(crown, weights(crown)), 1.0, chart_head);
  b.finish(skin);

  if (!d.ears) return;
  for (int side = 0; side < 2; ++side) build_ear(b, side);
}

void build_hair(Builder& b, const Detail& d) {
  const auto weights = [&](const dvec3& p) { return head_weights(p, b.full()); };
  std::vector<Ring> rings;
  // Row -1 lies under the scalp and closes the piece; row 0 is the edge.
  for (int row = -1; row < d.hair_rows; ++row) {
    Ring ring;
    const double v = static_cast<double>(row) / d.hair_rows;
    ring.v = std::max(v, 0.0);
    for (int i = 0; i < d.hair_columns; ++i) {
      const double u = static_cast<double>(i) / d.hair_columns;
      dvec3 p = hair_point(u, std::max(v, 0.0));
      if (row < 0) {
        const dvec3 inside{0.0, 1.66, 0.0};
        p = inside + (p - inside) * 0.86;
      }
      ring.points.push_back(b.add(p, weights(p)));
    }
    rings.push_back(std::move(ring));
  }
  b.cap(rings.front(), chart_hair);
  for (size_t r = 0; r + 1 < rings.size(); ++r) b.band(rings[r], rings[r + 1], chart_hair);
  const dvec3 crown = hair_point(0.0, 1.0);
  b.tip(rings.back(), b.add(crown, weights(crown)), 1.0, chart_hair);
  b.finish(hair);
}

// The torso's rows and columns, and where they leave the armholes open.
struct TorsoGrid {
  int columns;
  int hole_half;             // half an armhole's width in columns
  std::vector<double> rows;  // y
  size_t bottom, top;        // the armholes' first and last row

  explicit TorsoGrid(const Detail& d)
      : columns(d.torso_columns), hole_half(d.hole_half), rows(d.torso_low), bottom(rows.size() - 1) {
    rows.insert(rows.end(), d.torso_hole.begin(), d.torso_hole.end());
    top = rows.size();
    rows.insert(rows.end(), d.torso_high.begin(), d.torso_high.end());
  }
  // The column of an armhole's middle.
  int middle(int side) const { return side == 0 ? columns / 4 : 3 * columns / 4; }
  // Whether the quad right of the column and above the row is left out.
  bool open(int column, size_t row) const {
    if (row < bottom || row >= top) return false;
    return (column >= middle(0) - hole_half && column < middle(0) + hole_half) ||
           (column >= middle(1) - hole_half && column < middle(1) + hole_half);
  }
  // Whether a point lies within an armhole, not on its edge.
  bool inside(int column, size_t row) const {
    if (row <= bottom || row >= top) return false;
    return std::abs(column - middle(0)) < hole_half || std::abs(column - middle(1)) < hole_half;
  }
};

std::vector<Ring> torso_rings(Builder& b, const TorsoGrid& grid) {
  std::vector<Ring> rings;
  for (size_t r = 0; r < grid.rows.size(); ++r) {
    Ring ring;
    ring.v = (grid.rows[r] - kTorsoLow) / (kTorsoHigh - kTorsoLow);
    for (int i = 0; i < grid.columns; ++i) {
      const dvec3 p = torso_shape(static_cast<double>(i) / grid.columns, grid.rows[r]);
      ring.points.push_back(grid.inside(i, r) ? -1 : b.add(p, torso_weights(p, false)));
    }
    rings.push_back(std::move(ring));
  }
  return rings;
}

void build_torso(Builder& b, const TorsoGrid& grid, const std::vector<Ring>& rings) {
  const int n = grid.columns;
  b.cap(rings.front(), chart_torso);
  for (size_t r = 0; r + 1 < rings.size(); ++r) {
    for (int i = 0; i < n; ++i) {
      if (grid.open(i, r)) continue;
      const auto c = static_cast<size_t>(i);
      const size_t next = (c + 1) % static_cast<size_t>(n);
      const double u0 = static_cast<double>(i) / n;
      const double u1 = static_cast<double>(i + 1) / n;
      b.quad({rings[r].points[c], chart_uv(chart_torso, u0, 1 - rings[r].v)},
             {rings[r].points[next], chart_uv(chart_torso, u1, 1 - rings[r].v)},
             {rings[r + 1].points[next], chart_uv(chart_torso, u1, 1 - rings[r + 1].v)},
             {rings[r + 1].points[c], chart_uv(chart_torso, u0, 1 - rings[r + 1].v)});
    }
  }
}

// Closes the torso's uppermost ring. With folds the collar turns inwards and ends below, around the neck.
void build_collar(Builder& b, const Ring& upper, bool folds) {
  if (!folds) {
    b.cap(upper, chart_torso);
    return;
  }
  Ring inner;
  inner.v = 1.0;
  for (const int point : upper.points) {
    const dvec3 p = b.at(point);
    const dvec3 q{p.x * 0.80, p.y - 0.022, -0.012 + (p.z + 0.012) * 0.80};
    inner.points.push_back(b.add(q, torso_weights(p, false)));
  }
  b.band(upper, inner, chart_torso);
  b.cap(inner, chart_torso);
}

// An armhole's edge, once around from the middle of its top over the front.
Ring armhole(const TorsoGrid& grid, const std::vector<Ring>& rings, int side) {
  Ring edge;
  edge.v = 1.0;
  const int middle = grid.middle(side);
  const int step = side == 0 ? 1 : -1;  // towards the front
  const auto add = [&](int k, size_t row) {
    edge.points.push_back(rings[row].points[static_cast<size_t>(middle + step * k)]);
  };
  for (int k = 0; k < grid.hole_half; ++k) add(k, grid.top);
  for (size_t r = grid.top; r > grid.bottom; --r) add(grid.hole_half, r);
  for (int k = grid.hole_half; k > -grid.hole_half; --k) add(k, grid.bottom);
  for (size_t r = grid.bottom; r < grid.top; ++r) add(-grid.hole_half, r);
  for (int k = grid.hole_half; k > 0; --k) add(-k, grid.top);
  return edge;
}

// From an armhole to the hem.
void build_sleeve(Builder& b, const Detail& d, Ring previous, int side) {
  const auto columns = static_cast<int>(previous.points.size());
  const auto ring_at = [&](double t, double shrink, double v) {
    const auto p = along<2>(kSleeve, t);
    Ring ring;
    ring.v = v;
    for (int i = 0; i < columns; ++i) {
      const SinCos turn = sincos_turns(static_cast<double>(i) / columns);
      // Near the shoulder the rings lean with the armhole, whose lower end lies further along the arm.
      const double lean = 0.60 * smooth(0.17, 0.05, t) * p[1];
      const dvec3 q = mirrored(
          arm_point(t - lean * turn.cos) + kArmUp * (p[1] * shrink * turn.cos) + kForward * (p[0] * shrink * turn.sin),
          side);
      ring.points.push_back(b.add(q, torso_weights(q, true)));
    }
    return ring;
  };
  for (const double t : d.sleeve) {
    Ring ring = ring_at(t, 1.0, 1.0 - t / d.sleeve.back());
    b.band(previous, ring, chart_sleeve);
    previous = std::move(ring);
  }
  if (d.folds) {
    Ring hem = ring_at(d.sleeve.back() - 0.015, 0.62, 0.0);
    b.band(previous, hem, chart_sleeve);
    previous = std::move(hem);
  }
  b.cap(previous, chart_sleeve);
}

void build_shirt(Builder& b, const Detail& d) {
  const TorsoGrid grid(d);
  const std::vector<Ring> rings = torso_rings(b, grid);
  build_torso(b, grid, rings);
  build_collar(b, rings.back(), d.folds);
  for (int side = 0; side < 2; ++side) build_sleeve(b, d, armhole(grid, rings, side), side);
  b.finish(shirt);
}

// digit: 0 is the thumb.
void build_finger(Builder& b, int columns, int side, int digit) {
  const auto chain = finger_chain(side, digit);
  const double thick = digit == 0 ? 0.0112 : digit == 4 ? 0.0078 : 0.0090;
  const dvec3 across = glm::normalize(digit == 0 ? mirrored(dvec3(0.45, 0.45, -0.77), side) : kForward);
  const auto weights = [&](const dvec3& p) {
    return b.full() ? finger_weights(p, digit) : Influences{{hand(side), 1.0}};
  };
  struct Row {
    int bone;
    double share, radius;  // of the bone's length; of the thickness
  };
  constexpr Row kRows[] = {{0, -0.30, 1.05}, {1, 0.0, 1.0}, {2, 0.0, 0.92}, {2, 0.78, 0.72}};
  std::vector<Ring> rings;
  for (const Row& row : kRows) {
    const auto bone = static_cast<size_t>(row.bone);
    const dvec3 direction = glm::normalize(chain[bone + 1] - chain[bone]);
    const dvec3 other = glm::normalize(glm::cross(direction, across));
    const dvec3 sideways = glm::cross(other, direction);
    Ring ring;
    ring.v = std::max(0.0, (row.bone + row.share) / 3.0);
    const dvec3 centre = chain[bone] + (chain[bone + 1] - chain[bone]) * row.share;
    for (int i = 0; i < columns; ++i) {
      const SinCos turn = sincos_turns(static_cast<double>(i) / columns);
      const dvec3 q = centre + (sideways * turn.cos + other * turn.sin) * (thick * row.radius);
      ring.points.push_back(b.add(q, weights(q)));
    }
    rings.push_back(std::move(ring));
  }
  b.cap(rings.front(), chart_finger);
  for (size_t r = 0; r + 1 < rings.size(); ++r) b.band(rings[r], rings[r + 1], chart_finger);
  b.tip(rings.back(), b.add(chain[3], weights(chain[3])), 1.0, chart_finger);
  b.finish(skin);
}

void build_arm(Builder& b, const Detail& d, int side) {
  const auto ring_at = [&](double t) {
    const auto p = along<4>(kArm, t);
    Ring ring;
    ring.v = 1.0 - (t - 0.14) / (0.722 - 0.14);
    for (int i = 0; i < d.arm_columns; ++i) {
      // From the back edge over the palm's side to the thumb's edge and over the back of the hand.
      const SinCos turn = sincos_turns((i + 0.5) / d.arm_columns);
      const dvec2 round = rounded(turn.sin, -turn.cos, t > kWrist ? 0.20 : 0.0);
      const dvec3 q =
          mirrored(arm_point(t) + kForward * (p[2] + p[0] * round.y) + kPalm * (p[3] + p[1] * round.x), side);
      const bool mitten = t > kKnuckles && b.full();
      ring.points.push_back(b.add(q, mitten ? finger_weights(q, -1) : arm_weights(q, b.full())));
    }
    return ring;
  };
  Ring previous = ring_at(d.arm_rows.front());
  b.cap(previous, chart_arm);
  for (size_t r = 1; r < d.arm_rows.size(); ++r) {
    Ring ring = ring_at(d.arm_rows[r]);
    b.band(previous, ring, chart_arm);
    previous = std::move(ring);
  }
  b.cap(previous, chart_arm);
  b.finish(skin);

  for (int digit = 0; digit < 5; ++digit) {
    const int columns = digit == 0 ? d.thumb_columns : 5;
    if ((digit == 0 || d.fingers) && columns > 0) build_finger(b, columns, side, digit);
  }
}

// From the crotch's ring up to the waist. Returns the crotch's ring.
Ring build_pelvis(Builder& b, const Detail& d) {
  const int n = d.torso_columns;
  const auto ring_at = [&](double y, double shrink, double v) {
    Ring ring;
    ring.v = v;
    for (int i = 0; i < n; ++i) {
      dvec3 p = pelvis_shape(static_cast<double>(i) / n, y);
      p.x *= shrink;
      p.z *= shrink;
      ring.points.push_back(b.add(p, leg_weights(p)));
    }
    return ring;
  };
  const double low = d.pelvis_rows.front();
  const double high = d.pelvis_rows.back();
  std::vector<Ring> pelvis;
  for (const double y : d.pelvis_rows) pelvis.push_back(ring_at(y, 1.0, (y - low) / (high - low)));
  for (size_t r = 0; r + 1 < pelvis.size(); ++r) b.band(pelvis[r], pelvis[r + 1], chart_pelvis);
  Ring waist = pelvis.back();
  if (d.folds) {
    waist = ring_at(high - 0.012, 0.84, 1.0);
    b.band(pelvis.back(), waist, chart_pelvis);
  }
  b.cap(waist, chart_pelvis);
  return pelvis.front();
}

// The crotch's line, from the front to the back, shared by both legs.
std::vector<int> crotch_line(Builder& b, const Detail& d, const Ring& split) {
  const dvec3 front = b.at(split.points[static_cast<size_t>(d.torso_columns / 2)]);
  const dvec3 back = b.at(split.points[0]);
  const double low = d.pelvis_rows.front();
  std::vector<int> line;
  for (int i = 1; i <= d.crotch_points; ++i) {
    const double t = static_cast<double>(i) / (d.crotch_points + 1);
    const double z = front.z + (back.z - front.z) * t;
    const dvec3 p{0.0, low - 0.052 * (1.0 - square(square(2.0 * t - 1.0))), z};
    line.push_back(b.add(p, leg_weights(p)));
  }
  return line;
}

// split: the crotch's ring; line: crotch_line().
void build_leg(Builder& b, const Detail& d, const Ring& split, const std::vector<int>& line, int side) {
  // Once around the leg, from the back middle over the outside to the front middle, and back along the crotch.
  const int n = d.torso_columns;
  const int half = n / 2;
  Ring previous;
  previous.v = 1.0;
  for (int i = 0; i <= half; ++i)
    previous.points.push_back(split.points[static_cast<size_t>(side == 0 ? i : (n - i) % n)]);
  previous.points.insert(previous.points.end(), line.begin(), line.end());
  const auto columns = static_cast<int>(previous.points.size());
  const double outer = static_cast<double>(half) / columns;  // of the full turn
  const auto ring_at = [&](double y, double shrink, double v) {
    const auto p = along<4>(kLeg, y);
    Ring ring;
    ring.v = v;
    for (int i = 0; i < columns; ++i) {
      // The outer arc is centred on the outward direction: a quarter turn from the back.
      const SinCos turn = sincos_turns(0.25 - 0.5 * outer + static_cast<double>(i) / columns);
      const double z = 0.5 * (p[0] + p[1]);
      const dvec2 round = rounded(turn.sin, -turn.cos, 0.08);
      const dvec3 q = mirrored({p[2] + p[3] * shrink * round.x, y, z + 0.5 * (p[0] - p[1]) * shrink * round.y}, side);
      ring.points.push_back(b.add(q, leg_weights(q)));
    }
    return ring;
  };
  const double low = d.pelvis_rows.front();
  const double hem = d.leg_rows.back();
  for (const double y : d.leg_rows) {
    Ring ring = ring_at(y, 1.0, (y - hem) / (low - hem));
    b.band(previous, ring, chart_leg);
    previous = std::move(ring);
  }
  if (d.folds) {
    Ring fold = ring_at(hem + 0.012, 0.70, 0.0);
    b.band(previous, fold, chart_leg);
    previous = std::move(fold);
  }
  b.cap(previous, chart_leg);
}

void build_trousers(Builder& b, const Detail& d) {
  const Ring split = build_pelvis(b, d);
  const std::vector<int> line = crotch_line(b, d, split);
  for (int side = 0; side < 2; ++side) build_leg(b, d, split, line, side);
  b.finish(trousers);
}

void build_shoe(Builder& b, const Detail& d, int side) {
  std::vector<Ring> rings;
  for (const double row : d.shoe_rows) {
    Ring ring;
    ring.v = row / 8.0;
    for (int i = 0; i < d.shoe_columns; ++i) {
      const dvec3 p = mirrored(shoe_shape(static_cast<double>(i) / d.shoe_columns, row), side);
      ring.points.push_back(b.add(p, shoe_weights(p)));
    }
    rings.push_back(std::move(ring));
  }
  b.cap(rings.front(), [&](size_t i) {
    const dvec3 p = mirrored(b.at(rings.front().points[i]), side);
    return chart_uv(chart_sole, (p.x - 0.04) / 0.13, (0.20 - p.z) / 0.30);
  });
  for (size_t r = 0; r + 1 < rings.size(); ++r) b.band(rings[r], rings[r + 1], chart_shoe);
  b.cap(rings.back(), chart_shoe);
  b.finish(shoes);
}

constexpr Chart kChartTable[kCharts] = {
    {0, 0, 512, 512},      // head
    {512, 0, 256, 256},    // hair
    {0, 512, 512, 512},    // torso
    {512, 256, 256, 192},  // sleeve
    {768, 0, 256, 256},    // arm
    {768, 256, 96, 96},    // finger
    {864, 256, 96, 96},    // ear
    {512, 512, 512, 192},  // pelvis
    {512, 704, 320, 320},  // leg
    {832, 704, 192, 192},  // shoe
    {832, 896, 96, 128},   // sole
};

}  // namespace

const Chart& chart(int id) { return kChartTable[id]; }

dvec2 chart_uv(int id, double u, double v) {
  const Chart& c = kChartTable[id];
  return {(c.x + kGutter + u * (c.width - 2 * kGutter)) / kTextureSide,
          (c.y + kGutter + v * (c.height - 2 * kGutter)) / kTextureSide};
}

Mesh make_mesh(int triangles, int joints) {
  const Detail d = detail(triangles);
  Builder b(joints);
  build_head(b, d);
  build_hair(b, d);
  build_shirt(b, d);
  build_trousers(b, d);
  for (int side = 0; side < 2; ++side) {
    build_arm(b, d, side);
    build_shoe(b, d, side);
  }
  return b.mesh();
}

}  // namespace crowdbench::scene::mannequin
