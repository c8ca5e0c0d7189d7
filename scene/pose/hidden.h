// What a pose hides: game kits put weapons, hats and heads away by scaling their joints to nothing. What no triangle
// with area shows has no say in what is measured on that pose.
#pragma once
#include <cstdint>
#include <functional>
#include <glm/glm.hpp>
#include <span>
#include <vector>

#include "scene/character/character.h"

namespace crowdbench::scene {

struct Mat3x4;

// Has the triangle area? As posed, for its own size and that of the figure (the diagonal of its box).
bool has_area(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c, double figure);

// By joint of a palette, how far it stretches what it carries: the root of the sum of the squares of its 3 x 3.
std::vector<double> stretches(std::span<const glm::dmat4> palette);
std::vector<double> stretches(std::span<const Mat3x4> palette);

// Vertices that show nothing in a pose, in ascending order: their joints stretch by less than a ten thousandth of what
// the palette's largest does, and no triangle of theirs is larger than that part of all else. None in nearly every
// pose. posed: a vertex's position.
std::vector<uint32_t> hidden_vertices(const Mesh& mesh, std::span<const double> stretches,
                                      const std::function<glm::dvec3(uint32_t)>& posed);

// Moves hidden vertices to where a shown one is, so that no bound holds them; the triangles that have such corners mean
// nothing then.
template <typename Positions>
void put_aside(Positions& positions, std::span<const uint32_t> hidden) {
  if (hidden.size() >= positions.size()) return;
  uint32_t shown = 0;
  while (shown < hidden.size() && hidden[shown] == shown) ++shown;
  for (const uint32_t v : hidden) positions[v] = positions[shown];
}

// As skin_positions() of scene/pose/pose.h, what the pose hides put aside.
std::vector<glm::dvec3> shown_positions(const Mesh& mesh, const std::vector<glm::dmat4>& palette);
// Their y alone, which costs a fourth.
std::vector<double> shown_heights(const Mesh& mesh, const std::vector<glm::dmat4>& palette);
// The same of skin_points() of scene/pose/pose_bank.h.
std::vector<glm::vec3> shown_positions(const Mesh& mesh, std::span<const Mat3x4> palette);

// Vertices that no clip shows at its ends and in its middle, though the bind pose may. None where there are no clips.
std::vector<uint32_t> never_shown(const Character& character);

}  // namespace crowdbench::scene
