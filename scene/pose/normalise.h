// How every character, loaded or built in, is finished.
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "scene/character/character.h"

namespace crowdbench::scene {

struct NormaliseOptions {
  std::optional<double> height = 1.75;  // metres; std::nullopt: as the file has it
  // Turns the character about +Y, degrees, from +Z towards +X, so that it faces +Z. std::nullopt: not, or by 180 with a
  // warning where its walk and its feet both point to -Z.
  std::optional<double> turn_deg;
  UpAxis up = UpAxis::y;  // which axis of the file points up; z is turned to y about x, before turn_deg
  // The clips in use, by name or index, "none" for the bind pose; empty: the default clip. One of them gives the height
  // (Placement::upright_clip), because a figure is to be as tall as asked in the clip that is drawn. A name that is not
  // there has no say: whoever wants to play it says so.
  std::vector<std::string> clips;
};
// Fills placement, motion (one for each clip) and content_hash, and adds a node on top where the character is turned. A
// character without a clip of non-zero length is placed by its bind pose.
void normalise(Character& character, const NormaliseOptions& options);
// The clip of that name or index; -1 for "none" where no clip is called so. Throws Error.
int require_clip_or_none(const Character& character, const std::string& name_or_index);
// SHA-256 of everything that a bake depends on: skeleton, mesh, materials, images, clips, placement and motion; not the
// file's name. normalise() ends with it.
std::string compute_content_hash(const Character& character);

}  // namespace crowdbench::scene
