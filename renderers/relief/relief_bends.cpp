// Based on: linear blend skinning, taken box by box: skin of weights w follows the sum of w_j M_j, so a box that
// follows the same sum carries it without error, and other skin with an error that grows with the difference of the
// weights. Differs from Beacco et al. 2011, whose boxes follow single joints: bent skin is then off by what its second
// joint moves it.
#include "renderers/relief/relief_bends.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

#include "scene/pose/pose.h"

namespace crowdbench::renderers {
namespace {

using scene::Character;

constexpr int kShares = 8;                            // blends are multiples of an eighth
constexpr size_t kSampled = 4096;                     // triangles that blends are weighed by
constexpr float kTie = 1e-6F;                         // what differs by rounding is the same: the earlier piece wins
using Weights = std::vector<std::pair<int, double>>;  // joint, weight

// Of a triangle's three corners, by joint, ascending; their sum is 1. Empty without any.
Weights mean_weights(const scene::Mesh& mesh, uint32_t triangle) {
  std::map<int, double> sums;
  double total = 0;
  for (uint32_t corner = 0; corner < 3; ++corner) {
    const uint32_t v = mesh.indices[3 * triangle + corner];
    for (int k = 0; k < scene::kInfluences; ++k) {
      if (!(mesh.weights[v][k] > 0)) continue;
      sums[mesh.joints[v][k]] += static_cast<double>(mesh.weights[v][k]);
      total += static_cast<double>(mesh.weights[v][k]);
    }
  }
  Weights out;
  for (const auto& [joint, sum] : sums) out.emplace_back(joint, sum / total);
  return out;
}

// 0: the same weights; 1: nothing in common.
double distance(const Piece& piece, const Weights& weights) {
  double common = 0;
  for (const auto& [joint, weight] : weights) {
    if (joint == piece.joints[0]) common += std::min(weight, 1.0 - piece.second);
    if (joint == piece.joints[1]) common += std::min(weight, piece.second);
  }
  return 1.0 - common;
}
double distance(const Piece& a, const Piece& b) {
  return distance(a, Weights{{b.joints[0], 1.0 - b.second}, {b.joints[1], b.second}});
}

// The blends that triangles' two largest weights come nearest to, where these are a joint and its parent.
std::vector<Piece> blends(const std::vector<Weights>& weights, const std::vector<int>& parent) {
  std::map<std::array<int, 3>, Piece> found;
  for (const Weights& of : weights) {
    if (of.size() < 2) continue;
    Weights most = of;
    std::sort(most.begin(), most.end(), [](const auto& a, const auto& b) {
      return a.second > b.second || (a.second == b.second && a.first < b.first);
    });
    const auto [first, large] = most[0];
    const auto [second, small] = most[1];
    if (parent[static_cast<size_t>(first)] != second && parent[static_cast<size_t>(second)] != first) continue;
    const int shares = static_cast<int>(std::lround(kShares * small / (large + small)));
    if (shares == 0) continue;
    found.emplace(std::array{first, second, shares},
                  Piece{.joints = {first, second}, .second = static_cast<double>(shares) / kShares});
  }
  std::vector<Piece> out;
  for (const auto& [key, piece] : found) out.push_back(piece);
  return out;
}

// How far pieces deviate from the skin in some poses of a bank.
class Skin {
 public:
  Skin(const Character& character, const scene::PoseBank& bank, const CapturePose& capture)
      : mesh_(character.mesh), palette_(capture_palette(character, capture)), poses_(spread_poses(bank, 12)) {
    captured_ = scene::skin_positions(mesh_, palette_);
    for (const auto& pose : poses_) posed_.push_back(scene::skin_positions(mesh_, pose));
  }

