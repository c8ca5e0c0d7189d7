// A checked glTF asset and the character that is made from it, which the steps of loading share. Internal to the
// loader.
#pragma once
#include <cmath>
#include <cstddef>
#include <string>
#include <vector>

#include "scene/character/character.h"
#include "scene/gltf/gltf.h"
#include "scene/gltf/gltf_accessor.h"
#include "scene/gltf/gltf_validate.h"

namespace crowdbench::scene {

// An index from the file, checked by the validation.
inline size_t index_of(int i) { return static_cast<size_t>(i); }

class GltfAsset {
 public:
  // The plan's warnings become the character's. source and options must outlive this.
  GltfAsset(GltfSource& source, GltfPlan plan, const LoadOptions& options);
  GltfAsset(const GltfAsset&) = delete;
  GltfAsset& operator=(const GltfAsset&) = delete;

  [[noreturn]] void fail(const std::string& path, const std::string& wrong, const std::string& advice = {}) const {
    source.fail(path, wrong, advice);
  }
  void warn(std::string text) { character.warnings.push_back(std::move(text)); }

  // An accessor, its sparse indices checked.
  const AccessorView& view_of(int accessor) const;
  // A component of an element: finite and within GltfLimits::magnitude, else Error.
  double finite(const AccessorView& view, size_t i, int c) const {
    const double v = view.at(i, c);
    if (!(std::abs(v) <= limits.magnitude)) fail_beyond(view, i, v);
    return v;
  }
  glm::vec3 finite3(const AccessorView& view, size_t i) const;

  [[noreturn]] void fail_beyond(const AccessorView& view, size_t i, double value) const;

  GltfSource& source;
  GltfPlan plan;
  const LoadOptions& options;
  const GltfLimits& limits;
  Character character;       // what is made
  std::vector<int> node_of;  // index into Skeleton::nodes, by file index
};

}  // namespace crowdbench::scene
