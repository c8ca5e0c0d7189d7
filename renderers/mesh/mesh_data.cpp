// Based on: P. Sander, D. Nehab and J. Barczak, "Fast triangle reordering for vertex locality and reduced overdraw"
// (2007), and T. Forsyth, "Linear-speed vertex cache optimisation" (2006), both as meshoptimizer implements them.
#include "renderers/mesh/mesh_data.h"

#include <meshoptimizer.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <tuple>

#include "scene/character/alpha_coverage.h"

namespace crowdbench::renderers {
namespace {

using ArrayKey = std::tuple<int, int, bool, bool, bool, bool, bool, scene::MinFilter, bool>;
ArrayKey key_of(const scene::Texture& t, bool masked) {
  return {t.image.width, t.image.height, t.repeat_u,   t.repeat_v, t.mirrored_u,
          t.mirrored_v,  t.nearest,      t.min_filter, masked};
}

// Array and layer of every image that a material uses as base colour or as emissive colour.
struct Placed {
  int array = -1;
  int layer = 0;
};
std::vector<Placed> place_images(const scene::Character& character, std::vector<MeshTextureArray>& arrays) {
  std::vector<Placed> placed(character.images.size());
  std::map<ArrayKey, int> found;
  std::vector<float> cutoffs(character.images.size(), 0.0F);
  for (const scene::Material& m : character.materials)
    if (m.base_colour_image >= 0) {
      float& own = cutoffs[static_cast<size_t>(m.base_colour_image)];
      own = std::max(own, scene::alpha_threshold(m));
    }
  const auto place = [&](int image) {
    if (image < 0 || placed[static_cast<size_t>(image)].array >= 0) return;
    const scene::Texture& texture = character.images[static_cast<size_t>(image)];
    if (texture.image.empty()) return;
    const float cutoff = cutoffs[static_cast<size_t>(image)];
    const auto [it, fresh] = found.try_emplace(key_of(texture, cutoff > 0), static_cast<int>(arrays.size()));
    if (fresh) {
      MeshTextureArray array;
      array.width = texture.image.width;
      array.height = texture.image.height;
      array.sampling = texture;
      array.sampling.image = {};
      array.masked = cutoff > 0;
      arrays.push_back(std::move(array));
    }
    MeshTextureArray& array = arrays[static_cast<size_t>(it->second)];
    placed[static_cast<size_t>(image)] = {it->second, static_cast<int>(array.images.size())};
    array.images.push_back(image);
    array.cutoffs.push_back(cutoff);
  };
  for (const scene::Material& m : character.materials) {
    place(m.base_colour_image);
    place(m.emissive_image);
  }
  return placed;
}

void pack_weights(const glm::vec4& weights, uint16_t out[4]) {
  int sum = 0;
  int largest = 0;
  int values[4];
  for (int i = 0; i < 4; ++i) {
    values[i] = static_cast<int>(std::lround(std::clamp(weights[i], 0.0F, 1.0F) * 65535.0F));
    sum += values[i];
    if (values[i] > values[largest]) largest = i;
  }
  values[largest] += 65535 - sum;
  for (int i = 0; i < 4; ++i) out[i] = static_cast<uint16_t>(values[i]);
}

}  // namespace

uint32_t pack_normal(const glm::vec3& normal, bool flat) {
  uint32_t packed = flat ? 1U << 30U : 0U;
  for (int i = 0; i < 3; ++i) {
    const auto value = static_cast<int32_t>(std::lround(std::clamp(normal[i], -1.0F, 1.0F) * 511.0F));
    packed |= (static_cast<uint32_t>(value) & 0x3ffU) << (10 * i);
  }
  return packed;
}

glm::vec3 unpack_normal(uint32_t packed) {
  glm::vec3 normal;
  for (int i = 0; i < 3; ++i) {
    const auto field = static_cast<int32_t>((packed >> (10 * i)) & 0x3ffU);
    const int32_t value = field >= 512 ? field - 1024 : field;
    normal[i] = std::max(static_cast<float>(value) / 511.0F, -1.0F);
  }
  return normal;
}

namespace {

// What a group of triangles that one call draws has in common; -1: no image, so any array.
struct GroupNeed {
  int base, emissive;
  bool double_sided, masked;
};

// The groups that a character's primitives need: materials with images fix their arrays; those without join any group
// of their culling.
class Groups {
 public:
  std::vector<uint32_t>& indices_for(const GroupNeed& need) {
    for (size_t g = 0; g < needs_.size(); ++g) {
      GroupNeed& have = needs_[g];
      const bool base_fits = need.base < 0 || have.base < 0 || need.base == have.base;
      const bool emissive_fits = need.emissive < 0 || have.emissive < 0 || need.emissive == have.emissive;
      if (have.double_sided != need.double_sided || have.masked != need.masked || !base_fits || !emissive_fits)
        continue;
      have.base = std::max(have.base, need.base);
      have.emissive = std::max(have.emissive, need.emissive);
      return indices_[g];
    }
    needs_.push_back(need);
    return indices_.emplace_back();
  }

  void append_to(MeshData& data, size_t vertices) {
    for (size_t g = 0; g < needs_.size(); ++g) {
      std::vector<uint32_t>& indices = indices_[g];
      if (indices.empty()) continue;
      meshopt_optimizeVertexCache(indices.data(), indices.data(), indices.size(), vertices);
      MeshGroup group;
      group.first_index = static_cast<uint32_t>(data.indices.size());
      group.index_count = static_cast<uint32_t>(indices.size());
      group.base_array = needs_[g].base;
      group.emissive_array = needs_[g].emissive;
      group.double_sided = needs_[g].double_sided;
      group.masked = needs_[g].masked;
      data.groups.push_back(group);
      data.indices.insert(data.indices.end(), indices.begin(), indices.end());
    }
  }

