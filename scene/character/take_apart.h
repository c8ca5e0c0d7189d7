// A node's matrix as translation, rotation and scale, which alone can be animated.
#pragma once
#include "scene/character/character.h"

namespace crowdbench::scene {

// Afterwards the node has no matrix; its transform is the same. false, and nothing is changed, where the matrix has
// shear or no volume. A mirrored matrix becomes a negative scale in x.
bool take_apart(Node& node);

}  // namespace crowdbench::scene
