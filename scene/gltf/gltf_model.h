// What the loader uses of a glTF document, each member of a checked type and range. Internal to the loader.
//
// Indices are the file's, -1 where there is none; what the file leaves out has the specification's default.
#pragma once
#include <glm/glm.hpp>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "scene/character/character.h"

namespace crowdbench::scene {

// Where a texture's coordinates come from (KHR_texture_transform): TEXCOORD_set, scaled, turned and moved.
struct UvSource {
  int set = 0;
  glm::dvec2 offset{0.0};
  double rotation = 0;  // radians
  glm::dvec2 scale{1.0};
  bool operator==(const UvSource&) const = default;
};

struct GltfTextureUse {
  int texture = -1;
  UvSource uv;
};

struct GltfMaterial {
  std::string name;
  glm::dvec4 base_colour{1.0};  // linear, 0..1
  GltfTextureUse base_colour_texture;
  glm::dvec3 emissive{0.0};  // linear, KHR_materials_emissive_strength applied
  GltfTextureUse emissive_texture;
  double alpha_cutoff = 0;  // 0: opaque
  bool unlit = false;
  bool double_sided = false;
};

enum class GltfWrap : uint8_t { repeat, mirrored, clamp };

struct GltfSampler {
  GltfWrap wrap_u = GltfWrap::repeat;
  GltfWrap wrap_v = GltfWrap::repeat;
  bool nearest = false;  // magnified
  MinFilter min_filter = MinFilter::linear_mipmap_linear;
};

struct GltfTexture {
  int image = -1;
  int sampler = -1;
};

inline constexpr int kGltfTriangles = 4;  // below: points and lines
inline constexpr int kGltfFan = 6;        // between: strips

struct GltfPrimitive {
  std::map<std::string, int> attributes;  // accessors, of what is read: POSITION, NORMAL, COLOR_0, TEXCOORD_0, ...
  int indices = -1;                       // accessor
  int material = -1;
  int mode = kGltfTriangles;
  auto operator<=>(const GltfPrimitive&) const = default;
};

struct GltfSkin {
  std::vector<int> joints;  // nodes, at least one
  int inverse_binds = -1;   // accessor
  int skeleton = -1;        // node
};

struct GltfNode {
  std::string name;
  std::optional<glm::dmat4> matrix;  // affine; then none of the three
  std::optional<glm::dvec3> translation;
  std::optional<glm::dquat> rotation;  // not of length zero, not necessarily one
  std::optional<glm::dvec3> scale;
  int mesh = -1;
  int skin = -1;  // only with a mesh
};

struct GltfCurve {
  int input = -1;   // accessor: seconds
  int output = -1;  // accessor
  Interpolation interpolation = Interpolation::linear;
};

struct GltfChannel {
  int node = 0;
  Target target = Target::translation;
  GltfCurve curve;
};

struct GltfAnimation {
  std::string name;
  std::vector<GltfChannel> channels;
};

struct GltfModel {
  std::vector<GltfSampler> samplers;
  std::vector<GltfTexture> textures;
  std::vector<GltfMaterial> materials;
  std::vector<std::vector<GltfPrimitive>> meshes;
  std::vector<GltfSkin> skins;
  std::vector<GltfNode> nodes;
  std::vector<GltfAnimation> animations;
};

}  // namespace crowdbench::scene
