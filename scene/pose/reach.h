// How far any pose of a character can reach.
#pragma once
#include <cstddef>
#include <optional>

#include "scene/character/character.h"

namespace crowdbench::scene {

// The first node whose scale or whose distance from the origin can pass `limit` in the rest pose or any pose of a clip:
// scales multiply down the hierarchy. A bound, not the pose itself. What it lets pass cannot overflow anywhere
// else. std::nullopt when no node can. Parents stand before their children.
std::optional<size_t> node_beyond_reach(const Character& character, double limit);

}  // namespace crowdbench::scene
