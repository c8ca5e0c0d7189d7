// Which joints move the vertices of a glTF asset, and how much. Internal to the loader.
#pragma once
#include <cstddef>
#include <cstdint>
#include <vector>

#include "scene/gltf/gltf_asset.h"

namespace crowdbench::scene {

class GltfWeights {
 public:
  // asset must outlive this.
  explicit GltfWeights(GltfAsset& asset) : asset_(asset) {}

  // Adds to Mesh::joints and weights what the primitive says of these of its vertices: the kInfluences largest, whose
  // sum is 1 again. first: where its skin's joints begin in the
  // character's palette; joints: how many it has. Throws Error on a joint that the skin lacks
  // and on weights that are negative or not finite.
  void read(const GltfPrimitive& primitive, const std::vector<uint32_t>& vertices, int first, int joints);
  // Warns of what had to be changed.
  void report();

 private:
  struct Influence {
    int joint = 0;
    double weight = 0;
  };
  // Adds one influence (a joint named twice is one influence) and returns its weight.
  double gather(const AccessorView& joints, const AccessorView& weights, size_t v, int c, int palette_size,
                std::vector<Influence>& all) const;

  GltfAsset& asset_;
  size_t without_ = 0, scaled_ = 0, reduced_ = 0;  // vertices
  double lost_ = 0, worst_lost_ = 0;               // shares of weight
};

}  // namespace crowdbench::scene
