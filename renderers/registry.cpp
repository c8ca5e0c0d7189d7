#include "renderers/flat/flat.h"
#include "renderers/hybrid/hybrid.h"
#include "renderers/mesh/mesh.h"
#include "renderers/relief/relief.h"
#include "renderers/representation.h"

namespace crowdbench::renderers {

// One line a representation.

const std::vector<RepresentationType>& representation_types() {
  static const std::vector<RepresentationType> types = {
      mesh_type,
      flat_type,
      hybrid_type,
      relief_type,
  };
  return types;
}

}  // namespace crowdbench::renderers
