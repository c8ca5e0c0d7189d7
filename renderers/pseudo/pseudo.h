// Pseudo-instancing: a few poses, skinned once a frame, that all agents share. See README.md in this folder.
#pragma once
#include "renderers/representation.h"

namespace crowdbench::renderers {

extern const RepresentationType pseudo_type;

}  // namespace crowdbench::renderers
