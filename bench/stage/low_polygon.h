// The level of detail of the mesh that every figure of speed is also told against.
#pragma once
#include "renderers/representation.h"

namespace crowdbench::bench {

// The reference simplified to 500 triangles a character: what a user would reach for instead of an impostor.
inline renderers::Spec low_polygon_spec() {
  renderers::Spec spec = renderers::reference_spec();
  spec.options.emplace_back("triangles", "500");
  return spec;
}

}  // namespace crowdbench::bench
