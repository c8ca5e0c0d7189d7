// Based on: linear blend skinning, x(p) = sum_j w_j(p) M_j p, to first order: over a patch of skin whose weights and
// points change little, each term w_j(p) p is an affine function of where the patch lies when captured, found by least
// squares. The sum of these is one matrix a patch and pose, exact for a triangle (three corners) whatever its weights.
// Differs from Beacco et al. 2011, whose boxes follow single joints and whose future work this is.
#include "renderers/relief/relief_cells.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <map>
#include <utility>

#include "core/parallel.h"
#include "scene/pose/pose.h"

namespace crowdbench::renderers {
namespace {

using scene::Character;

constexpr size_t kPoses = 16;
constexpr size_t kSampled = 192;  // triangles by which cuts of a cell are compared
// Of a patch's spread in all, what counts as no spread: across a flat patch something else says where things go
// (kByMean, or one joint's matrix). The first with which no pose squashes the cell.
constexpr std::array<double, 5> kFlat{1e-4, 1e-3, 1e-2, 1e-1, 1};
constexpr double kSquashed = 0.05;  // its volume, of the cube of its largest stretch; of a plane one, across its plane
constexpr double kPlane = 0.02;     // of a plane patch's extent, what lies off the plane
constexpr size_t kByMean = SIZE_MAX;

struct Influence {
  int joint = 0;  // that carries it
  double weight = 0;
  glm::dvec3 place{0.0};  // where its own joint puts the vertex at the capture pose
};

// Vertices at one place have one number: seams of the texture do not part the skin.
std::vector<uint32_t> welded(const scene::Mesh& mesh) {
  std::map<std::array<float, 3>, uint32_t> places;
  std::vector<uint32_t> number;
  for (const glm::vec3& p : mesh.positions)
    number.push_back(places.emplace(std::array{p.x, p.y, p.z}, static_cast<uint32_t>(places.size())).first->second);
  return number;
}

// The shares that move some triangles, and what they miss by.
struct Fit {
  std::vector<Share> shares;
  double worst = 0;  // metres: of any corner in any pose
  double cost = 0;   // metres^6: mean over poses of the fourth power, over the area: what is far off counts most
};

struct Cell {
  std::vector<uint32_t> triangles;
  Fit fit;
};

class Skin {
 public:
  Skin(const Character& character, const scene::PoseBank& bank, const CapturePose& capture, const Carriers& carriers)
      : character_(character),
        mesh_(character.mesh),
        palette_(capture_palette(character, capture)),
        places_(welded(character.mesh)),
        poses_(spread_poses(bank, kPoses)) {
    captured_ = scene::skin_positions(mesh_, palette_);
    for (const auto& pose : poses_) posed_.push_back(scene::skin_positions(mesh_, pose));
    for (const glm::dmat4& m : palette_) back_.push_back(inverse_or_zero(m));
    for (size_t v = 0; v < mesh_.positions.size(); ++v) {
      std::array<Influence, scene::kInfluences>& of = influences_.emplace_back();
      double total = 0;
      for (int k = 0; k < scene::kInfluences; ++k) total += std::max(0.0, static_cast<double>(mesh_.weights[v][k]));
      for (int k = 0; k < scene::kInfluences; ++k) {
        const auto joint = static_cast<size_t>(mesh_.joints[v][k]);
        const double weight = static_cast<double>(mesh_.weights[v][k]);
        if (!(weight > 0)) continue;
        of[static_cast<size_t>(k)] = {carriers[joint], weight / total,
                                      glm::dvec3(palette_[joint] * glm::dvec4(mesh_.positions[v], 1.0))};
      }
    }
  }

