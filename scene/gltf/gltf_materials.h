// The materials of a glTF asset and the pictures on them. Internal to the loader.
#pragma once
#include <array>
#include <cstddef>
#include <map>
#include <vector>

#include "scene/gltf/gltf_asset.h"

namespace crowdbench::scene {

class GltfMaterials {
 public:
  // Reads all materials into the character. used: by material, whether anything is drawn with it; the pictures of those
  // are decoded, once for each combination of wrap modes and filters. asset must outlive this. Throws Error: a picture
  // that is broken or beyond the limits.
  GltfMaterials(GltfAsset& asset, const std::vector<bool>& used);

  // Of a material of the character.
  const UvSource& base_uv(int material) const { return base_uv_[index_of(material)]; }
  const UvSource& emissive_uv(int material) const { return emissive_uv_[index_of(material)]; }
  // The white material of primitives that name none, added at the first call.
  int default_material();

 private:
  // Index into Character::images; -1 without image.
  int texture(int index);
  // Of an image of the file, decoded at the first call.
  Image8 picture(int image);
  Image8 decode(const GltfImage& image);
  // Before memory is spent on so many bytes of a picture: all together keep the limit, else Error.
  void spend(size_t bytes, const std::string& where, int width, int height);

  GltfAsset& asset_;
  std::vector<UvSource> base_uv_, emissive_uv_;
  std::map<std::array<int, 5>, int> texture_index_;  // by image, wrap modes and filters
  std::map<int, int> decoded_;                       // by image: the first texture of it
  size_t decoded_bytes_ = 0;
  int default_material_ = -1;
};

}  // namespace crowdbench::scene
