#include "renderers/dynamic/dynamic.h"
#include "renderers/flat/flat.h"
#include "renderers/hybrid/hybrid.h"
#include "renderers/layered/layered.h"
#include "renderers/mesh/mesh.h"
#include "renderers/perjoint/perjoint.h"
#include "renderers/polypostor/polypostor.h"
#include "renderers/posecache/posecache.h"
#include "renderers/preskinned/preskinned.h"
#include "renderers/pseudo/pseudo.h"
#include "renderers/relief/relief.h"
#include "renderers/representation.h"
#include "renderers/rigid/rigid.h"
#include "renderers/surfel/surfel.h"

namespace crowdbench::renderers {

// One line a representation, so that two additions do not meet.

const std::vector<RepresentationType>& representation_types() {
  // clang-format off
  static const std::vector<RepresentationType> types = {
      mesh_type,
      flat_type,
      hybrid_type,
      relief_type,
      rigid_type,
      polypostor_type,
      preskinned_type,
      pseudo_type,
      surfel_type,
      posecache_type,
      dynamic_type,
      layered_type,
      perjoint_type,
  };
  // clang-format on
  return types;
}

}  // namespace crowdbench::renderers
