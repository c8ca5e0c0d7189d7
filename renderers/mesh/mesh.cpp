#include "renderers/mesh/mesh.h"

#include <epoxy/gl.h>

#include <cassert>
#include <map>

#include "core/error.h"
#include "renderers/frame_resources.h"
#include "renderers/gl/objects.h"
#include "renderers/gl/program.h"
#include "renderers/mesh/mesh_data.h"
#include "renderers/shaders/bindings.shared.h"

namespace crowdbench::renderers {
namespace {

// Two texels of mesh.frag's `materials`.
struct MaterialRecord {
  float base_colour[3];
  uint32_t part_flags_layer;
  float emissive[3];
  float emissive_layer;
};

// A material's index shares 32 bits with the outfit's, and is kept exactly in a float.
constexpr size_t kMaxMaterials = 4096;
constexpr size_t kMaxLayers = 4096;

// One character's mesh on the GPU.
struct CharacterMesh {
  gl::Buffer vertices, indices, colours, emissive_uvs, materials;
  gl::VertexArray vertex_array;
  std::vector<gl::Texture> textures;  // one a MeshData::arrays entry
  std::vector<gl::Sampler> samplers;
  gl::Texture material_texels;
  std::vector<MeshGroup> groups;
  uint32_t joints = 0;
  uint64_t triangles = 0;
  bool has_colours = false, has_emissive_uvs = false, has_emissive = false;
};

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

CharacterMesh upload(gl::Context& context, const scene::Character& character, const scene::PoseBank& bank,
                     bool static_pose) {
  if (character.materials.size() > kMaxMaterials)
    throw Error(character.name, fmt::format("{} materials; {} is the most", character.materials.size(), kMaxMaterials),
                "merge materials");
  if (character.images.size() > kMaxLayers)
    throw Error(character.name, fmt::format("{} images; {} is the most", character.images.size(), kMaxLayers),
                "merge images");
  MeshData data = make_mesh_data(character);
  if (static_pose) bake_static_pose(data, character, bank.palette(bank.sample(0, 0.0)));

  CharacterMesh out;
  out.joints = static_cast<uint32_t>(bank.joints());
  out.triangles = data.indices.size() / 3;
  out.groups = data.groups;
  if (data.indices.empty()) return out;
  out.vertices = gl::Buffer(context, data.vertices);
  out.indices = gl::Buffer(context, data.indices);
  using V = MeshVertex;
  std::vector<gl::Attribute> attributes = {
      {CB_ATTRIBUTE_POSITION, 4, GL_FLOAT, false, false, offsetof(V, position)},
      {CB_ATTRIBUTE_NORMAL, 4, GL_INT_2_10_10_10_REV, true, false, offsetof(V, normal)},
      {CB_ATTRIBUTE_UV, 2, GL_FLOAT, false, false, offsetof(V, uv)},
  };
  if (!static_pose) {
    attributes.push_back({CB_ATTRIBUTE_JOINTS, 4, GL_UNSIGNED_SHORT, false, true, offsetof(V, joints)});
    attributes.push_back({CB_ATTRIBUTE_WEIGHTS, 4, GL_UNSIGNED_SHORT, true, false, offsetof(V, weights)});
  }
  out.vertex_array = gl::VertexArray(context, out.vertices, sizeof(V), attributes, &out.indices);
  const auto add_stream = [&](gl::Buffer& buffer, unsigned location, int components, size_t stride, const void* from) {
    buffer = gl::Buffer(context, data.vertices.size() * stride, from);
    out.vertex_array.add_stream(location, buffer, components, static_cast<int>(stride));
  };
  if (!data.extras.colours.empty()) {
    add_stream(out.colours, CB_ATTRIBUTE_COLOUR, 4, sizeof(glm::vec4), data.extras.colours.data());
    out.has_colours = true;
  }
  if (!data.extras.emissive_uvs.empty()) {
    add_stream(out.emissive_uvs, CB_ATTRIBUTE_EMISSIVE_UV, 2, sizeof(glm::vec2), data.extras.emissive_uvs.data());
    out.has_emissive_uvs = true;
  }

  std::vector<MaterialRecord> materials;
  for (size_t m = 0; m < character.materials.size(); ++m) {
    const scene::Material& material = character.materials[m];
    uint32_t flags = 0;
    if (material.unlit) flags |= CB_MATERIAL_UNLIT;
    if (material.base_colour_image >= 0) flags |= CB_MATERIAL_TEXTURE;
    if (material.emissive_image >= 0) flags |= CB_MATERIAL_EMISSIVE_TEXTURE;
    const glm::vec4& base = material.base_colour;
    const glm::vec3& glow = material.emissive;
    out.has_emissive = out.has_emissive || glow != glm::vec3(0.0F);
    materials.push_back({{base.r, base.g, base.b},
                         material.part | flags << 8U | static_cast<uint32_t>(data.material_layer[m]) << 16U,
                         {glow.r, glow.g, glow.b},
                         static_cast<float>(data.material_emissive_layer[m])});
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

// What a compiled variant of the program depends on.
struct Variant {
  bool ids, dithered, colours, emissive, emissive_uvs, textures, emissive_textures, double_sided;
  auto operator<=>(const Variant&) const = default;
};

// What is drawn: the mesh, its floor (a static pose), or the maps that bakes are made of.
enum class Use : uint8_t { picture, floor, capture };

class MeshRepresentation : public Representation {
 public:
  MeshRepresentation(const MakeContext& make, Use use)
      : context_(make.context), floor_(use == Use::floor), capture_(use == Use::capture) {
    for (size_t c = 0; c < make.cast.characters.size(); ++c)
      meshes_.push_back(upload(context_, *make.cast.characters[c], *make.cast.banks[c], floor_));
  }

  void draw(const scene::Frame&, const FrameResources& resources, const AgentLists& agents, const Pass& pass) override {
    for (size_t c = 0; c < meshes_.size(); ++c) {
      const CharacterMesh& mesh = meshes_[c];
      if (mesh.groups.empty()) continue;
      if (floor_)
        resources.draw_listed(c, agents[c],
                              [&](uint32_t count) { draw_groups(mesh, pass, resources.list(), 0, count); });
      else
        resources.draw_posed(c, agents[c], [&](uint32_t first, uint32_t count) {
          draw_groups(mesh, pass, resources.list(), first, count);
        });
    }
    glDisable(GL_CULL_FACE);
    for (const unsigned unit : {CB_TEXTURE_BASE_COLOUR, CB_TEXTURE_EMISSIVE}) glBindSampler(unit, 0);
  }

  Footprint footprint() const override {
    Footprint out;
    for (const CharacterMesh& m : meshes_) {
      for (const gl::Texture& t : m.textures) out.texture_bytes += t.bytes();
      for (const gl::Buffer* b : {&m.vertices, &m.indices, &m.colours, &m.emissive_uvs, &m.materials})
        out.buffer_bytes += b->size();
    }
    return out;
  }

  uint64_t triangles(size_t character) const override { return meshes_[character].triangles; }

 private:
  const gl::Program& program(const Variant& v) {
    auto found = programs_.find(v);
    if (found == programs_.end()) {
      gl::Defines defines;
      const auto define = [&](bool on, const char* name) {
        if (on) defines.emplace_back(name, "");
      };
      define(floor_, "CB_STATIC");
      define(capture_, "CB_CAPTURE");
      define(v.ids, "CB_IDS");
      define(v.dithered, "CB_DITHER");
      define(v.colours, "CB_COLOURS");
      define(v.emissive, "CB_EMISSIVE");
      define(v.emissive_uvs, "CB_EMISSIVE_UVS");
      define(v.textures, "CB_TEXTURES");
      define(v.emissive_textures, "CB_EMISSIVE_TEXTURES");
      define(v.double_sided, "CB_DOUBLE_SIDED");
      found =
          programs_.emplace(v, gl::Program(context_, {"renderers/mesh/mesh.vert", "renderers/mesh/mesh.frag"}, defines))
              .first;
    }
    return found->second;
  }

  void draw_groups(const CharacterMesh& mesh, const Pass& pass, const gl::Buffer& list, uint32_t first,
                   uint32_t count) {
    mesh.vertex_array.set_instance_stream(CB_ATTRIBUTE_AGENT, list, first * sizeof(uint32_t));
    mesh.vertex_array.bind();
    mesh.material_texels.bind(CB_TEXTURE_MATERIALS);
    for (const MeshGroup& group : mesh.groups) {
      const gl::Program& p = program({pass.ids, pass.dithered, mesh.has_colours, mesh.has_emissive,
                                      mesh.has_emissive_uvs && group.emissive_array >= 0, group.base_array >= 0,
                                      group.emissive_array >= 0, group.double_sided});
      p.use();
      if (!floor_) p.set(CB_LOCATION_JOINTS, mesh.joints);
      const auto bind_array = [&](int array, unsigned unit) {
        if (array < 0) return;
        mesh.textures[static_cast<size_t>(array)].bind(unit);
        mesh.samplers[static_cast<size_t>(array)].bind(unit);
      };
      bind_array(group.base_array, CB_TEXTURE_BASE_COLOUR);
      bind_array(group.emissive_array, CB_TEXTURE_EMISSIVE);
      if (group.double_sided)
        glDisable(GL_CULL_FACE);
      else
        glEnable(GL_CULL_FACE);
      glDrawElementsInstanced(GL_TRIANGLES, static_cast<GLsizei>(group.index_count), GL_UNSIGNED_INT,
                              reinterpret_cast<const void*>(group.first_index * sizeof(uint32_t)),
                              static_cast<GLsizei>(count));
    }
  }

  gl::Context& context_;
  bool floor_;
  bool capture_;
  std::vector<CharacterMesh> meshes_;
  std::map<Variant, gl::Program> programs_;
};

}  // namespace

std::unique_ptr<Representation> make_mesh_capture(const MakeContext& make) {
  return std::make_unique<MeshRepresentation>(make, Use::capture);
}

const RepresentationType mesh_type = {
    "mesh",
    "the reference: the skinned mesh, posed on the GPU, instanced",
    {},
    [](const MakeContext& context, const Spec& spec) -> std::unique_ptr<Representation> {
      return std::make_unique<MeshRepresentation>(
          context, OptionReader(mesh_type, spec).flag("floor") ? Use::floor : Use::picture);
    }};

}  // namespace crowdbench::renderers
