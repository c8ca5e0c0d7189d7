// Compute skinning: the reference's mesh, skinned once a frame into a buffer that every pass draws. See README.md in
// this folder.
#pragma once
#include "renderers/representation.h"

namespace crowdbench::renderers {

extern const RepresentationType preskinned_type;

}  // namespace crowdbench::renderers
