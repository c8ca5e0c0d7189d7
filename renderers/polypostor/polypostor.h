// Polypostors: an image a body part and view, moved through the clip by a polygon. See README.md in this folder.
#pragma once
#include "renderers/representation.h"

namespace crowdbench::renderers {

extern const RepresentationType polypostor_type;

}  // namespace crowdbench::renderers