  // By at most `most` of the triangles, evenly spread over the list.
  Fit fit(const std::vector<uint32_t>& all, size_t most, size_t shares = kShares) const {
    std::vector<uint32_t> triangles;
    const size_t count = std::min(all.size(), most);
    for (size_t i = 0; i < count; ++i) triangles.push_back(all[i * all.size() / count]);
    Fit out{heaviest(triangles, shares), 0, 0};
    measure(triangles, out);  // by the mean matrix alone
    if (out.shares.size() == 1) return out;
    const std::vector<double> weights = weights_of(triangles);
    for (const double flat : kFlat) {
      // Where the mean of turned matrices would lay a plane patch's normal into the plane, one of them does not.
      for (size_t across = kByMean; across + 1 <= out.shares.size(); ++across) {
        Fit next = out;
        add_changes(triangles, weights, {flat, across}, next.shares);
        measure(triangles, next);
        if (!std::isfinite(next.cost)) continue;
        if (triangles.size() == all.size() && triangles.size() > 1) sharpen(triangles, {flat, across}, next);
        return next;
      }
    }
    return out;
  }
  // As good, with no more shares than that takes.
  Fit frugal_fit(const std::vector<uint32_t>& triangles, double tolerance) const {
    const Fit best = fit(triangles, triangles.size());
    for (size_t shares = 1; shares < best.shares.size(); ++shares) {
      Fit one = fit(triangles, triangles.size(), shares);
      if (one.worst <= std::max(0.5 * tolerance, best.worst)) return one;
    }
    return best;
  }
  // Square metres, of each triangle, that a fit misses by in the worst pose.
  std::vector<double> misses(const std::vector<uint32_t>& triangles, const Fit& fit) const {
    const glm::dmat4 back = mean_back(fit.shares);
    std::vector<double> out(triangles.size(), 0.0);
    for (size_t pose = 0; pose < poses_.size(); ++pose) {
      const glm::dmat4 moved = matrix(fit.shares, back, pose);
      for (size_t i = 0; i < triangles.size(); ++i)
        for (uint32_t c = 0; c < 3; ++c) {
          const uint32_t v = mesh_.indices[3 * triangles[i] + c];
          const glm::dvec3 miss = glm::dvec3(moved * glm::dvec4(captured_[v], 1.0)) - posed_[pose][v];
          out[i] = std::max(out[i], glm::dot(miss, miss));
        }
    }
    return out;
  }
  // Of the joint that moves most of a triangle: -1 where none does.
  int dominant(uint32_t t) const {
    std::map<int, double> sums;
    for (uint32_t corner = 0; corner < 3; ++corner)
      for (const Influence& i : influences_[mesh_.indices[3 * t + corner]]) sums[i.joint] += i.weight;
    const auto most =
        std::max_element(sums.begin(), sums.end(), [](const auto& a, const auto& b) { return a.second < b.second; });
    return most->second > 0 ? most->first : -1;
  }
  double weight(uint32_t t, int joint) const {
    double sum = 0;
    for (uint32_t corner = 0; corner < 3; ++corner)
      for (const Influence& i : influences_[mesh_.indices[3 * t + corner]]) sum += i.joint == joint ? i.weight : 0.0;
    return sum;
  }
  uint32_t place(uint32_t t, uint32_t corner) const { return places_[mesh_.indices[3 * t + corner]]; }
  const glm::dvec3& corner(uint32_t t, uint32_t corner) const { return captured_[mesh_.indices[3 * t + corner]]; }
  double area(uint32_t t) const {
    return 0.5 * glm::length(glm::cross(corner(t, 1) - corner(t, 0), corner(t, 2) - corner(t, 0)));
  }
  glm::dmat3 joint_from_capture(int joint) const {
    return glm::dmat3(character_.skeleton.joints[static_cast<size_t>(joint)].inverse_bind *
                      back_[static_cast<size_t>(joint)]);
  }

 private:
  // The joints with the largest weights, one share each; what the others carry goes to the first.
  std::vector<Share> heaviest(const std::vector<uint32_t>& triangles, size_t most) const {
    std::map<int, double> sums;
    double total = 0;
    for (const uint32_t t : triangles)
      for (uint32_t corner = 0; corner < 3; ++corner)
        for (const Influence& i : influences_[mesh_.indices[3 * t + corner]]) {
          const double part = i.weight * (area(t) + 1e-12);
          if (part > 0) sums[i.joint] += part;
          total += part;
        }
    std::vector<Share> shares;
    for (const auto& [joint, sum] : sums) shares.push_back({joint, sum / total, glm::dmat4(0.0)});
    std::stable_sort(shares.begin(), shares.end(), [](const Share& a, const Share& b) { return a.weight > b.weight; });
    shares.resize(std::min(shares.size(), most));
    double kept = 0;
    for (size_t k = 1; k < shares.size(); ++k) kept += shares[k].weight;
    shares[0].weight = 1.0 - kept;
    return shares;
  }