 private:
  std::vector<GroupNeed> needs_;
  std::vector<std::vector<uint32_t>> indices_;
};

void append_triangles(const scene::Mesh& mesh, const scene::Primitive& primitive, std::vector<uint32_t>& indices) {
  for (uint32_t i = 0; i + 2 < primitive.index_count; i += 3) {
    const uint32_t a = mesh.indices[primitive.first_index + i];
    uint32_t b = mesh.indices[primitive.first_index + i + 1];
    uint32_t c = mesh.indices[primitive.first_index + i + 2];
    if (primitive.mirrored) std::swap(b, c);
    indices.insert(indices.end(), {a, b, c});
  }
}

// Vertices in the order of first use; those that no triangle uses are dropped.
void write_vertices(const scene::Mesh& mesh, MeshData& data) {
  // A vertex shared by primitives of different materials would need two records; the loader never makes one, because a
  // primitive has its own run of vertices.
  std::vector<const scene::Primitive*> primitive_of(mesh.positions.size(), nullptr);
  for (const scene::Primitive& p : mesh.primitives)
    std::fill_n(primitive_of.begin() + p.first_vertex, p.vertex_count, &p);
  std::vector<unsigned> remap(mesh.positions.size());
  const size_t used =
      meshopt_optimizeVertexFetchRemap(remap.data(), data.indices.data(), data.indices.size(), mesh.positions.size());
  meshopt_remapIndexBuffer(data.indices.data(), data.indices.data(), data.indices.size(), remap.data());
  data.vertices.resize(used);
  data.source_vertex.resize(used);
  if (!mesh.colours.empty()) data.extras.colours.resize(used);
  if (!mesh.emissive_uvs.empty()) data.extras.emissive_uvs.resize(used);
  for (size_t source = 0; source < remap.size(); ++source) {
    if (remap[source] == ~0U) continue;
    const size_t to = remap[source];
    const scene::Primitive& primitive = *primitive_of[source];
    data.source_vertex[to] = static_cast<uint32_t>(source);
    MeshVertex& v = data.vertices[to];
    for (int i = 0; i < 3; ++i) v.position[i] = mesh.positions[source][i];
    v.material = static_cast<float>(primitive.material);
    v.normal = pack_normal(mesh.normals[source], primitive.flat);
    v.uv[0] = mesh.uvs.empty() ? 0.0F : mesh.uvs[source].x;
    v.uv[1] = mesh.uvs.empty() ? 0.0F : mesh.uvs[source].y;
    for (int i = 0; i < 4; ++i) v.joints[i] = mesh.joints[source][i];
    pack_weights(mesh.weights[source], v.weights);
    if (!data.extras.colours.empty()) data.extras.colours[to] = mesh.colours[source];
    if (!data.extras.emissive_uvs.empty()) data.extras.emissive_uvs[to] = mesh.emissive_uvs[source];
  }
}

}  // namespace

MeshData make_mesh_data(const scene::Character& character) {
  const scene::Mesh& mesh = character.mesh;
  MeshData data;
  const std::vector<Placed> placed = place_images(character, data.arrays);
  const auto placed_of = [&](int image) { return image >= 0 ? placed[static_cast<size_t>(image)] : Placed{}; };
  for (const scene::Material& m : character.materials) {
    data.material_layer.push_back(placed_of(m.base_colour_image).layer);
    data.material_emissive_layer.push_back(placed_of(m.emissive_image).layer);
  }
  Groups groups;
  for (const scene::Primitive& p : mesh.primitives) {
    const scene::Material& m = character.materials[static_cast<size_t>(p.material)];
    append_triangles(mesh, p,
                     groups.indices_for({placed_of(m.base_colour_image).array, placed_of(m.emissive_image).array,
                                         m.double_sided, m.alpha_cutoff > 0}));
    data.has_flat = data.has_flat || p.flat;
  }
  groups.append_to(data, mesh.positions.size());
  write_vertices(mesh, data);
  return data;
}

void bake_static_pose(MeshData& data, const scene::Character& character, const std::vector<scene::Mat3x4>& palette) {
  const scene::Mesh& mesh = character.mesh;
  for (size_t i = 0; i < data.vertices.size(); ++i) {
    const size_t source = data.source_vertex[i];
    glm::vec4 rows[3] = {glm::vec4(0.0F), glm::vec4(0.0F), glm::vec4(0.0F)};
    for (int k = 0; k < scene::kInfluences; ++k)
      for (int r = 0; r < 3; ++r) rows[r] += mesh.weights[source][k] * palette[mesh.joints[source][k]].rows[r];
    glm::vec3 normal;
    for (int r = 0; r < 3; ++r) {
      data.vertices[i].position[r] = glm::dot(rows[r], glm::vec4(mesh.positions[source], 1.0F));
      normal[r] = glm::dot(glm::vec3(rows[r]), mesh.normals[source]);
    }
    const float length = glm::length(normal);
    const bool flat = (data.vertices[i].normal >> 30U) != 0;
    data.vertices[i].normal = pack_normal(length > 0 ? normal / length : glm::vec3(0.0F, 1.0F, 0.0F), flat);
  }
}

}  // namespace crowdbench::renderers
