// The reference representation: the skinned mesh itself. See README.md in this folder.
#pragma once
#include "renderers/representation.h"

namespace crowdbench::renderers {

extern const RepresentationType mesh_type;

}  // namespace crowdbench::renderers
