// Pose cache: key poses, skinned once and kept, that agents are blended from. See README.md in this folder.
#pragma once
#include "renderers/representation.h"

namespace crowdbench::renderers {

extern const RepresentationType posecache_type;

}  // namespace crowdbench::renderers
