#include "scene/gltf/gltf_asset.h"

#include <utility>

#include "core/error.h"

namespace crowdbench::scene {

GltfAsset::GltfAsset(GltfSource& from, GltfPlan checked, const LoadOptions& how)
    : source(from), plan(std::move(checked)), options(how), limits(how.limits) {
  character.warnings = std::move(plan.warnings);
}

const AccessorView& GltfAsset::view_of(int accessor) const {
  const AccessorView& view = plan.accessors[index_of(accessor)];
  check_sparse(view, source);
  return view;
}

void GltfAsset::fail_beyond(const AccessorView& view, size_t i, double value) const {
  fail(view.path, fmt::format("element {} holds {:.6g}, beyond the limit of {}", i, value, limits.magnitude));
}

glm::vec3 GltfAsset::finite3(const AccessorView& view, size_t i) const {
  return {static_cast<float>(finite(view, i, 0)), static_cast<float>(finite(view, i, 1)),
          static_cast<float>(finite(view, i, 2))};
}

}  // namespace crowdbench::scene
