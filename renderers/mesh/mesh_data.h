// MeshData: a character's mesh arranged for drawing: vertices interleaved and in cache order, primitives grouped by the
// state that they need.
#pragma once
#include <cstdint>
#include <vector>

#include "scene/character/character.h"
#include "scene/pose/pose_bank.h"

namespace crowdbench::renderers {

// One interleaved vertex of the skinned mesh.
struct MeshVertex {
  float position[3];
  float material;   // index into Character::materials
  uint32_t normal;  // 10:10:10:2 signed normalised; w: 1 where the face's own normal is to be used
  float uv[2];
  uint16_t joints[4];
  uint16_t weights[4];  // unsigned normalised; sums to 65535 exactly
};

// What skinning reads of a vertex, as skin.comp fetches it: two texels of four uints.
struct RestVertex {
  float position[3];
  uint32_t normal;
  uint16_t joints[4];
  uint16_t weights[4];
};
static_assert(sizeof(RestVertex) == 32);

// Vertices that some characters need more of; parallel to the vertices, empty when not needed.
struct MeshExtras {
  std::vector<glm::vec4> colours;
  std::vector<glm::vec2> emissive_uvs;
};

// Triangles that one draw call can take: same texture arrays, same culling, masked or not: the test costs the others
// nothing.
struct MeshGroup {
  uint32_t first_index = 0;
  uint32_t index_count = 0;
  int base_array = -1;  // into MeshData::arrays; -1: none of its materials has a base-colour image
  int emissive_array = -1;
  bool double_sided = false;
  bool masked = false;  // a material of it has a cutoff
};

// Images of one size, sampled alike, all masked or none: one array texture. Masks may end its levels early.
struct MeshTextureArray {
  int width = 0, height = 0;
  scene::Texture sampling;  // wrap and filter flags; its image is empty
  std::vector<int> images;  // into Character::images, one a layer
  bool masked = false;
  std::vector<float> cutoffs;  // one a layer: the alpha at which it is tested; 0: it is not
};

struct MeshData {
  std::vector<MeshVertex> vertices;
  MeshExtras extras;
  std::vector<uint32_t> indices;
  std::vector<MeshGroup> groups;
  bool has_flat = false;  // a primitive is shaded by its faces as posed
  std::vector<MeshTextureArray> arrays;
  std::vector<uint32_t> source_vertex;                       // for each vertex, its index in Character::mesh
  std::vector<int> material_layer, material_emissive_layer;  // by material; 0 when it has no image
};

// Indices are in meshoptimizer's vertex-cache order, vertices in fetch order; mirrored primitives have their winding
// turned, so that counter-clockwise is the front everywhere.
MeshData make_mesh_data(const scene::Character& character);

// Positions and normals posed on the CPU into the vertices: what the floor draws.
void bake_static_pose(MeshData& data, const scene::Character& character, const std::vector<scene::Mat3x4>& palette);

// A unit vector as three signed normalised 10-bit numbers, x in the lowest bits, as GL_INT_2_10_10_10_REV reads them.
uint32_t pack_normal(const glm::vec3& normal, bool flat = false);
glm::vec3 unpack_normal(uint32_t packed);

}  // namespace crowdbench::renderers
