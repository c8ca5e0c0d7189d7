// Based on: Beacco et al. 2011 (a joint takes every triangle that it influences; captures in a random walking pose).
// Differs from the source: a threshold between one joint and all; the pose is measured; joints that hardly move against
// their parents at a given distance share a box.
#include "renderers/relief/relief_pieces.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>

#include "scene/pose/pose.h"

namespace crowdbench::renderers {
namespace {

using scene::Character;

glm::dmat4 matrix_of(const scene::Mat3x4& m) {
  glm::dmat4 out(1.0);
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 4; ++column) out[column][row] = static_cast<double>(m.rows[row][column]);
  return out;
}

std::vector<glm::dmat4> to_double(const scene::Mat3x4* matrices, size_t joints) {
  std::vector<glm::dmat4> out;
  for (size_t j = 0; j < joints; ++j) out.push_back(matrix_of(matrices[j]));
  return out;
}

class Mask {
 public:
  Mask(int width, int height) : width_(width), height_(height), on_(static_cast<size_t>(width) * height, 0) {}
  void clear() { std::fill(on_.begin(), on_.end(), uint8_t{0}); }
  void triangle(const glm::dvec2& a, const glm::dvec2& b, const glm::dvec2& c) {
    const double area = (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
    if (std::abs(area) < 1e-12) return;
    const int x0 = std::max(0, static_cast<int>(std::ceil(std::min({a.x, b.x, c.x}) - 0.5)));
    const int x1 = std::min(width_ - 1, static_cast<int>(std::floor(std::max({a.x, b.x, c.x}) - 0.5)));
    const int y0 = std::max(0, static_cast<int>(std::ceil(std::min({a.y, b.y, c.y}) - 0.5)));
    const int y1 = std::min(height_ - 1, static_cast<int>(std::floor(std::max({a.y, b.y, c.y}) - 0.5)));
    for (int y = y0; y <= y1; ++y) {
      for (int x = x0; x <= x1; ++x) {
        const glm::dvec2 p(x + 0.5, y + 0.5);
        const double u = ((p.x - a.x) * (c.y - a.y) - (p.y - a.y) * (c.x - a.x)) / area;
        const double v = ((b.x - a.x) * (p.y - a.y) - (b.y - a.y) * (p.x - a.x)) / area;
        if (u >= 0 && v >= 0 && u + v <= 1) on_[static_cast<size_t>(y) * static_cast<size_t>(width_) + x] = 1;
      }
    }
  }
  static std::pair<size_t, size_t> differing(const Mask& a, const Mask& b) {  // pixels that differ; pixels of a
    size_t differ = 0;
    size_t covered = 0;
    for (size_t i = 0; i < a.on_.size(); ++i) {
      differ += a.on_[i] != b.on_[i];
      covered += a.on_[i];
    }
    return {differ, covered};
  }

 private:
  int width_, height_;
  std::vector<uint8_t> on_;
};

}  // namespace

std::vector<std::vector<glm::dmat4>> spread_poses(const scene::PoseBank& bank, size_t most) {
  const auto joints = static_cast<size_t>(bank.joints());
  const size_t samples = bank.matrices().size() / std::max<size_t>(joints, 1);
  const size_t count = std::min(samples, most);
  std::vector<std::vector<glm::dmat4>> poses;
  for (size_t i = 0; i < count; ++i)
    poses.push_back(to_double(bank.matrices().data() + i * samples / count * joints, joints));
  return poses;
}

glm::dmat4 inverse_or_zero(const glm::dmat4& m) {
  return std::abs(glm::determinant(glm::dmat3(m))) < 1e-18 ? glm::dmat4(0.0) : glm::inverse(m);
}

std::vector<glm::dmat4> capture_palette(const Character& character, const CapturePose& pose) {
  const scene::PoseBank bank =
      pose.clip < 0
          ? scene::PoseBank::exact(character, -1, 0.0)
          : scene::PoseBank::exact(character, pose.clip,
                                   character.clips[static_cast<size_t>(pose.clip)].start +
                                       pose.phase * character.clips[static_cast<size_t>(pose.clip)].duration());
  return to_double(bank.matrices().data(), bank.matrices().size());
}

Carriers own_carriers(const Character& character) {
  Carriers carriers(character.skeleton.joints.size());
  for (size_t j = 0; j < carriers.size(); ++j) carriers[j] = static_cast<int>(j);
  return carriers;
}

std::vector<std::vector<uint32_t>> assign_triangles(const Character& character, TriangleRule rule, double threshold,
                                                    const Carriers& carriers) {
  const scene::Mesh& mesh = character.mesh;
  std::vector<std::vector<uint32_t>> triangles_of(character.skeleton.joints.size());
  std::vector<std::pair<size_t, double>> sums;
  for (uint32_t t = 0; t < mesh.indices.size() / 3; ++t) {
    sums.clear();
    for (uint32_t corner = 0; corner < 3; ++corner) {
      const uint32_t vertex = mesh.indices[3 * t + corner];
      for (int k = 0; k < scene::kInfluences; ++k) {
        const double weight = static_cast<double>(mesh.weights[vertex][k]);
        if (weight <= 0) continue;
        const auto joint = static_cast<size_t>(carriers[mesh.joints[vertex][k]]);
        auto found = std::find_if(sums.begin(), sums.end(), [&](const auto& s) { return s.first == joint; });
        if (found == sums.end())
          sums.emplace_back(joint, weight);
        else
          found->second += weight;
      }
    }
    if (sums.empty()) continue;
    const auto dominant = std::max_element(sums.begin(), sums.end(), [](const auto& a, const auto& b) {
      return a.second < b.second || (a.second == b.second && a.first > b.first);
    });
    for (const auto& [joint, sum] : sums) {
      const bool takes =
          joint == dominant->first || rule == TriangleRule::any || (rule == TriangleRule::threshold && sum > threshold);
      if (takes) triangles_of[joint].push_back(t);
    }
  }
  return triangles_of;
}

glm::dmat4 matrix_of(const Piece& piece, const std::vector<glm::dmat4>& palette) {
  glm::dmat4 mean(0.0);
  for (const Share& share : piece.shares) mean += share.weight * palette[static_cast<size_t>(share.joint)];
  return mean;
}

std::vector<int> parents_of(const Character& character) {
  const std::vector<scene::Joint>& joints = character.skeleton.joints;
  std::vector<int> joint_of_node(character.skeleton.nodes.size(), -1);
  for (size_t j = joints.size(); j-- > 0;) joint_of_node[static_cast<size_t>(joints[j].node)] = static_cast<int>(j);
  std::vector<int> parents;
  for (size_t j = 0; j < joints.size(); ++j) {
    int node = joints[j].node;
    // An entry that shares its node with an earlier one (a rigid mesh on a joint) hangs on that.
    int above =
        joint_of_node[static_cast<size_t>(node)] == static_cast<int>(j) ? -1 : joint_of_node[static_cast<size_t>(node)];
    while (above < 0 && (node = character.skeleton.nodes[static_cast<size_t>(node)].parent) >= 0)
      above = joint_of_node[static_cast<size_t>(node)];
    parents.push_back(above);
  }
  return parents;
}

std::vector<Piece> joint_pieces(const Character& character, TriangleRule rule, double threshold,
                                const Carriers& carriers) {
  std::vector<std::vector<uint32_t>> triangles_of = assign_triangles(character, rule, threshold, carriers);
  std::vector<Piece> pieces;
  for (size_t joint = 0; joint < triangles_of.size(); ++joint)
    if (!triangles_of[joint].empty())
      pieces.push_back({.shares = {{static_cast<int>(joint)}}, .triangles = std::move(triangles_of[joint])});
  return pieces;
}

JointMerger::JointMerger(const Character& character, const scene::PoseBank& bank, const CapturePose& capture)
    : parent_(parents_of(character)) {
  const scene::Mesh& mesh = character.mesh;
  const size_t joints = character.skeleton.joints.size();
  std::vector<std::vector<size_t>> all(joints);
  for (size_t v = 0; v < mesh.positions.size(); ++v) {
    int most = 0;
    for (int k = 1; k < scene::kInfluences; ++k)
      if (mesh.weights[v][k] > mesh.weights[v][most]) most = k;
    all[mesh.joints[v][most]].push_back(v);
  }
  vertices_.resize(joints);
  for (size_t j = 0; j < joints; ++j) {
    const size_t count = std::min<size_t>(all[j].size(), 24);
    for (size_t i = 0; i < count; ++i) vertices_[j].push_back(all[j][i * all[j].size() / count]);
  }
  const std::vector<glm::dmat4> palette = capture_palette(character, capture);
  captured_ = scene::skin_positions(mesh, palette);
  for (const auto& pose : spread_poses(bank, 12)) {
    posed_.push_back(scene::skin_positions(mesh, pose));
    std::vector<glm::dmat4>& moved = moved_.emplace_back();
    for (size_t j = 0; j < joints; ++j) moved.push_back(pose[j] * inverse_or_zero(palette[j]));
  }
  errors_.assign(joints * joints, -1.0);
}

double JointMerger::error(size_t joint, size_t carrier) {
  double& memo = errors_[joint * vertices_.size() + carrier];
  if (memo >= 0) return memo;
  double sum = 0;
  for (size_t t = 0; t < posed_.size(); ++t) {
    for (const size_t v : vertices_[joint]) {
      const glm::dvec3 there(moved_[t][carrier] * glm::dvec4(captured_[v], 1.0));
      const glm::dvec3 gap = there - posed_[t][v];
      sum += glm::dot(gap, gap);
    }
  }
  memo = vertices_[joint].empty() ? 0.0 : sum / static_cast<double>(posed_.size() * vertices_[joint].size());
  return memo;
}

Carriers JointMerger::merged(double tolerance) {
  const size_t joints = vertices_.size();
  std::vector<std::vector<size_t>> members(joints);
  Carriers carriers(joints);
  for (size_t j = 0; j < joints; ++j) {
    members[j] = {j};
    carriers[j] = static_cast<int>(j);
  }
  for (;;) {
    double least = tolerance * tolerance;
    std::optional<std::array<size_t, 3>> best;  // two groups by their carriers, and the carrier of both
    for (size_t j = 0; j < joints; ++j) {
      if (parent_[j] < 0) continue;
      const auto a = static_cast<size_t>(carriers[j]);
      const auto b = static_cast<size_t>(carriers[static_cast<size_t>(parent_[j])]);
      if (a == b) continue;
      for (const size_t carrier : {b, a}) {
        double worst = 0;
        for (const size_t group : {a, b})
          for (const size_t m : members[group]) worst = std::max(worst, error(m, carrier) - error(m, m));
        if (worst < least) {
          least = worst;
          best = {a, b, carrier};
        }
      }
    }
    if (!best) return carriers;
    const auto& [a, b, carrier] = *best;
    std::vector<size_t> both = members[a];
    both.insert(both.end(), members[b].begin(), members[b].end());
    members[a].clear();
    members[b].clear();
    for (const size_t m : both) carriers[m] = static_cast<int>(carrier);
    members[carrier] = std::move(both);
  }
}

std::vector<CaptureScore> score_captures(const Character& character, const scene::PoseBank& bank, TriangleRule rule,
                                         double threshold, const BakeProgress& progress) {
  constexpr int kTall = 96;
  const scene::Mesh& mesh = character.mesh;
  const size_t joints = character.skeleton.joints.size();
  const auto triangles_of = assign_triangles(character, rule, threshold, own_carriers(character));
  const auto poses = spread_poses(bank, 8);
  const glm::dvec3 low(bank.bounds_min());
  const glm::dvec3 high(bank.bounds_max());
  const double reach = std::max({std::abs(low.x), std::abs(high.x), std::abs(low.z), std::abs(high.z), 1e-6}) * 1.42;
  const double scale = kTall / std::max(high.y - low.y, 1e-6);
  const int wide = std::clamp(static_cast<int>(std::ceil(2 * reach * scale)), 1, 1024);
  const double h = std::sqrt(0.5);
  const std::array<glm::dvec2, 3> rights{glm::dvec2(1, 0), glm::dvec2(0, 1), glm::dvec2(h, h)};  // x, z
  const auto project = [&](const glm::dvec3& p, const glm::dvec2& right) {
    return glm::dvec2((p.x * right.x + p.z * right.y + reach) * scale, (p.y - low.y) * scale);
  };

  std::vector<std::vector<glm::dvec3>> skins;
  for (const auto& pose : poses) skins.push_back(scene::skin_positions(mesh, pose));
  std::vector<Mask> references;
  for (const auto& skin : skins) {
    for (const glm::dvec2& right : rights) {
      Mask& mask = references.emplace_back(wide, kTall);
      for (size_t i = 0; i + 2 < mesh.indices.size(); i += 3)
        mask.triangle(project(skin[mesh.indices[i]], right), project(skin[mesh.indices[i + 1]], right),
                      project(skin[mesh.indices[i + 2]], right));
    }
  }

  std::vector<CapturePose> candidates{{}};
  for (const scene::BankClip& clip : bank.clips()) {
    if (clip.clip < 0) continue;
    const int phases = clip.samples > 1 ? 8 : 1;
    for (int k = 0; k < phases; ++k) candidates.push_back({clip.clip, static_cast<double>(k) / phases});
  }
  std::vector<CaptureScore> scores;
  Mask mask(wide, kTall);
  std::vector<glm::dvec3> moved(mesh.positions.size());
  for (const CapturePose& candidate : candidates) {
    if (progress) progress(scores.size(), candidates.size());
    const std::vector<glm::dmat4> palette = capture_palette(character, candidate);
    const std::vector<glm::dvec3> captured = scene::skin_positions(mesh, palette);
    CaptureScore score{candidate, 0, 0};
    std::vector<glm::dmat4> back;
    for (size_t j = 0; j < joints; ++j) {
      back.push_back(inverse_or_zero(palette[j]));
      if (triangles_of[j].empty()) continue;
      const glm::dmat4 joint_from_capture = character.skeleton.joints[j].inverse_bind * back[j];
      glm::dvec3 least(std::numeric_limits<double>::infinity());
      glm::dvec3 most(-least);
      for (const uint32_t t : triangles_of[j]) {
        for (uint32_t corner = 0; corner < 3; ++corner) {
          const glm::dvec3 p(joint_from_capture * glm::dvec4(captured[mesh.indices[3 * t + corner]], 1.0));
          least = glm::min(least, p);
          most = glm::max(most, p);
        }
      }
      const glm::dmat3 metres(palette[j] * glm::inverse(character.skeleton.joints[j].inverse_bind));
      const glm::dvec3 size = most - least;
      score.box_volume += size.x * size.y * size.z * std::abs(glm::determinant(metres));
    }
    size_t differ = 0;
    size_t covered = 0;
    for (size_t t = 0; t < poses.size(); ++t) {
      for (size_t view = 0; view < rights.size(); ++view) {
        mask.clear();
        for (size_t j = 0; j < joints; ++j) {
          if (triangles_of[j].empty()) continue;
          const glm::dmat4 rigid = poses[t][j] * back[j];
          for (const uint32_t triangle : triangles_of[j]) {
            std::array<glm::dvec2, 3> p;
            for (uint32_t corner = 0; corner < 3; ++corner)
              p[corner] = project(glm::dvec3(rigid * glm::dvec4(captured[mesh.indices[3 * triangle + corner]], 1.0)),
                                  rights[view]);
            mask.triangle(p[0], p[1], p[2]);
          }
        }
        const auto [d, c] = Mask::differing(references[t * rights.size() + view], mask);
        differ += d;
        covered += c;
      }
    }
    score.silhouette_error = static_cast<double>(differ) / static_cast<double>(std::max<size_t>(covered, 1));
    scores.push_back(score);
  }
  return scores;
}

CaptureScore choose_capture(const std::vector<CaptureScore>& scores) {
  double least = std::numeric_limits<double>::infinity();
  for (const CaptureScore& s : scores) least = std::min(least, s.silhouette_error);
  const CaptureScore* best = nullptr;
  for (const CaptureScore& s : scores)
    if (s.silhouette_error <= 1.02 * least && (best == nullptr || s.box_volume < best->box_volume)) best = &s;
  return *best;
}

}  // namespace crowdbench::renderers
