// Point clouds: skinned surfels, as many as the figure's pixels ask for. See README.md in this folder.
#pragma once
#include "renderers/representation.h"

namespace crowdbench::renderers {

extern const RepresentationType surfel_type;

}  // namespace crowdbench::renderers