  // Of each triangle: the mean of its corners' root-mean-square distances, in metres, to where the skin puts them;
  // infinite where the piece flattens space in some pose.
  std::vector<float> deviations(const Piece& piece, const std::vector<uint32_t>& triangles) const {
    const glm::dmat4 back = inverse_or_zero(matrix_of(piece, palette_));
    std::vector<glm::dmat4> moved;
    for (const auto& pose : poses_) {
      moved.push_back(matrix_of(piece, pose) * back);
      const glm::dmat3 linear(moved.back());
      const double stretch = std::max({glm::length(linear[0]), glm::length(linear[1]), glm::length(linear[2])});
      if (!(std::abs(glm::determinant(linear)) > 0.05 * stretch * stretch * stretch))
        return std::vector<float>(triangles.size(), std::numeric_limits<float>::infinity());
    }
    std::vector<float> at_vertex(mesh_.positions.size(), -1.0F);
    std::vector<float> out;
    for (const uint32_t t : triangles) {
      float sum = 0;
      for (uint32_t corner = 0; corner < 3; ++corner) {
        const uint32_t v = mesh_.indices[3 * t + corner];
        if (at_vertex[v] < 0) at_vertex[v] = static_cast<float>(deviation(moved, v));
        sum += at_vertex[v];
      }
      out.push_back(sum / 3.0F);
    }
    return out;
  }
  double area(uint32_t t) const {  // metres^2, at the capture pose
    const glm::dvec3& a = captured_[mesh_.indices[3 * t]];
    return 0.5 *
           glm::length(glm::cross(captured_[mesh_.indices[3 * t + 1]] - a, captured_[mesh_.indices[3 * t + 2]] - a));
  }

 private:
  double deviation(const std::vector<glm::dmat4>& moved, uint32_t v) const {
    double sum = 0;
    for (size_t t = 0; t < moved.size(); ++t) {
      const glm::dvec3 gap = glm::dvec3(moved[t] * glm::dvec4(captured_[v], 1.0)) - posed_[t][v];
      sum += glm::dot(gap, gap);
    }
    return std::sqrt(sum / static_cast<double>(std::max<size_t>(moved.size(), 1)));
  }

