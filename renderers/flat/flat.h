// Flat pre-generated impostors: one textured polygon an agent. See README.md in this folder.
#pragma once
#include "renderers/flat/flat_bake.h"
#include "renderers/representation.h"

namespace crowdbench::renderers {

extern const RepresentationType flat_type;

// The bake's options as a spec of this type has them. Throws Error.
FlatBakeOptions flat_bake_options(const Spec& spec);

}  // namespace crowdbench::renderers
