// Flat pre-generated impostors: one textured polygon an agent. See README.md in this folder.
#pragma once
#include "renderers/representation.h"

namespace crowdbench::renderers {

extern const RepresentationType flat_type;

}  // namespace crowdbench::renderers
