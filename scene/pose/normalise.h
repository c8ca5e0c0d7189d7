// How every character is finished after loading: default clip, height, ground, pivot, ground speed and content hash.
#pragma once
#include <optional>
#include <string>

#include "scene/character/character.h"

namespace crowdbench::scene {

// How the loader and the built-in character finish: default clip, height, pivot, ground speed, content hash.
struct NormaliseOptions {
  std::optional<double> height = 1.75;  // metres; nullopt = as_is
};
// Fills placement, motion (one a clip) and content_hash. A character without a clip of non-zero length is placed by its
// bind pose.
void normalise(Character& character, const NormaliseOptions& options);
// SHA-256 of everything that a bake depends on: skeleton, mesh, materials, images, clips, placement and motion; not the
// file's name. normalise() ends with it.
std::string compute_content_hash(const Character& character);

}  // namespace crowdbench::scene
