// Rigid meshes: the character's mesh in stored poses of its clips, without skinning. See README.md in this folder.
#pragma once
#include "renderers/representation.h"

namespace crowdbench::renderers {

extern const RepresentationType rigid_type;

}  // namespace crowdbench::renderers
