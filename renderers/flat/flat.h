// Flat pre-generated impostors: one textured polygon an agent. See README.md in this folder.
#pragma once
#include "renderers/flat/flat_bake.h"
#include "renderers/representation.h"

namespace crowdbench::renderers {

extern const RepresentationType flat_type;

// Several polygons a tile, parallel to its plane, each for an interval of the stored depths (renderers/layered).
struct FlatSlices {
  int most = 1;        // of the finest level; half as many of each coarser one
  double overlap = 0;  // share of an interval by which it is longer at both ends
  bool floor = false;
};
std::unique_ptr<Representation> make_flat_slices(const MakeContext& make, const FlatBakeOptions& options,
                                                 const FlatSlices& slices);

// The bake's options as a spec of this type has them. Throws Error.
FlatBakeOptions flat_bake_options(const Spec& spec);

}  // namespace crowdbench::renderers
