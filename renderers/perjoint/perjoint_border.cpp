// Based on: Beacco, Spanlang, Andujar and Pelechano 2012 (joint borders optimised over animations). Differs from the
// source: README.md.
#include "renderers/perjoint/perjoint_border.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <set>
#include <tuple>

#include "core/parallel.h"
#include "renderers/impostor/tiles/plane.h"
#include "renderers/impostor/tiles/tile_capture.h"

namespace crowdbench::renderers {
namespace {

constexpr int kSide = 128;      // pixels of a mask
constexpr double kFigure = 96;  // pixels that the rest pose's longest side takes
constexpr size_t kPoses = 12;   // over all clips, one a clip at least
constexpr size_t kMostPoses = 64;
constexpr uint64_t kHoleWeight = 2;  // pixels of strays that one of holes counts for
constexpr int kRounds = 4;

using PieceMask = std::array<uint64_t, kSide * kSide / 64>;

// Orthographic, from one side.
struct MaskView {
  glm::dvec3 to_eye, right, up;
};

MaskView mask_view(double azimuth, double elevation) {
  MaskView view;
  view.to_eye = {std::cos(elevation) * std::sin(azimuth), std::sin(elevation), std::cos(elevation) * std::cos(azimuth)};
  view.right = glm::normalize(glm::cross(glm::dvec3(0, 1, 0), view.to_eye));
  view.up = glm::cross(view.to_eye, view.right);
  return view;
}

// Four sides a quarter of a half turn apart, the opposite ones having the same silhouettes, a little from above.
std::array<MaskView, 4> mask_views() {
  constexpr double kStep = std::numbers::pi / 4;
  return {mask_view(0.2, 0.2), mask_view(0.2 + kStep, 0.2), mask_view(0.2 + 2 * kStep, 0.2),
          mask_view(0.2 + 3 * kStep, 0.2)};
}

void fill(PieceMask& mask, const glm::vec2& a, const glm::vec2& b, const glm::vec2& c) {
  const float twice = (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
  if (!(std::abs(twice) > 1e-9F)) return;
  const glm::vec2 low = glm::min(a, glm::min(b, c));
  const glm::vec2 high = glm::max(a, glm::max(b, c));
  const auto pixel = [](float v) {
    return std::clamp(static_cast<int>(std::floor(std::clamp(v, -1e6F, 1e6F))), 0, kSide - 1);
  };
  const float sign = twice > 0 ? 1.0F : -1.0F;
  const auto inside = [&](const glm::vec2& from, const glm::vec2& to, const glm::vec2& p) {
    return sign * ((to.x - from.x) * (p.y - from.y) - (to.y - from.y) * (p.x - from.x)) >= 0;
  };
  for (int y = pixel(low.y); y <= pixel(high.y); ++y)
    for (int x = pixel(low.x); x <= pixel(high.x); ++x) {
      const glm::vec2 p(static_cast<float>(x) + 0.5F, static_cast<float>(y) + 0.5F);
      if (!inside(a, b, p) || !inside(b, c, p) || !inside(c, a, p)) continue;
      const auto bit = static_cast<size_t>(y * kSide + x);
      mask[bit / 64] |= uint64_t{1} << bit % 64;
    }
}

uint64_t count_without(const PieceMask& mask, const PieceMask& without) {
  uint64_t count = 0;
  for (size_t i = 0; i < mask.size(); ++i) count += static_cast<uint64_t>(std::popcount(mask[i] & ~without[i]));
  return count;
}

void add_mask(PieceMask& to, const PieceMask& from) {
  for (size_t i = 0; i < to.size(); ++i) to[i] |= from[i];
}

glm::dvec3 moved(const scene::Mat3x4& m, const glm::dvec3& p) {
  const glm::dvec4 q(p, 1.0);
  return {glm::dot(glm::dvec4(m.rows[0]), q), glm::dot(glm::dvec4(m.rows[1]), q), glm::dot(glm::dvec4(m.rows[2]), q)};
}

scene::Mat3x4 product(const scene::Mat3x4& a, const scene::Mat3x4& b) {
  scene::Mat3x4 out;
  for (int row = 0; row < 3; ++row)
    out.rows[row] = a.rows[row].x * b.rows[0] + a.rows[row].y * b.rows[1] + a.rows[row].z * b.rows[2] +
                    glm::vec4(0.0F, 0.0F, 0.0F, a.rows[row].w);
  return out;
}

// One piece with one border, in the rest pose.
struct Candidate {
  std::vector<glm::vec3> positions;
  std::vector<uint32_t> indices;
};

class BorderChooser {
 public:
  BorderChooser(const scene::Character& character, const scene::PoseBank& bank, const RestPose& rest,
                const JointPieces& pieces, const ViewGrid& grid)
      : mesh_(character.mesh),
        bank_(bank),
        rest_(rest),
        pieces_(pieces),
        grid_(grid),
        count_(static_cast<size_t>(pieces.count())),
        owners_(triangle_owners(character.mesh, pieces)),
        views_(mask_views()) {
    glm::vec3 low(INFINITY);
    glm::vec3 high(-INFINITY);
    for (const glm::vec3& p : rest.positions) {
      low = glm::min(low, p);
      high = glm::max(high, p);
    }
    const glm::vec3 extent = high - low;
    pixel_ = std::max(1e-6, static_cast<double>(std::max({extent.x, extent.y, extent.z})) / kFigure);
    middle_ = 0.5 * (glm::dvec3(bank.bounds_min()) + glm::dvec3(bank.bounds_max()));
    for (size_t p = 0; p < count_; ++p) {
      for (const float border : kBorders) {
        const PieceSurface surface = cut_joint_piece(mesh_, pieces, static_cast<int>(p), border);
        candidates_.push_back({corner_positions(surface, rest.positions), surface.indices});
      }
      const Candidate& whole = candidates_[p * kBorders.size()];
      moments_.push_back(surface_moments(whole.positions, whole.indices));
    }
    find_neighbours();
    find_poses();
  }

  // Of sample s: pose s / 4 from side s % 4.
  size_t samples() const { return poses_.size() * views_.size(); }

  void prepare() {
    shown_.assign(samples() * count_ * kBorders.size(), PieceMask{});
    own_.assign(samples() * count_, PieceMask{});
    near_.assign(samples() * count_, PieceMask{});
  }

  void draw_sample(size_t s) {
    const std::vector<scene::Mat3x4> palette = bank_.palette(poses_[s / views_.size()]);
    const MaskView& view = views_[s % views_.size()];
    draw_surface(s, view, scene::skin_points(mesh_, palette));
    for (size_t p = 0; p < count_; ++p) draw_candidates(s, view, palette, p);
  }

  BorderChoice choose() {
    constexpr size_t kFirst = 2;  // of kBorders
    std::vector<size_t> chosen(count_, kFirst);
    for (int round = 0; round < kRounds; ++round) {
      bool changed = false;
      for (size_t p = 0; p < count_; ++p) changed = improve(chosen, p) || changed;
      if (!changed) break;
    }
    BorderChoice out;
    for (const size_t c : chosen) out.borders.push_back(kBorders[c]);
    std::tie(out.holes, out.strays) = error(chosen);
    std::tie(out.holes_cut, out.strays_cut) = error(std::vector<size_t>(count_, 0));
    return out;
  }

 private:
  void find_neighbours() {
    std::vector<std::set<size_t>> near(count_);
    for (size_t i = 0; i + 2 < mesh_.indices.size(); i += 3) {
      std::set<size_t> met;
      for (size_t corner = 0; corner < 3; ++corner)
        for (int k = 0; k < scene::kInfluences; ++k) {
          const uint32_t v = mesh_.indices[i + corner];
          const int piece = pieces_.piece_of[mesh_.joints[v][k]];
          if (mesh_.weights[v][k] > 0 && piece >= 0) met.insert(static_cast<size_t>(piece));
        }
      for (const size_t p : met) near[p].insert(met.begin(), met.end());
    }
    for (size_t p = 0; p < count_; ++p) {
      near[p].insert(p);
      neighbours_.emplace_back(near[p].begin(), near[p].end());
    }
  }

  void find_poses() {
    const size_t clips = bank_.clips().size();
    const size_t each = std::max<size_t>(1, kPoses / std::max<size_t>(clips, 1));
    const size_t step = std::max<size_t>(1, (clips + kMostPoses - 1) / kMostPoses);
    for (size_t c = 0; c < clips; c += step)
      for (size_t k = 0; k < (bank_.clips()[c].samples > 1 ? each : 1); ++k)
        poses_.push_back(bank_.sample(static_cast<int>(c), static_cast<double>(k) / static_cast<double>(each)));
  }

  glm::vec2 on_mask(const MaskView& view, const glm::dvec3& p) const {
    const glm::dvec3 d = (p - middle_) / pixel_;
    return glm::vec2(glm::dvec2(glm::dot(d, view.right), glm::dot(d, view.up)) + 0.5 * kSide);
  }

  void draw_surface(size_t s, const MaskView& view, const std::vector<glm::vec3>& posed) {
    std::vector<glm::vec2> places;
    for (const glm::vec3& p : posed) places.push_back(on_mask(view, glm::dvec3(p)));
    for (size_t t = 0; t < owners_.size(); ++t)
      if (owners_[t] >= 0)
        fill(own_[s * count_ + static_cast<size_t>(owners_[t])], places[mesh_.indices[3 * t]],
             places[mesh_.indices[3 * t + 1]], places[mesh_.indices[3 * t + 2]]);
    for (size_t p = 0; p < count_; ++p)
      for (const size_t n : neighbours_[p]) add_mask(near_[s * count_ + p], own_[s * count_ + n]);
  }

  // Every border of a piece, on the plane of the view that is nearest.
  void draw_candidates(size_t s, const MaskView& view, const std::vector<scene::Mat3x4>& palette, size_t p) {
    const auto joint = static_cast<size_t>(pieces_.joint[p]);
    const scene::Mat3x4 from_rest = product(palette[joint], rest_.inverse[joint]);
    scene::Mat3x4 to_rest;
    if (!invert_affine(from_rest, to_rest)) return;  // this pose hides it
    const glm::dvec3 direction = moved(to_rest, view.to_eye) - moved(to_rest, glm::dvec3(0.0));
    const ViewBasis basis = grid_.basis(grid_.pick(direction).view);
    const glm::dvec3& centre = moments_[p].mean;
    const TilePlane plane = fit_plane(moments_[p], centre, basis);
    for (size_t b = 0; b < kBorders.size(); ++b) {
      const Candidate& candidate = candidates_[p * kBorders.size() + b];
      std::vector<glm::vec2> places;
      for (const glm::vec3& q : candidate.positions) {
        const glm::dvec3 d = glm::dvec3(q) - centre;
        const double x = glm::dot(d, basis.right);
        const double y = glm::dot(d, basis.up);
        const glm::dvec3 laid = centre + basis.right * x + basis.up * y +
                                basis.to_eye * (plane.slope_x * x + plane.slope_y * y + plane.height);
        places.push_back(on_mask(view, moved(from_rest, laid)));
      }
      PieceMask& mask = shown_[(s * count_ + p) * kBorders.size() + b];
      for (size_t i = 0; i + 2 < candidate.indices.size(); i += 3)
        fill(mask, places[candidate.indices[i]], places[candidate.indices[i + 1]], places[candidate.indices[i + 2]]);
    }
  }

  const PieceMask& shown(size_t s, size_t p, size_t border) const {
    return shown_[(s * count_ + p) * kBorders.size() + border];
  }

  uint64_t holes(const std::vector<size_t>& chosen, size_t p) const {
    uint64_t sum = 0;
    for (size_t s = 0; s < samples(); ++s) {
      PieceMask all = shown(s, p, chosen[p]);
      for (const size_t n : neighbours_[p]) add_mask(all, shown(s, n, chosen[n]));
      sum += count_without(own_[s * count_ + p], all);
    }
    return sum;
  }

  uint64_t strays(size_t border, size_t p) const {
    uint64_t sum = 0;
    for (size_t s = 0; s < samples(); ++s) sum += count_without(shown(s, p, border), near_[s * count_ + p]);
    return sum;
  }

  bool improve(std::vector<size_t>& chosen, size_t p) const {
    const size_t before = chosen[p];
    size_t best = before;
    uint64_t least = UINT64_MAX;
    // What is chosen already first, so that of equal ones nothing changes.
    for (size_t k = 0; k <= kBorders.size(); ++k) {
      chosen[p] = k == 0 ? before : k - 1;
      uint64_t error = strays(chosen[p], p);
      for (const size_t n : neighbours_[p]) error += kHoleWeight * holes(chosen, n);
      if (error >= least) continue;
      least = error;
      best = chosen[p];
    }
    chosen[p] = best;
    return best != before;
  }

  std::pair<double, double> error(const std::vector<size_t>& chosen) const {
    uint64_t lacking = 0;
    uint64_t astray = 0;
    uint64_t all = 0;
    for (size_t p = 0; p < count_; ++p) {
      lacking += holes(chosen, p);
      astray += strays(chosen[p], p);
    }
    for (const PieceMask& mask : own_) all += count_without(mask, PieceMask{});
    const double whole = std::max(1.0, static_cast<double>(all));
    return {1000 * static_cast<double>(lacking) / whole, 1000 * static_cast<double>(astray) / whole};
  }

  const scene::Mesh& mesh_;
  const scene::PoseBank& bank_;
  const RestPose& rest_;
  const JointPieces& pieces_;
  const ViewGrid& grid_;
  size_t count_;
  std::vector<int> owners_;
  std::array<MaskView, 4> views_;
  double pixel_ = 1;  // metres
  glm::dvec3 middle_{0.0};
  std::vector<Candidate> candidates_;  // piece-major
  std::vector<SurfaceMoments> moments_;
  std::vector<std::vector<size_t>> neighbours_;  // by piece, itself among them
  std::vector<scene::PoseSample> poses_;
  std::vector<PieceMask> shown_;       // sample, piece, border
  std::vector<PieceMask> own_, near_;  // sample, piece: its own surface; with its neighbours'
};

}  // namespace

BorderChoice choose_borders(const scene::Character& character, const scene::PoseBank& bank, const RestPose& rest,
                            const JointPieces& pieces, const ViewGrid& grid, unsigned threads) {
  BorderChooser chooser(character, bank, rest, pieces, grid);
  chooser.prepare();
  parallel_for(chooser.samples(), threads, [&](size_t s) { chooser.draw_sample(s); });
  return chooser.choose();
}

}  // namespace crowdbench::renderers
