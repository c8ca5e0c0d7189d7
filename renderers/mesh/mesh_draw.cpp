#include "renderers/mesh/mesh_draw.h"

#include <epoxy/gl.h>

#include <algorithm>

#include "core/error.h"
#include "renderers/shaders/bindings.shared.h"
#include "scene/character/alpha_coverage.h"

namespace crowdbench::renderers {
namespace {

// CB_MATERIAL_TEXELS of mesh.frag's `materials`.
struct MaterialRecord {
  float base_colour[3];
  uint32_t part_flags_layer;
  float emissive[3];
  float emissive_layer;
  float alpha_threshold;
  float unused[3];
};
static_assert(sizeof(MaterialRecord) == CB_MATERIAL_TEXELS * 4 * sizeof(float));

// A material's index shares 32 bits with the outfit's, and is kept exactly in a float.
constexpr size_t kMaxMaterials = 4096;
constexpr size_t kMaxLayers = 4096;

unsigned wrap_mode(bool repeat, bool mirrored) {
  return !repeat ? GL_CLAMP_TO_EDGE : mirrored ? GL_MIRRORED_REPEAT : GL_REPEAT;
}

unsigned min_filter(scene::MinFilter filter) {
  switch (filter) {
    case scene::MinFilter::nearest: return GL_NEAREST;
    case scene::MinFilter::linear: return GL_LINEAR;
    case scene::MinFilter::nearest_mipmap_nearest: return GL_NEAREST_MIPMAP_NEAREST;
    case scene::MinFilter::linear_mipmap_nearest: return GL_LINEAR_MIPMAP_NEAREST;
    case scene::MinFilter::nearest_mipmap_linear: return GL_NEAREST_MIPMAP_LINEAR;
    case scene::MinFilter::linear_mipmap_linear: break;
  }
  return GL_LINEAR_MIPMAP_LINEAR;
}

// The vertices of every pose, in the order of `data`.
std::vector<PosedVertex> pose_vertices(const MeshData& data, const scene::Character& character,
                                       std::span<const std::vector<scene::Mat3x4>> poses) {
  std::vector<PosedVertex> out;
  out.reserve(poses.size() * data.vertices.size());
  MeshData posed = data;
  for (const std::vector<scene::Mat3x4>& palette : poses) {
    bake_static_pose(posed, character, palette);
    for (const MeshVertex& v : posed.vertices)
      out.push_back({{v.position[0], v.position[1], v.position[2]}, v.material, v.normal});
  }
  return out;
}

std::vector<RestVertex> rest_vertices(const MeshData& data) {
  std::vector<RestVertex> out;
  out.reserve(data.vertices.size());
  for (const MeshVertex& v : data.vertices) {
    RestVertex& rest = out.emplace_back();
    std::copy_n(v.position, 3, rest.position);
    rest.normal = v.normal;
    std::copy_n(v.joints, 4, rest.joints);
    std::copy_n(v.weights, 4, rest.weights);
  }
  return out;
}

bool samples_between_texels(scene::MinFilter filter) {
  return filter == scene::MinFilter::linear_mipmap_linear || filter == scene::MinFilter::linear_mipmap_nearest;
}

// The alpha of every layer of a level, whose RGBA texels `rgba` receives.
std::vector<scene::AlphaLevel> read_alpha(const gl::Texture& texture, int level, size_t layers,
                                          std::vector<uint8_t>& rgba) {
  scene::AlphaLevel one{std::max(texture.width() >> level, 1), std::max(texture.height() >> level, 1), {}};
  const size_t texels = static_cast<size_t>(one.width) * static_cast<size_t>(one.height);
  rgba.resize(texels * 4 * layers);
  texture.read(level, GL_RGBA, GL_UNSIGNED_BYTE, rgba.data(), rgba.size());
  std::vector<scene::AlphaLevel> out(layers, one);
  for (size_t i = 0; i < texels * layers; ++i) out[i / texels].alpha.push_back(rgba[i * 4 + 3]);
  return out;
}

// Averaged alpha leaves thin strands below the cutoff, and of regular patterns all or nothing: every level of a masked
// layer covers as much as the first, and the levels end where one cannot.
void keep_coverage(const gl::Texture& texture, const MeshTextureArray& array) {
  const size_t layers = array.images.size();
  const scene::Texture& sampling = array.sampling;
  const scene::AlphaSampling far{samples_between_texels(sampling.min_filter), sampling.repeat_u, sampling.repeat_v};
  const scene::AlphaSampling near{!sampling.nearest, sampling.repeat_u, sampling.repeat_v};
  const auto tested = [&](size_t layer) { return array.cutoffs[layer] > 0 && array.cutoffs[layer] <= 1; };
  std::vector<scene::CoverageKeeper> keepers;
  for (int level = 0; level < texture.levels(); ++level) {
    std::vector<uint8_t> rgba;
    std::vector<scene::AlphaLevel> alpha = read_alpha(texture, level, layers, rgba);
    const size_t texels = alpha.front().alpha.size();
    for (size_t layer = 0; layer < layers; ++layer) {
      if (level == 0) keepers.emplace_back(alpha[layer], array.cutoffs[layer], near, far);
      if (level == 0 || !tested(layer)) continue;
      if (!keepers[layer].keep(alpha[layer])) {
        glTextureParameteri(texture.name(), GL_TEXTURE_MAX_LEVEL, level - 1);
        return;
      }
      const std::span<uint8_t> own = std::span(rgba).subspan(layer * texels * 4, texels * 4);
      for (size_t i = 0; i < texels; ++i) own[i * 4 + 3] = alpha[layer].alpha[i];
      texture.write(level, static_cast<int>(layer), GL_RGBA, GL_UNSIGNED_BYTE, own.data());
    }
  }
}

}  // namespace

CharacterMesh upload_mesh(gl::Context& context, const scene::Character& character, int joints, MeshUse use,
                          std::span<const std::vector<scene::Mat3x4>> poses, float peak) {
  if (character.materials.size() > kMaxMaterials)
    throw Error(character.name, fmt::format("{} materials; {} is the most", character.materials.size(), kMaxMaterials),
                "merge materials");
  if (character.images.size() > kMaxLayers)
    throw Error(character.name, fmt::format("{} images; {} is the most", character.images.size(), kMaxLayers),
                "merge images");
  MeshData data = make_mesh_data(character);
  if (use == MeshUse::static_pose) bake_static_pose(data, character, poses[0]);

  CharacterMesh out;
  out.joints = static_cast<uint32_t>(joints);
  out.vertex_count = static_cast<uint32_t>(data.vertices.size());
  out.triangles = data.indices.size() / 3;
  out.groups = data.groups;
  out.has_flat = data.has_flat;
  if (data.indices.empty()) return out;
  out.indices = gl::Buffer(context, data.indices);
  const auto add_stream = [&](gl::Buffer& buffer, unsigned location, int components, size_t stride, const void* from) {
    buffer = gl::Buffer(context, data.vertices.size() * stride, from);
    out.vertex_array.add_stream(location, buffer, components, static_cast<int>(stride));
  };
  if (use == MeshUse::stored_poses) {
    using V = PosedVertex;
    const std::vector<V> posed = pose_vertices(data, character, poses);
    out.vertices = gl::Buffer(context, posed);
    const std::vector<gl::Attribute> attributes = {
        {CB_ATTRIBUTE_POSITION, 4, GL_FLOAT, false, false, offsetof(V, position)},
        {CB_ATTRIBUTE_NORMAL, 4, GL_INT_2_10_10_10_REV, true, false, offsetof(V, normal)},
    };
    out.vertex_array = gl::VertexArray(context, out.vertices, sizeof(V), attributes, &out.indices);
    std::vector<glm::vec2> uvs;
    uvs.reserve(data.vertices.size());
    for (const MeshVertex& v : data.vertices) uvs.emplace_back(v.uv[0], v.uv[1]);
    add_stream(out.uvs, CB_ATTRIBUTE_UV, 2, sizeof(glm::vec2), uvs.data());
  } else {
    using V = MeshVertex;
    out.vertices = gl::Buffer(context, data.vertices);
    std::vector<gl::Attribute> attributes = {
        {CB_ATTRIBUTE_POSITION, 4, GL_FLOAT, false, false, offsetof(V, position)},
        {CB_ATTRIBUTE_NORMAL, 4, GL_INT_2_10_10_10_REV, true, false, offsetof(V, normal)},
        {CB_ATTRIBUTE_UV, 2, GL_FLOAT, false, false, offsetof(V, uv)},
    };
    if (use == MeshUse::skinned || use == MeshUse::cached_poses || use == MeshUse::capture) {
      attributes.push_back({CB_ATTRIBUTE_JOINTS, 4, GL_UNSIGNED_SHORT, false, true, offsetof(V, joints)});
      attributes.push_back({CB_ATTRIBUTE_WEIGHTS, 4, GL_UNSIGNED_SHORT, true, false, offsetof(V, weights)});
    }
    out.vertex_array = gl::VertexArray(context, out.vertices, sizeof(V), attributes, &out.indices);
  }
  if (use == MeshUse::preskinned || use == MeshUse::shared_pose || use == MeshUse::cached_poses) {
    out.rest = gl::Buffer(context, rest_vertices(data));
    out.rest_texels = gl::Texture::make_buffer(context, GL_RGBA32UI, out.rest);
  }
  if (!data.extras.colours.empty()) {
    add_stream(out.colours, CB_ATTRIBUTE_COLOUR, 4, sizeof(glm::vec4), data.extras.colours.data());
    out.has_colours = true;
  }
  if (!data.extras.emissive_uvs.empty()) {
    add_stream(out.emissive_uvs, CB_ATTRIBUTE_EMISSIVE_UV, 2, sizeof(glm::vec2), data.extras.emissive_uvs.data());
    out.has_emissive_uvs = true;
  }

  std::vector<MaterialRecord> materials;
  out.has_emissive = use == MeshUse::capture && peak > 0;
  for (size_t m = 0; m < character.materials.size(); ++m) {
    const scene::Material& material = character.materials[m];
    uint32_t flags = 0;
    if (material.unlit) flags |= CB_MATERIAL_UNLIT;
    if (material.base_colour_image >= 0) flags |= CB_MATERIAL_TEXTURE;
    if (material.emissive_image >= 0) flags |= CB_MATERIAL_EMISSIVE_TEXTURE;
    const glm::vec4& base = material.base_colour;
    glm::vec3 glow = material.emissive;
    if (use == MeshUse::capture)
      glow = peak > 0 && !material.unlit ? glow / peak : glm::vec3(0.0F);
    else
      out.has_emissive = out.has_emissive || glow != glm::vec3(0.0F);
    materials.push_back({{base.r, base.g, base.b},
                         material.slot | flags << 8U | static_cast<uint32_t>(data.material_layer[m]) << 16U,
                         {glow.r, glow.g, glow.b},
                         static_cast<float>(data.material_emissive_layer[m]),
                         scene::alpha_threshold(material),
                         {}});
  }
  out.materials = gl::Buffer(context, materials);
  out.material_texels = gl::Texture::make_buffer(context, GL_RGBA32F, out.materials);

  for (const MeshTextureArray& array : data.arrays) {
    gl::Texture texture = gl::Texture::make_array(context, GL_SRGB8_ALPHA8, array.width, array.height,
                                                  static_cast<int>(array.images.size()));
    for (size_t layer = 0; layer < array.images.size(); ++layer)
      texture.write(0, static_cast<int>(layer), GL_RGBA, GL_UNSIGNED_BYTE,
                    character.images[static_cast<size_t>(array.images[layer])].image.data.data());
    texture.generate_mipmaps();
    if (array.masked) keep_coverage(texture, array);
    out.textures.push_back(std::move(texture));
    gl::SamplerOptions sampling;
    sampling.wrap_s = wrap_mode(array.sampling.repeat_u, array.sampling.mirrored_u);
    sampling.wrap_t = wrap_mode(array.sampling.repeat_v, array.sampling.mirrored_v);
    sampling.min_filter = min_filter(array.sampling.min_filter);
    if (array.sampling.nearest) sampling.mag_filter = GL_NEAREST;
    out.samplers.emplace_back(context, sampling);
  }
  return out;
}

uint64_t CharacterMesh::texture_bytes() const {
  uint64_t bytes = 0;
  for (const gl::Texture& t : textures) bytes += t.bytes();
  return bytes;
}

uint64_t CharacterMesh::buffer_bytes() const {
  uint64_t bytes = 0;
  for (const gl::Buffer* b : {&vertices, &indices, &uvs, &colours, &emissive_uvs, &materials, &rest})
    bytes += b->size();
  return bytes;
}

const gl::Program& MeshDraw::program(const Variant& v) {
  auto found = programs_.find(v);
  if (found == programs_.end()) {
    gl::Defines defines;
    const auto define = [&](bool on, const char* name) {
      if (on) defines.emplace_back(name, "");
    };
    define(use_ == MeshUse::static_pose || use_ == MeshUse::stored_poses, "CB_STATIC");
    define(use_ == MeshUse::preskinned, "CB_SKINNED");
    define(use_ == MeshUse::shared_pose, "CB_SHARED_POSE");
    define(use_ == MeshUse::cached_poses, "CB_CACHED_POSES");
    define(use_ == MeshUse::tile, "CB_TILE");
    define(use_ == MeshUse::capture, "CB_CAPTURE");
    define(passes_ > 1, "CB_INVARIANT");
    define(v.depth, "CB_DEPTH");
    define(v.ids, "CB_IDS");
    define(v.dithered, "CB_DITHER");
    define(v.colours, "CB_COLOURS");
    define(v.emissive, "CB_EMISSIVE");
    define(v.emissive_uvs, "CB_EMISSIVE_UVS");
    define(v.textures, "CB_TEXTURES");
    define(v.emissive_textures, "CB_EMISSIVE_TEXTURES");
    define(v.double_sided, "CB_DOUBLE_SIDED");
    define(v.flat, "CB_FLAT_NORMALS");
    define(v.masked, "CB_MASKED");
    define(v.sampled, "CB_SAMPLED");
    found = programs_
                .emplace(v, gl::Program(context_,
                                        {"renderers/mesh/mesh.vert",
                                         v.depth ? "renderers/mesh/mesh_depth.frag" : "renderers/mesh/mesh.frag"},
                                        defines))
                .first;
  }
  return found->second;
}

void MeshDraw::draw(const CharacterMesh& mesh, const Pass& pass, const gl::Buffer& list, uint32_t first, uint32_t count,
                    uint32_t pose) {
  if (mesh.groups.empty()) return;
  if (use_ == MeshUse::stored_poses)
    mesh.vertex_array.set_vertices(mesh.vertices, size_t{pose} * mesh.vertex_count * sizeof(PosedVertex),
                                   sizeof(PosedVertex));
  mesh.vertex_array.set_instance_stream(CB_ATTRIBUTE_AGENT, list, first * sizeof(uint32_t));
  mesh.vertex_array.bind();
  mesh.material_texels.bind(CB_TEXTURE_MATERIALS);
  const int before = pass.touched ? 0 : passes_ - 1;
  if (before > 0) {
    glColorMask(GL_FALSE, GL_FALSE, GL_FALSE, GL_FALSE);
    for (int i = 0; i < before; ++i) {
      if (i == 1) glDepthFunc(GL_GEQUAL);
      for (const MeshGroup& group : mesh.groups) draw_group(mesh, group, pass, count, pose, true);
    }
    glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
    glDepthFunc(GL_GEQUAL);
  }
  for (const MeshGroup& group : mesh.groups) draw_group(mesh, group, pass, count, pose, false);
  if (before > 0) glDepthFunc(GL_GREATER);
}

void MeshDraw::draw_group(const CharacterMesh& mesh, const MeshGroup& group, const Pass& pass, uint32_t count,
                          uint32_t slot, bool depth) {
  // What discards fragments needs all of the program to know which.
  const bool bare = depth && !group.masked && !pass.dithered;
  Variant depth_variant;
  depth_variant.depth = true;
  const int emissive_array = mesh.has_emissive ? group.emissive_array : -1;
  const gl::Program& p =
      bare ? program(depth_variant)
           : program({pass.ids, pass.dithered, mesh.has_colours, mesh.has_emissive,
                      mesh.has_emissive_uvs && emissive_array >= 0, group.base_array >= 0, emissive_array >= 0,
                      group.double_sided, mesh.has_flat, group.masked, pass.samples > 1, false});
  p.use();
  if (use_ == MeshUse::skinned || use_ == MeshUse::tile || use_ == MeshUse::capture)
    p.set(CB_LOCATION_JOINTS, mesh.joints);
  if (use_ == MeshUse::preskinned || use_ == MeshUse::shared_pose || use_ == MeshUse::cached_poses)
    p.set(CB_LOCATION_VERTICES, mesh.vertex_count);
  if (use_ == MeshUse::preskinned || use_ == MeshUse::shared_pose) p.set(CB_LOCATION_SLOT, slot);
  const auto bind_array = [&](int array, unsigned unit) {
    if (array < 0) return;
    mesh.textures[static_cast<size_t>(array)].bind(unit);
    mesh.samplers[static_cast<size_t>(array)].bind(unit);
  };
  bind_array(group.base_array, CB_TEXTURE_BASE_COLOUR);
  bind_array(emissive_array, CB_TEXTURE_EMISSIVE);
  if (group.double_sided)
    glDisable(GL_CULL_FACE);
  else
    glEnable(GL_CULL_FACE);
  const bool coverage = group.masked && pass.samples > 1;
  if (coverage) glEnable(GL_SAMPLE_ALPHA_TO_COVERAGE);
  glDrawElementsInstanced(GL_TRIANGLES, static_cast<GLsizei>(group.index_count), GL_UNSIGNED_INT,
                          reinterpret_cast<const void*>(group.first_index * sizeof(uint32_t)),
                          static_cast<GLsizei>(count));
  if (coverage) glDisable(GL_SAMPLE_ALPHA_TO_COVERAGE);
}

void MeshDraw::done() {
  glDisable(GL_CULL_FACE);
  for (const unsigned unit : {CB_TEXTURE_BASE_COLOUR, CB_TEXTURE_EMISSIVE}) glBindSampler(unit, 0);
}

}  // namespace crowdbench::renderers
