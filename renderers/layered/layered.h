// Layered impostors: the tiles of flat impostors as parallel layers, one for each interval of their stored depths. See
// README.md in this folder.
#pragma once
#include "renderers/representation.h"

namespace crowdbench::renderers {

extern const RepresentationType layered_type;

}  // namespace crowdbench::renderers
