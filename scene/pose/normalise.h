// How every character, loaded or built in, is finished.
#pragma once
#include <optional>
#include <string>

#include "scene/character/character.h"

namespace crowdbench::scene {

struct NormaliseOptions {
  std::optional<double> height = 1.75;  // metres; std::nullopt: as the file has it
};
// Fills placement, motion (one for each clip) and content_hash. A character without a clip of non-zero length is placed
// by its bind pose.
void normalise(Character& character, const NormaliseOptions& options);
// SHA-256 of everything that a bake depends on: skeleton, mesh, materials, images, clips, placement and motion; not the
// file's name. normalise() ends with it.
std::string compute_content_hash(const Character& character);

}  // namespace crowdbench::scene
