// Bone-relief impostors: one box a joint, dual-depth relief maps on its faces, a ray search a pixel.
#pragma once
#include "renderers/representation.h"

namespace crowdbench::renderers {

extern const RepresentationType relief_type;

}  // namespace crowdbench::renderers