  const scene::Mesh& mesh_;
  std::vector<glm::dmat4> palette_;
  std::vector<std::vector<glm::dmat4>> poses_;
  std::vector<glm::dvec3> captured_;
  std::vector<std::vector<glm::dvec3>> posed_;
};

// A piece over a list of triangles.
struct Fit {
  std::vector<float> deviation;  // metres
  // What decides between pieces: deviation, and for skin that hardly deviates with any (beside a hinge) its weights, so
  // that pieces are bands around a limb, not patches.
  std::vector<float> cost;
};
Fit fit(const Piece& piece, const std::vector<uint32_t>& triangles, const Skin& skin,
        const std::vector<Weights>& weights, double deviation) {
  Fit out{skin.deviations(piece, triangles), {}};
  for (size_t i = 0; i < triangles.size(); ++i)
    out.cost.push_back(out.deviation[i] + static_cast<float>(deviation * distance(piece, weights[triangles[i]])));
  return out;
}

// The joints' own pieces, and the blends that are worth a box.
std::vector<Piece> choose(const std::vector<Piece>& own, const std::vector<Piece>& blends,
                          const std::vector<uint32_t>& triangles, const Skin& skin, const std::vector<Weights>& weights,
                          const BendOptions& options) {
  std::vector<double> areas;
  for (const uint32_t t : triangles) areas.push_back(skin.area(t));
  std::vector<Piece> pieces;
  std::vector<float> cost(triangles.size(), std::numeric_limits<float>::infinity());
  std::vector<float> deviation(triangles.size(), 0.0F);
  const auto keep = [&](const Piece& piece, const Fit& fit) {
    pieces.push_back(piece);
    for (size_t i = 0; i < cost.size(); ++i) {
      if (!(fit.cost[i] < cost[i] - kTie)) continue;
      cost[i] = fit.cost[i];
      deviation[i] = fit.deviation[i];
    }
  };
  for (const Piece& piece : own) keep(piece, fit(piece, triangles, skin, weights, options.deviation));
  std::vector<Fit> fits;
  for (const Piece& piece : blends) fits.push_back(fit(piece, triangles, skin, weights, options.deviation));
  while (pieces.size() < options.most) {
    double most = 0;
    size_t chosen = blends.size();
    for (size_t c = 0; c < blends.size(); ++c) {
      double before = 0;
      double after = 0;
      double area = 0;
      for (size_t i = 0; i < cost.size(); ++i) {
        if (!(fits[c].cost[i] < cost[i] - kTie)) continue;
        before += areas[i] * static_cast<double>(deviation[i]) * static_cast<double>(deviation[i]);
        after += areas[i] * static_cast<double>(fits[c].deviation[i]) * static_cast<double>(fits[c].deviation[i]);
        area += areas[i];
      }
      if (before - after > most && before > options.deviation * options.deviation * area) {
        most = before - after;
        chosen = c;
      }
    }
    if (chosen == blends.size()) break;
    keep(blends[chosen], fits[chosen]);
  }
  return pieces;
}

// Vertices at one place have one number: seams of the texture do not part the skin.
std::vector<uint32_t> welded(const scene::Mesh& mesh) {
  std::map<std::array<float, 3>, uint32_t> places;
  std::vector<uint32_t> number;
  for (const glm::vec3& p : mesh.positions)
    number.push_back(places.emplace(std::array{p.x, p.y, p.z}, static_cast<uint32_t>(places.size())).first->second);
  return number;
}

// How far from a triangle a piece that takes it may be, in parts of the way from the piece to any nearer one: where all
// follow single joints, a summed weight W of 3 is a distance of 1 - W / 3.
double reach_of(const BendOptions& options) {
  switch (options.rule) {
    case TriangleRule::dominant: return 0.0;
    case TriangleRule::any: return 1.0;
    case TriangleRule::threshold: break;
  }
  return 1.0 - options.threshold / 3.0;
}

}  // namespace

std::vector<Piece> bend_pieces(const Character& character, const scene::PoseBank& bank, const CapturePose& capture,
                               const BendOptions& options) {
  const scene::Mesh& mesh = character.mesh;
  const Skin skin(character, bank, capture);
  std::vector<Weights> weights;  // of every triangle
  std::vector<uint32_t> all;     // triangles that any joint moves
  std::vector<char> leads(character.skeleton.joints.size(), 0);
  for (uint32_t t = 0; t < mesh.indices.size() / 3; ++t) {
    weights.push_back(mean_weights(mesh, t));
    if (weights[t].empty()) continue;
    all.push_back(t);
    const auto most = std::max_element(weights[t].begin(), weights[t].end(),
                                       [](const auto& a, const auto& b) { return a.second < b.second; });
    leads[static_cast<size_t>(most->first)] = 1;
  }
  std::vector<Piece> own;
  for (size_t joint = 0; joint < leads.size(); ++joint)
    if (leads[joint] != 0) own.push_back({.joints = {static_cast<int>(joint), 0}});
  std::vector<uint32_t> sampled;
  const size_t count = std::min(all.size(), kSampled);
  for (size_t i = 0; i < count; ++i) sampled.push_back(all[i * all.size() / count]);
  std::vector<Piece> pieces = choose(own, blends(weights, parents_of(character)), sampled, skin, weights, options);

  std::vector<Fit> fits;
  for (const Piece& piece : pieces) fits.push_back(fit(piece, all, skin, weights, options.deviation));
  std::vector<size_t> owner(all.size(), 0);
  for (size_t i = 0; i < all.size(); ++i)
    for (size_t p = 1; p < pieces.size(); ++p)
      if (fits[p].cost[i] < fits[owner[i]].cost[i] - kTie) owner[i] = p;
  const auto by_rule = [&](size_t p, const Weights& of) {
    const double here = distance(pieces[p], of);
    for (size_t q = 0; q < pieces.size(); ++q)
      if (q != p && distance(pieces[q], of) <= here &&
          !(here < reach_of(options) * distance(pieces[p], pieces[q]) - static_cast<double>(kTie)))
        return false;
    return true;
  };
  const std::vector<uint32_t> place = welded(mesh);
  std::vector<Piece> out;
  for (size_t p = 0; p < pieces.size(); ++p) {
    std::vector<char> touched(mesh.positions.size(), 0);
    bool owns = false;
    for (size_t i = 0; i < all.size(); ++i) {
      if (owner[i] != p) continue;
      owns = true;
      for (uint32_t corner = 0; corner < 3; ++corner) touched[place[mesh.indices[3 * all[i] + corner]]] = 1;
    }
    if (!owns) continue;
    for (size_t i = 0; i < all.size(); ++i) {
      bool next = false;
      for (uint32_t corner = 0; corner < 3; ++corner)
        next = next || touched[place[mesh.indices[3 * all[i] + corner]]] != 0;
      if (owner[i] == p || (next && static_cast<double>(fits[p].deviation[i]) <= options.deviation) ||
          by_rule(p, weights[all[i]]))
        pieces[p].triangles.push_back(all[i]);
    }
    out.push_back(std::move(pieces[p]));
  }
  return out;
}

}  // namespace crowdbench::renderers