  glm::dmat4 matrix(const std::vector<Share>& shares, const glm::dmat4& back, size_t pose) const {
    glm::dmat4 moved(0.0);
    for (const Share& s : shares) moved += poses_[pose][static_cast<size_t>(s.joint)] * (s.weight * back + s.change);
    return moved;
  }
  glm::dmat4 mean_back(const std::vector<Share>& shares) const {
    glm::dmat4 mean(0.0);
    for (const Share& s : shares) mean += s.weight * palette_[static_cast<size_t>(s.joint)];
    return inverse_or_zero(mean);
  }

  // What a share's joint's matrix is multiplied by across a patch.
  glm::dmat4 part_across(const std::vector<Share>& shares, size_t k, size_t across, const glm::dmat4& back) const {
    if (across == kByMean) return shares[k].weight * back;
    return k == across ? back_[static_cast<size_t>(shares[k].joint)] : glm::dmat4(0.0);
  }
  // What says where things go across a patch.
  struct Across {
    double flat;   // of kFlat
    size_t share;  // whose joint's matrix; kByMean: the mean's
  };
  // Least squares over the corners, of what each joint's part of the skin differs from what holds across.
  void add_changes(const std::vector<uint32_t>& triangles, const std::vector<double>& weights, const Across& across,
                   std::vector<Share>& shares) const {
    const glm::dmat4 back = mean_back(shares);
    glm::dvec3 middle(0.0);
    double total = 0;
    for (size_t i = 0; i < triangles.size(); ++i) {
      for (uint32_t k = 0; k < 3; ++k) middle += weights[i] * corner(triangles[i], k);
      total += 3 * weights[i];
    }
    middle /= total;
    glm::dmat3 spread(0.0);
    std::array<glm::dvec4, kShares> mean{};
    std::array<std::array<glm::dvec4, 3>, kShares> slope{};
    for (size_t i = 0; i < triangles.size(); ++i)
      for (uint32_t c = 0; c < 3; ++c) {
        const uint32_t v = mesh_.indices[3 * triangles[i] + c];
        const double a = weights[i];
        const glm::dvec3 from = captured_[v] - middle;
        spread += a * glm::outerProduct(from, from);
        std::array<glm::dvec4, kShares> rest{};
        for (size_t k = 0; k < shares.size(); ++k)
          rest[k] = -(palette_[static_cast<size_t>(shares[k].joint)] *
                      (part_across(shares, k, across.share, back) * glm::dvec4(captured_[v], 1.0)));
        for (const Influence& of : influences_[v]) {
          size_t k = 0;
          while (k < shares.size() && shares[k].joint != of.joint) ++k;
          rest[k < shares.size() ? k : 0] += of.weight * glm::dvec4(of.place, 1.0);
        }
        for (size_t k = 0; k < shares.size(); ++k) {
          mean[k] += a * rest[k];
          for (int axis = 0; axis < 3; ++axis) slope[k][static_cast<size_t>(axis)] += a * from[axis] * rest[k];
        }
      }
    const double flat = across.flat * (spread[0][0] + spread[1][1] + spread[2][2]) + 1e-30;
    const glm::dmat3 inverse = glm::inverse(spread + glm::dmat3(flat));
    for (size_t k = 0; k < shares.size(); ++k) {
      glm::dmat4 change(0.0);
      for (int column = 0; column < 3; ++column) {
        for (int axis = 0; axis < 3; ++axis)
          change[column] += slope[k][static_cast<size_t>(axis)] * inverse[column][axis];
        change[3] -= change[column] * middle[column];
      }
      change[3] += mean[k] / total;
      shares[k].change = back_[static_cast<size_t>(shares[k].joint)] * change +
                         (part_across(shares, k, across.share, back) - shares[k].weight * back);
    }
  }

