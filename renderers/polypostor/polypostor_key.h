// Which frame's image of a part stands best for all frames of a clip.
#pragma once
#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <vector>

#include "scene/character/character.h"

namespace crowdbench::renderers {

// The base colour at every vertex, square root of linear: the material's factor, its image's nearest texel, the
// vertex's colour; with what the material gives off, as far as white.
std::vector<glm::vec3> vertex_tones(const scene::Character& character);

// What a view sees of a posed part, at one sample a texel: the tone and the normal of the nearest surface, from either
// side.
struct PartLook {
  struct Sample {
    glm::vec3 tone{0.0F};
    glm::vec3 normal{0.0F};  // view axes, unit; zero where nothing is seen
  };
  int x = 0, y = 0;  // texels, of the first column and row
  int width = 0, height = 0;
  std::vector<Sample> samples;  // rows bottom first
};
// corners: triangles, three vertices each. positions: texels in view axes, z towards the eye; normals: view axes.
PartLook look_at_part(std::span<const uint32_t> corners, std::span<const glm::dvec3> positions,
                      std::span<const glm::vec3> normals, std::span<const glm::vec3> tones);

// How wrong a frame looks when the part's image of another frame is moved there, summed over its samples: the image is
// moved by the affine map that takes the part's vertices there with the least squares, its normals turned with it. Of
// two samples it is the mean square, over white light from everywhere, of the difference of what they send to the eye;
// a sample that the image does not show counts kUnseen times what it sends.
inline constexpr double kUnseen = 0.5;
double look_error(const PartLook& shown, const PartLook& wanted, std::span<const uint32_t> corners,
                  std::span<const glm::dvec3> shown_positions, std::span<const glm::dvec3> wanted_positions);

}  // namespace crowdbench::renderers
