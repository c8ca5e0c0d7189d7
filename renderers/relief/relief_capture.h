// One axis of a box, captured: what of the skin its two faces see, texel by texel, and from which depth to which the
// body is in each.
#pragma once
#include <glm/glm.hpp>
#include <vector>

#include "renderers/relief/relief_bake.h"
#include "renderers/relief/relief_pyramid.h"
#include "scene/character/character.h"

namespace crowdbench::renderers {

// Everything that capturing reads of the character, at the capture pose.
struct CaptureSource {
  const scene::Character& character;
  const std::vector<glm::dvec3>& positions;
  const std::vector<glm::dvec3>& normals;
  const std::vector<int>& material_of_triangle;
  const std::vector<LinearPyramid>& pyramids;
  float emission_peak;
};

// One box's frames.
struct BoxSpace {
  glm::dmat4 unit_from_capture;
  glm::dmat3 unit_from_bind;
  glm::dmat3 bind_from_capture;
  bool bends;  // weights change over the box, and with them what turns normals
};

// The box's part of the model's maps along an axis: depths and extents, and the colours, normals and glow of its two
// faces. all: what the box's piece captures. patch: it is a patch of skin, which bends.
void capture_axis(const CaptureSource& source, const BoxSpace& space, const std::vector<Skirt>& all, bool patch,
                  size_t box, int axis, ReliefModel& model);

}  // namespace crowdbench::renderers