  std::vector<double> weights_of(const std::vector<uint32_t>& triangles) const {
    std::vector<double> weights;
    for (const uint32_t t : triangles) weights.push_back(area(t) + 1e-12);
    return weights;
  }

  // Lawson's reweighting: what is missed by more counts for more, a few times over; the least worst of these fits.
  void sharpen(const std::vector<uint32_t>& triangles, const Across& across, Fit& fit) const {
    std::vector<double> weights = weights_of(triangles);
    Fit next = fit;
    for (int round = 0; round < 6; ++round) {
      const std::vector<double> missed = misses(triangles, next);
      double most = 1e-30;
      for (const double square : missed) most = std::max(most, square);
      for (size_t i = 0; i < weights.size(); ++i) weights[i] *= std::sqrt(missed[i] / most) + 0.05;
      add_changes(triangles, weights, across, next.shares);
      measure(triangles, next);
      if (next.worst < fit.worst && std::isfinite(next.cost)) fit = next;
    }
  }

  // Two directions along the plane that the triangles lie in, and the one across; zero where they lie in none.
  glm::dmat3 plane_of(const std::vector<uint32_t>& triangles) const {
    glm::dvec3 across(0.0);
    for (const uint32_t t : triangles) across += glm::cross(corner(t, 1) - corner(t, 0), corner(t, 2) - corner(t, 0));
    const glm::dvec3 along = corner(triangles[0], 1) - corner(triangles[0], 0);
    if (!(glm::length(across) > 0 && glm::length(along) > 0)) return glm::dmat3(0.0);
    across = glm::normalize(across);
    double off = 0;
    double extent = 0;
    for (const uint32_t t : triangles)
      for (uint32_t c = 0; c < 3; ++c) {
        const glm::dvec3 from = corner(t, c) - corner(triangles[0], 0);
        off = std::max(off, std::abs(glm::dot(across, from)));
        extent = std::max(extent, glm::length(from));
      }
    if (off > kPlane * extent) return glm::dmat3(0.0);
    const glm::dvec3 first = glm::normalize(along - across * glm::dot(along, across));
    return {first, glm::cross(across, first), across};
  }

  void measure(const std::vector<uint32_t>& triangles, Fit& fit) const {
    const glm::dmat4 back = mean_back(fit.shares);
    const glm::dmat3 plane = plane_of(triangles);
    fit.worst = fit.cost = 0;
    double worst = 0;
    for (size_t pose = 0; pose < poses_.size(); ++pose) {
      const glm::dmat4 moved = matrix(fit.shares, back, pose);
      const glm::dmat3 linear(moved);
      const double stretch = std::max({glm::length(linear[0]), glm::length(linear[1]), glm::length(linear[2])});
      // A plane patch may be stretched along its plane, as long as what is beside it stays beside it.
      const glm::dmat3 turned = linear * plane;
      const double volume = std::abs(glm::determinant(linear));
      const double least = plane[2] == glm::dvec3(0.0)
                               ? stretch * stretch * stretch
                               : glm::length(glm::cross(turned[0], turned[1])) * glm::length(turned[2]);
      if (!(volume > kSquashed * least)) fit.cost = std::numeric_limits<double>::infinity();
      for (const uint32_t t : triangles) {
        const double a = area(t) / 3.0 / static_cast<double>(poses_.size());
        for (uint32_t c = 0; c < 3; ++c) {
          const uint32_t v = mesh_.indices[3 * t + c];
          const glm::dvec3 miss = glm::dvec3(moved * glm::dvec4(captured_[v], 1.0)) - posed_[pose][v];
          const double square = glm::dot(miss, miss);
          worst = std::max(worst, square);
          fit.cost += a * square * square;
        }
      }
    }
    fit.worst = std::sqrt(worst);
  }

