// A pose of some nodes alone. Internal to normalise.cpp, which measures every clip of a character by its soles.
#pragma once
#include <glm/glm.hpp>
#include <vector>

#include "scene/character/character.h"

namespace crowdbench::scene {

// As node_matrices() of scene/pose/pose.h, in a third of the time where these are legs; the other nodes' are the
// identity. wanted: by node; with a node all above it.
std::vector<glm::dmat4> some_node_matrices(const Character& character, int clip, double time,
                                           const std::vector<bool>& wanted);

}  // namespace crowdbench::scene
