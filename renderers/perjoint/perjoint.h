// Per-joint impostors: a flat picture a joint and view, moved as the joint is. See README.md in this folder.
#pragma once
#include "renderers/representation.h"

namespace crowdbench::renderers {

extern const RepresentationType perjoint_type;

}  // namespace crowdbench::renderers