  const Character& character_;
  const scene::Mesh& mesh_;
  std::vector<glm::dmat4> palette_;
  std::vector<uint32_t> places_;
  std::vector<glm::dmat4> back_;
  std::vector<std::vector<glm::dmat4>> poses_;
  std::vector<glm::dvec3> captured_;
  std::vector<std::vector<glm::dvec3>> posed_;
  std::vector<std::array<Influence, scene::kInfluences>> influences_;
};

// Lists of triangles that hang together by their corners, in the order of their first ones.
std::vector<std::vector<uint32_t>> components(const Skin& skin, const std::vector<uint32_t>& triangles) {
  std::map<uint32_t, size_t> of_place;  // to an entry of `root`
  std::vector<size_t> root;
  const auto find = [&](size_t i) {
    while (root[i] != i) i = root[i] = root[root[i]];
    return i;
  };
  const auto entry = [&](uint32_t t, uint32_t corner) {
    const auto [found, added] = of_place.emplace(skin.place(t, corner), root.size());
    if (added) root.push_back(root.size());
    return found->second;
  };
  for (const uint32_t t : triangles)
    for (uint32_t corner = 0; corner < 3; ++corner) {
      const size_t a = find(entry(t, 0));
      const size_t b = find(entry(t, corner));
      root[std::max(a, b)] = std::min(a, b);
    }
  std::map<size_t, std::vector<uint32_t>> found;
  for (const uint32_t t : triangles) found[find(entry(t, 0))].push_back(t);
  std::vector<std::vector<uint32_t>> out;
  for (auto& [first, list] : found) out.push_back(std::move(list));
  return out;
}

// What a cell may be cut across: three directions in space, and the weights of its joints.
std::vector<std::vector<double>> coordinates_to_cut(const Skin& skin, const Cell& cell) {
  std::vector<std::vector<double>> coordinates(3);
  const glm::dmat3 frame = skin.joint_from_capture(cell.fit.shares[0].joint);
  for (const uint32_t t : cell.triangles) {
    const glm::dvec3 p = frame * (skin.corner(t, 0) + skin.corner(t, 1) + skin.corner(t, 2));
    for (int axis = 0; axis < 3; ++axis) coordinates[static_cast<size_t>(axis)].push_back(p[axis]);
  }
  for (const Share& s : cell.fit.shares) {
    std::vector<double>& coordinate = coordinates.emplace_back();
    for (const uint32_t t : cell.triangles) coordinate.push_back(skin.weight(t, s.joint));
  }
  return coordinates;
}

// Gives each triangle to the half that carries it better, a few times over.
void settle(const Skin& skin, const Cell& cell, std::array<std::vector<uint32_t>, 2>& halves) {
  for (int round = 0; round < 4; ++round) {
    std::array<std::vector<double>, 2> misses;
    for (size_t half = 0; half < 2; ++half)
      misses[half] = skin.misses(cell.triangles, skin.fit(halves[half], halves[half].size()));
    std::array<std::vector<uint32_t>, 2> next;
    for (size_t i = 0; i < cell.triangles.size(); ++i)
      next[misses[0][i] <= misses[1][i] ? 0 : 1].push_back(cell.triangles[i]);
    if (next[0].empty() || next[1].empty() || next == halves) return;
    halves = std::move(next);
  }
}

std::array<std::vector<uint32_t>, 2> around_worst(const Skin& skin, const Cell& cell) {
  const std::vector<double> misses = skin.misses(cell.triangles, cell.fit);
  const auto worst = static_cast<size_t>(std::max_element(misses.begin(), misses.end()) - misses.begin());
  const auto middle = [&](uint32_t t) { return skin.corner(t, 0) + skin.corner(t, 1) + skin.corner(t, 2); };
  std::vector<std::pair<double, uint32_t>> order;
  for (const uint32_t t : cell.triangles)
    order.emplace_back(glm::distance(middle(t), middle(cell.triangles[worst])), t);
  std::sort(order.begin(), order.end());
  std::array<std::vector<uint32_t>, 2> halves;
  for (size_t i = 0; i < order.size(); ++i)
    halves[i < std::min<size_t>(4, order.size() / 2) ? 0 : 1].push_back(order[i].second);
  return halves;
}

double cost_of(const Skin& skin, const std::array<std::vector<uint32_t>, 2>& halves) {
  return skin.fit(halves[0], halves[0].size()).cost + skin.fit(halves[1], halves[1].size()).cost;
}

// Scraps of one half, what hangs not together with most of it, go to the other.
void gather(const Skin& skin, std::array<std::vector<uint32_t>, 2>& halves) {
  std::array<std::vector<uint32_t>, 2> out;
  for (size_t half = 0; half < 2; ++half) {
    std::vector<std::vector<uint32_t>> parts = components(skin, halves[half]);
    size_t most = 0;
    for (const auto& part : parts) most = std::max(most, part.size());
    for (const auto& part : parts) {
      std::vector<uint32_t>& to = out[4 * part.size() < most ? 1 - half : half];
      to.insert(to.end(), part.begin(), part.end());
    }
  }
  for (std::vector<uint32_t>& half : out) std::sort(half.begin(), half.end());
  halves = std::move(out);
}

// The cells, two and more, that miss least together; none where nothing can be cut.
std::vector<Cell> cut(const Skin& skin, const Cell& cell) {
  std::array<std::vector<uint32_t>, 2> best;
  double least = std::numeric_limits<double>::infinity();
  for (const std::vector<double>& coordinate : coordinates_to_cut(skin, cell)) {
    const auto [low, high] = std::minmax_element(coordinate.begin(), coordinate.end());
    for (const double share : {0.2, 0.35, 0.5, 0.65, 0.8}) {
      const double at = *low + share * (*high - *low);
      std::array<std::vector<uint32_t>, 2> halves;
      for (size_t i = 0; i < coordinate.size(); ++i) halves[coordinate[i] < at ? 0 : 1].push_back(cell.triangles[i]);
      if (halves[0].empty() || halves[1].empty()) continue;
      const double cost = skin.fit(halves[0], kSampled).cost + skin.fit(halves[1], kSampled).cost;
      if (cost < least) {
        least = cost;
        best = halves;
      }
    }
  }
  // Or what lies around the triangle that is missed by most, and the rest.
  std::array<std::vector<uint32_t>, 2> halves = around_worst(skin, cell);
  settle(skin, cell, halves);
  if (!best[0].empty()) settle(skin, cell, best);
  if (best[0].empty() || (!halves[0].empty() && !halves[1].empty() && cost_of(skin, halves) < cost_of(skin, best)))
    best = std::move(halves);
  if (best[0].empty() || best[1].empty()) return {};
  gather(skin, best);
  std::vector<Cell> out;
  for (const std::vector<uint32_t>& half : best)
    for (std::vector<uint32_t>& part : components(skin, half)) {
      const Fit fit = skin.fit(part, part.size());
      out.push_back({std::move(part), fit});
    }
  return out;
}

// How far the corners that are not shared lie from what is, in metres.
double height_above(const Skin& skin, uint32_t t, const std::array<bool, 3>& shared) {
  const double twice = 2 * skin.area(t);
  for (uint32_t k = 0; k < 3; ++k) {
    const uint32_t a = (k + 1) % 3;
    const uint32_t b = (k + 2) % 3;
    if (shared[a] == shared[b] && shared[k] != shared[a])
      return twice / std::max(glm::distance(skin.corner(t, a), skin.corner(t, b)), 1e-12);
  }
  return 0;
}

std::vector<Skirt> skirts_of(const scene::Mesh& mesh, const Skin& skin, const std::vector<uint32_t>& all,
                             const std::vector<uint32_t>& own, double width) {
  std::vector<char> touched(mesh.positions.size(), 0);
  std::vector<char> owned(mesh.indices.size() / 3, 0);
  for (const uint32_t t : own) {
    owned[t] = 1;
    for (uint32_t k = 0; k < 3; ++k) touched[skin.place(t, k)] = 1;
  }
  std::vector<Skirt> out;
  for (const uint32_t t : all) {
    Skirt skirt{t, {}, 0};
    for (uint32_t k = 0; k < 3; ++k) skirt.shared[k] = touched[skin.place(t, k)] != 0;
    if (owned[t] != 0 || !(skirt.shared[0] || skirt.shared[1] || skirt.shared[2])) continue;
    const double height = height_above(skin, t, skirt.shared);
    skirt.reach = height > width ? width / height : 1.0;
    out.push_back(skirt);
  }
  return out;
}

// What the cells are in the end; they are taken. all: every triangle that a joint moves. advance: of options.most to
// come.
Cells pieces_of(const Character& character, const Skin& skin, const std::vector<uint32_t>& all,
                std::vector<Cell>& cells, const std::vector<char>& is_cut, const CellOptions& options,
                const std::function<void(size_t)>& advance) {
  Cells out;
  double whole = 0;
  for (size_t i = 0; i < cells.size(); ++i) {
    advance(options.most * i / cells.size());
    double area = 0;
    for (const uint32_t t : cells[i].triangles) area += skin.area(t);
    whole += area;
    if (cells[i].fit.worst > options.tolerance) out.loose += area;
    Piece& piece = out.pieces.emplace_back();
    piece.shares = skin.frugal_fit(cells[i].triangles, options.tolerance).shares;
    piece.skirts = skirts_of(character.mesh, skin, all, cells[i].triangles, options.skirt);
    piece.triangles = std::move(cells[i].triangles);
    piece.texel = is_cut[i] != 0 ? options.texel : 0.0;
    out.deviation = std::max(out.deviation, cells[i].fit.worst);
  }
  out.loose /= std::max(whole, 1e-30);
  return out;
}

}  // namespace

Cells skin_cells(const Character& character, const scene::PoseBank& bank, const CapturePose& capture,
                 const Carriers& carriers, const CellOptions& options, const BakeProgress& progress) {
  const auto advance = [&](size_t done) {
    if (progress) progress(std::min(done, 2 * options.most), 2 * options.most);
  };
  const Skin skin(character, bank, capture, carriers);
  std::map<int, Cell> by_joint;
  std::vector<uint32_t> all;
  for (uint32_t t = 0; t < character.triangles(); ++t) {
    const int joint = skin.dominant(t);
    if (joint < 0) continue;
    by_joint[joint].triangles.push_back(t);
    all.push_back(t);
  }
  std::vector<Cell> cells;
  std::vector<char> is_cut;
  for (auto& [joint, cell] : by_joint) {
    cell.fit = skin.fit(cell.triangles, cell.triangles.size());
    cells.push_back(std::move(cell));
    is_cut.push_back(0);
  }
  while (cells.size() < options.most) {
    std::vector<size_t> worst;
    for (size_t i = 0; i < cells.size(); ++i)
      if (cells[i].fit.worst > options.tolerance && cells[i].triangles.size() > 1) worst.push_back(i);
    std::stable_sort(worst.begin(), worst.end(),
                     [&](size_t a, size_t b) { return cells[a].fit.worst > cells[b].fit.worst; });
    worst.resize(std::min(worst.size(), options.most - cells.size()));
    std::vector<std::vector<Cell>> parts(worst.size());
    const size_t before = cells.size();
    parallel_for(
        worst.size(), 0, [&](size_t i) { parts[i] = cut(skin, cells[worst[i]]); },
        [&](size_t done) { advance(std::min(before + done, options.most)); });
    for (size_t i = 0; i < worst.size(); ++i) {
      if (parts[i].size() < 2) continue;
      cells[worst[i]] = std::move(parts[i][0]);
      is_cut[worst[i]] = 1;
      for (size_t part = 1; part < parts[i].size(); ++part) {
        cells.push_back(std::move(parts[i][part]));
        is_cut.push_back(1);
      }
    }
    if (cells.size() == before) break;
  }
  return pieces_of(character, skin, all, cells, is_cut, options, [&](size_t done) { advance(options.most + done); });
}

}  // namespace crowdbench::renderers
