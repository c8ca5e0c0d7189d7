#include "scene/pose/hidden.h"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "scene/pose/pose.h"
#include "scene/pose/pose_bank.h"

namespace crowdbench::scene {
namespace {

// Of the figure's size: a triangle whose height over its longest side is less shows in no picture.
constexpr double kThin = 1e-7;
constexpr double kGone = 1e-4;  // of the largest stretch: what a joint carries there is a tenth of a millimetre

bool larger(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c, double least) {
  const double longest = std::max({glm::length(b - a), glm::length(c - b), glm::length(a - c)});
  return longest > least && glm::length(glm::cross(b - a, c - a)) > least * longest;
}

// Does any joint of a palette stretch too little for what it carries to be seen?
bool may_hide(std::span<const double> stretches) {
  return !stretches.empty() && *std::ranges::min_element(stretches) < kGone * *std::ranges::max_element(stretches);
}

}  // namespace

bool has_area(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c, double figure) {
  return larger(a, b, c, kThin * figure);
}

std::vector<double> stretches(std::span<const glm::dmat4> palette) {
  std::vector<double> out;
  for (const glm::dmat4& m : palette) {
    double sum = 0;
    for (int axis = 0; axis < 3; ++axis) sum += glm::dot(glm::dvec3(m[axis]), glm::dvec3(m[axis]));
    out.push_back(std::sqrt(sum));
  }
  return out;
}

std::vector<double> stretches(std::span<const Mat3x4> palette) {
  std::vector<double> out;
  for (const Mat3x4& m : palette) {
    double sum = 0;
    for (const glm::vec4& row : m.rows) sum += static_cast<double>(glm::dot(glm::vec3(row), glm::vec3(row)));
    out.push_back(std::sqrt(sum));
  }
  return out;
}

std::vector<uint32_t> hidden_vertices(const Mesh& mesh, std::span<const double> stretches,
                                      const std::function<glm::dvec3(uint32_t)>& posed) {
  if (!may_hide(stretches)) return {};
  const double gone = kGone * *std::ranges::max_element(stretches);
  std::vector<bool> hidden(mesh.positions.size(), false);
  for (size_t v = 0; v < hidden.size(); ++v) {
    double stretch = 0;
    for (int i = 0; i < kInfluences; ++i)
      stretch += static_cast<double>(mesh.weights[v][i]) * stretches[mesh.joints[v][i]];
    hidden[v] = stretch < gone;
  }
  glm::dvec3 low(INFINITY);
  glm::dvec3 high(-INFINITY);
  for (uint32_t v = 0; v < hidden.size(); ++v) {
    if (hidden[v]) continue;
    low = glm::min(low, posed(v));
    high = glm::max(high, posed(v));
  }
  const double least = kGone * glm::length(high - low);
  std::vector<uint32_t> shown;
  for (size_t i = 0; i + 2 < mesh.indices.size(); i += 3) {
    const uint32_t* t = &mesh.indices[i];
    if (!hidden[t[0]] && !hidden[t[1]] && !hidden[t[2]]) continue;
    if (larger(posed(t[0]), posed(t[1]), posed(t[2]), least)) shown.insert(shown.end(), t, t + 3);
  }
  for (const uint32_t v : shown) hidden[v] = false;
  std::vector<uint32_t> out;
  for (uint32_t v = 0; v < hidden.size(); ++v)
    if (hidden[v]) out.push_back(v);
  return out;
}

std::vector<glm::dvec3> shown_positions(const Mesh& mesh, const std::vector<glm::dmat4>& palette) {
  std::vector<glm::dvec3> positions = skin_positions(mesh, palette);
  put_aside(positions, hidden_vertices(mesh, stretches(palette), [&](uint32_t v) { return positions[v]; }));
  return positions;
}

std::vector<double> shown_heights(const Mesh& mesh, const std::vector<glm::dmat4>& palette) {
  std::vector<double> heights(mesh.positions.size());
  if (may_hide(stretches(palette))) {
    const std::vector<glm::dvec3> positions = shown_positions(mesh, palette);
    for (size_t v = 0; v < heights.size(); ++v) heights[v] = positions[v].y;
    return heights;
  }
  std::vector<glm::dvec4> rows;  // of each joint, what makes heights
  rows.reserve(palette.size());
  for (const glm::dmat4& m : palette) rows.emplace_back(m[0].y, m[1].y, m[2].y, m[3].y);
  // In the order of skin_positions(), so that they are the same to the last bit.
  for (size_t v = 0; v < heights.size(); ++v) {
    const glm::dvec3 position(mesh.positions[v]);
    double sum = 0;
    for (int i = 0; i < kInfluences; ++i) {
      const double weight = mesh.weights[v][i];
      if (weight == 0.0) continue;
      const glm::dvec4& row = rows[mesh.joints[v][i]];
      sum += weight * ((row.x * position.x + row.y * position.y) + (row.z * position.z + row.w));
    }
    heights[v] = sum;
  }
  return heights;
}

std::vector<glm::vec3> shown_positions(const Mesh& mesh, std::span<const Mat3x4> palette) {
  std::vector<glm::vec3> positions = skin_points(mesh, palette);
  put_aside(positions, hidden_vertices(mesh, stretches(palette), [&](uint32_t v) { return positions[v]; }));
  return positions;
}

std::vector<uint32_t> never_shown(const Character& character) {
  std::vector<uint32_t> out;
  bool first = true;
  for (size_t clip = 0; clip < character.clips.size(); ++clip)
    for (const double share : {0.0, 0.5, 1.0}) {
      const Clip& curves = character.clips[clip];
      const auto palette = joint_matrices(character, static_cast<int>(clip), curves.start + share * curves.duration());
      const std::vector<double> stretch = stretches(palette);
      std::vector<uint32_t> here;
      if (may_hide(stretch)) {
        const std::vector<glm::dvec3> positions = skin_positions(character.mesh, palette);
        here = hidden_vertices(character.mesh, stretch, [&](uint32_t v) { return positions[v]; });
      }
      if (first) {
        out = std::move(here);
      } else {
        std::vector<uint32_t> both;
        std::ranges::set_intersection(out, here, std::back_inserter(both));
        out = std::move(both);
      }
      first = false;
      if (out.empty()) return out;
    }
  return out;
}

}  // namespace crowdbench::scene
