// Dynamic impostors: a billboard an agent, drawn anew when its pose or its view has changed enough. See README.md in
// this folder.
#pragma once
#include "renderers/representation.h"

namespace crowdbench::renderers {

extern const RepresentationType dynamic_type;

}  // namespace crowdbench::renderers
