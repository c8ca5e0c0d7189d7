// What the checks of a glTF document share, and the checks. Internal to the loader.
#pragma once
#include <cstddef>
#include <nlohmann/json_fwd.hpp>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "scene/gltf/gltf_document.h"
#include "scene/gltf/gltf_validate.h"

namespace crowdbench::scene {

class GltfData;  // gltf_data.h

// The document as it is read and the plan that is made of it. Every check reads lists of the document's root, throws
// Error at the first fault, and adds what it read to the plan.
class GltfCheck : public GltfDocument {
 public:
  // The arguments must outlive this.
  GltfCheck(GltfSource& source, const GltfLimits& limits);

  void warn(std::string text) { plan.warnings.push_back(std::move(text)); }
  // Warns "path: what", of only the first place where `what` holds. what: a literal.
  void warn_once(const std::string& path, std::string_view what);

  // Before compressed data is decoded: all of it together keeps GltfLimits::decoded_bytes, else Error.
  void spend_decoded(uint64_t bytes, const std::string& path);
  uint64_t decoded_left() const { return decoded_left_; }

  GltfSource& source;
  const GltfLimits& limits;
  GltfPlan plan;

 private:
  std::set<std::string_view> warned_;
  uint64_t decoded_left_;
};
inline constexpr std::string_view kMorphTargets = "morph targets are ignored";

// Images, samplers, textures and materials.
void check_materials(GltfCheck& check, const GltfData& data);

// What drawing a mesh once takes.
struct GltfMeshSize {
  size_t primitives = 0;  // all modes
  size_t vertices = 0;    // of triangles
  size_t triangles = 0;
};
// One for each mesh.
std::vector<GltfMeshSize> check_meshes(GltfCheck& check, const GltfData& data);

// Skins, the hierarchy of nodes, the scene that is shown and whether it keeps the limits. After check_meshes.
void check_nodes(GltfCheck& check, const GltfData& data, const std::vector<GltfMeshSize>& meshes);

// Which nodes stand for one another at different levels of detail (GltfPlan::lod). below: for each node those that
// MSFT_lod names, the next coarser ones in order.
void find_levels(GltfPlan& plan, const std::vector<std::vector<int>>& below, const std::vector<std::string>& names);

void check_animations(GltfCheck& check, const GltfData& data);

}  // namespace crowdbench::scene
