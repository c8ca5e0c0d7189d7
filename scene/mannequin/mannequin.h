// The built-in character: a clothed human figure made by code, the same bytes every time, so that nothing needs a
// download.
#pragma once
#include "scene/character/character.h"
#include "scene/pose/normalise.h"

namespace crowdbench::scene {

struct MannequinOptions {
  int triangles = 5000;  // 500, 2200 or 5000: the level of detail, met within 5 %
  int joints = 20;       // 20, or 53 with fingers
  NormaliseOptions normalise;
};

// Clips: walk, run, idle, wave; each loops. Materials, which are also its outfit slots, in this order: skin, hair,
// shirt, trousers, shoes. One 1024x1024 procedural texture. Stands 1.75 m tall, faces +Z. Throws Error on other option
// values.
Character make_mannequin(const MannequinOptions& options = {});

}  // namespace crowdbench::scene
