// glTF to Character, after validation.
// Based on: Khronos Group, "glTF 2.0 Specification" (skins 3.7.3, triangle strips and fans 3.7.2.1, instantiation).
// Differs from the source: more than four influences are reduced to the four largest; weights are renormalised.
#include <tiny_gltf.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "core/error.h"
#include "core/files.h"
#include "scene/gltf.h"
#include "scene/gltf_images.h"
#include "scene/gltf_validate.h"
#include "scene/mannequin.h"

namespace crowdbench::scene {
namespace {

// glTF's number (OpenGL's) of a minFilter; what a file leaves out is trilinear.
MinFilter min_filter_of(int filter) {
  switch (filter) {
    case TINYGLTF_TEXTURE_FILTER_NEAREST: return MinFilter::nearest;
    case TINYGLTF_TEXTURE_FILTER_LINEAR: return MinFilter::linear;
    case TINYGLTF_TEXTURE_FILTER_NEAREST_MIPMAP_NEAREST: return MinFilter::nearest_mipmap_nearest;
    case TINYGLTF_TEXTURE_FILTER_LINEAR_MIPMAP_NEAREST: return MinFilter::linear_mipmap_nearest;
    case TINYGLTF_TEXTURE_FILTER_NEAREST_MIPMAP_LINEAR: return MinFilter::nearest_mipmap_linear;
    default: return MinFilter::linear_mipmap_linear;
  }
}

constexpr float kSameNormal = 1.0F - 1e-6F;  // cosine: faces of one plane share their vertices

glm::dvec3 vec3_of(const std::vector<double>& v) { return {v[0], v[1], v[2]}; }

size_t index_of(int i) { return static_cast<size_t>(i); }

class Loader {
 public:
  Loader(GltfSource& source, GltfPlan plan, const LoadOptions& options)
      : source_(source), plan_(std::move(plan)), options_(options), limits_(options.limits) {
    tinygltf::TinyGLTF parser;
    std::string error;
    std::string warning;
    if (!parser.LoadASCIIFromString(&model_, &error, &warning, plan_.json.data(),
                                    static_cast<unsigned>(plan_.json.size()), ""))
      throw Error(source_.where(), "tinygltf refuses it: " + printable(error, 200));
    plan_.json = {};
    character_.warnings = std::move(plan_.warnings);
  }

  Character run() {
    read_nodes();
    find_hidden();
    read_materials();
    read_meshes();
    find_root();
    read_clips();
    finish();
    return std::move(character_);
  }

 private:
  [[noreturn]] void fail(const std::string& path, const std::string& wrong, const std::string& advice = {}) const {
    source_.fail(path, wrong, advice);
  }
  void warn(std::string text) { character_.warnings.push_back(std::move(text)); }

  // --- accessors ---

  AccessorView view_of(int accessor) const {
    const AccessorView& view = plan_.accessors[index_of(accessor)];
    check_sparse(view, source_);
    return view;
  }

  double finite(const AccessorView& view, size_t i, int c) const {
    const double v = view.at(i, c);
    if (!std::isfinite(v) || std::abs(v) > limits_.magnitude)
      fail(view.path, fmt::format("element {} holds {:.6g}, beyond the limit of {}", i, v, limits_.magnitude));
    return v;
  }

  glm::vec3 finite3(const AccessorView& view, size_t i) const {
    return {static_cast<float>(finite(view, i, 0)), static_cast<float>(finite(view, i, 1)),
            static_cast<float>(finite(view, i, 2))};
  }

  // --- nodes ---

  glm::dquat unit_rotation(const std::vector<double>& q, const std::string& path) {
    const glm::dquat r(q[3], q[0], q[1], q[2]);
    const double length = glm::length(r);
    if (std::abs(length - 1.0) > 1e-2) warn(fmt::format("{}: rotation of length {:.3g} is normalised", path, length));
    return glm::normalize(r);
  }

  void read_nodes() {
    node_of_.assign(model_.nodes.size(), -1);
    auto& nodes = character_.skeleton.nodes;
    for (const int file_index : plan_.node_order) {
      const tinygltf::Node& in = model_.nodes[index_of(file_index)];
      const std::string path = fmt::format("/nodes/{}", file_index);
      Node out;
      out.name = in.name;
      const int parent = plan_.node_parent[index_of(file_index)];
      out.parent = parent < 0 ? -1 : node_of_[index_of(parent)];
      if (in.matrix.size() == 16) {
        out.has_matrix = true;
        for (int i = 0; i < 16; ++i) out.matrix[i / 4][i % 4] = in.matrix[index_of(i)];
      }
      if (in.translation.size() == 3) out.translation = vec3_of(in.translation);
      if (in.rotation.size() == 4) out.rotation = unit_rotation(in.rotation, path);
      if (in.scale.size() == 3) out.scale = vec3_of(in.scale);
      node_of_[index_of(file_index)] = static_cast<int>(nodes.size());
      nodes.push_back(std::move(out));
    }
  }

  // The rest transform's linear part is mirrored, parents included.
  bool is_mirrored(int node) const {
    bool mirrored = false;
    for (; node >= 0; node = character_.skeleton.nodes[index_of(node)].parent) {
      const Node& n = character_.skeleton.nodes[index_of(node)];
      const double determinant =
          n.has_matrix ? glm::determinant(glm::dmat3(n.matrix)) : n.scale.x * n.scale.y * n.scale.z;
      if (determinant < 0) mirrored = !mirrored;
    }
    return mirrored;
  }

  void find_hidden() {
    hidden_.assign(model_.nodes.size(), false);
    for (const std::string& name : options_.hide) {
      bool found = false;
      for (size_t i = 0; i < model_.nodes.size(); ++i) {
        if (model_.nodes[i].name != name) continue;
        hidden_[i] = true;
        found = true;
      }
      if (found) continue;
      std::vector<std::string> names;
      for (const tinygltf::Node& node : model_.nodes)
        if (node.mesh >= 0 && !node.name.empty()) names.push_back(node.name);
      const std::string near = nearest_name(name, names);
      std::string listed;
      for (size_t i = 0; i < std::min<size_t>(names.size(), 20); ++i)
        listed += (i ? ", " : "") + printable(names[i], 40);
      throw Error(source_.where(), fmt::format("has no node named {} to hide", printable(name, 60)),
                  near.empty() ? "its meshes are on " + (listed.empty() ? "nodes without names" : listed)
                               : fmt::format("did you mean {}?", printable(near, 60)));
    }
    for (const int node : plan_.node_order) {
      const int parent = plan_.node_parent[index_of(node)];
      if (parent >= 0 && hidden_[index_of(parent)]) hidden_[index_of(node)] = true;
    }
  }

  // --- materials ---

  struct UvSource {
    int set = 0;
    glm::dvec2 offset{0.0};
    double rotation = 0;
    glm::dvec2 scale{1.0};
    bool operator==(const UvSource&) const = default;
  };

  static UvSource uv_source(int tex_coord, const tinygltf::ExtensionMap& extensions) {
    UvSource uv;
    uv.set = std::max(tex_coord, 0);
    const auto found = extensions.find("KHR_texture_transform");
    if (found == extensions.end()) return uv;
    const tinygltf::Value& t = found->second;
    const auto pair = [&](const char* key) {
      return glm::dvec2(t.Get(key).Get(0).GetNumberAsDouble(), t.Get(key).Get(1).GetNumberAsDouble());
    };
    uv.offset = pair("offset");
    uv.rotation = t.Get("rotation").GetNumberAsDouble();
    uv.scale = pair("scale");
    return uv;
  }

  void read_materials() {
    material_used_.assign(model_.materials.size(), false);
    for (size_t i = 0; i < model_.nodes.size(); ++i) {
      if (!draws(i)) continue;
      for (const tinygltf::Primitive& p : model_.meshes[index_of(model_.nodes[i].mesh)].primitives)
        if (p.material >= 0) material_used_[index_of(p.material)] = true;
    }
    for (size_t i = 0; i < model_.materials.size(); ++i) {
      const tinygltf::Material& in = model_.materials[i];
      Material out;
      out.name = in.name;
      out.part = static_cast<uint8_t>(std::min<size_t>(i, 255));
      out.double_sided = in.doubleSided;
      out.unlit = in.extensions.count("KHR_materials_unlit") != 0;
      const auto& pbr = in.pbrMetallicRoughness;
      for (int c = 0; c < 4 && pbr.baseColorFactor.size() == 4; ++c)
        out.base_colour[c] = static_cast<float>(pbr.baseColorFactor[index_of(c)]);
      double strength = 1.0;
      if (const auto found = in.extensions.find("KHR_materials_emissive_strength"); found != in.extensions.end())
        strength = found->second.Get("emissiveStrength").GetNumberAsDouble();
      for (int c = 0; c < 3 && in.emissiveFactor.size() == 3; ++c)
        out.emissive[c] = static_cast<float>(in.emissiveFactor[index_of(c)] * strength);
      if (material_used_[i]) {
        if (pbr.baseColorTexture.index >= 0) out.base_colour_image = texture(pbr.baseColorTexture.index);
        if (in.emissiveTexture.index >= 0 && out.emissive != glm::vec3(0.0F))
          out.emissive_image = texture(in.emissiveTexture.index);
      }
      base_uv_.push_back(uv_source(pbr.baseColorTexture.texCoord, pbr.baseColorTexture.extensions));
      emissive_uv_.push_back(uv_source(in.emissiveTexture.texCoord, in.emissiveTexture.extensions));
      character_.materials.push_back(std::move(out));
    }
  }

  int default_material() {
    if (default_material_ < 0) {
      default_material_ = static_cast<int>(character_.materials.size());
      Material material;
      material.name = "default";
      material.part = static_cast<uint8_t>(std::min(default_material_, 255));
      character_.materials.push_back(material);
      base_uv_.emplace_back();
      emissive_uv_.emplace_back();
    }
    return default_material_;
  }

  // Index into Character::images of a glTF texture, decoded at its first use with these wrap modes; -1 without image.
  int texture(int index) {
    const tinygltf::Texture& in = model_.textures[index_of(index)];
    if (in.source < 0) {
      warn(fmt::format("/textures/{}: has no PNG or JPEG source and is drawn white", index));
      return -1;
    }
    int wrap_s = TINYGLTF_TEXTURE_WRAP_REPEAT;
    int wrap_t = TINYGLTF_TEXTURE_WRAP_REPEAT;
    bool nearest = false;
    MinFilter min_filter = MinFilter::linear_mipmap_linear;
    if (in.sampler >= 0) {
      const tinygltf::Sampler& sampler = model_.samplers[index_of(in.sampler)];
      wrap_s = sampler.wrapS;
      wrap_t = sampler.wrapT;
      nearest = sampler.magFilter == TINYGLTF_TEXTURE_FILTER_NEAREST;
      min_filter = min_filter_of(sampler.minFilter);
    }
    const std::array<int, 5> key = {in.source, wrap_s, wrap_t, nearest ? 1 : 0, static_cast<int>(min_filter)};
    const auto [place, fresh] = texture_index_.emplace(key, static_cast<int>(character_.images.size()));
    if (!fresh) return place->second;
    Texture out;
    out.image = decode(plan_.images[index_of(in.source)]);
    out.repeat_u = wrap_s != TINYGLTF_TEXTURE_WRAP_CLAMP_TO_EDGE;
    out.repeat_v = wrap_t != TINYGLTF_TEXTURE_WRAP_CLAMP_TO_EDGE;
    out.mirrored_u = wrap_s == TINYGLTF_TEXTURE_WRAP_MIRRORED_REPEAT;
    out.mirrored_v = wrap_t == TINYGLTF_TEXTURE_WRAP_MIRRORED_REPEAT;
    out.nearest = nearest;
    out.min_filter = min_filter;
    character_.images.push_back(std::move(out));
    return place->second;
  }

  Image8 decode(const GltfImage& image) {
    std::vector<uint8_t> fetched;
    std::span<const uint8_t> bytes = image.bytes;
    if (!image.uri.empty()) {
      fetched = source_.fetch(image.uri, image.path + "/uri");
      bytes = fetched;
    }
    const std::string where = source_.where() + ": " + image.path;
    const PictureHeader header = picture_header(bytes, where);
    const std::string size = fmt::format("picture is {} x {}", header.width, header.height);
    if (header.width > limits_.image_side || header.height > limits_.image_side)
      throw Error(where, fmt::format("{}, the limit is {} a side", size, limits_.image_side), "use a smaller texture");
    if (header.format == PictureFormat::jpeg && header.pixels() > limits_.jpeg_pixels)
      throw Error(where, fmt::format("{}, the limit for JPEG is {} pixels", size, limits_.jpeg_pixels),
                  "use a smaller texture or a PNG");
    if (header.pixels() * 4 > limits_.image_bytes - decoded_bytes_)
      throw Error(where, fmt::format("{}, which brings all textures above {} bytes", size, limits_.image_bytes),
                  "use smaller textures");
    decoded_bytes_ += header.pixels() * 4;
    return decode_picture(bytes, header, where);
  }

  // --- meshes ---

  bool draws(size_t node) const {
    const tinygltf::Node& n = model_.nodes[node];
    if (n.mesh < 0 || !plan_.in_scene[node] || hidden_[node]) return false;
    return n.skin >= 0 || options_.rigid_meshes || model_.skins.empty();
  }

  void read_meshes() {
    Mesh& mesh = character_.mesh;
    mesh.positions.reserve(plan_.vertices);
    mesh.normals.reserve(plan_.vertices);
    mesh.uvs.reserve(plan_.vertices);
    mesh.joints.reserve(plan_.vertices);
    mesh.weights.reserve(plan_.vertices);
    mesh.indices.reserve(plan_.triangles * 3);
    find_optional_attributes();
    for (size_t i = 0; i < model_.nodes.size(); ++i) {
      if (!draws(i)) continue;
      const tinygltf::Node& node = model_.nodes[i];
      const Palette palette = node.skin >= 0 ? skin_palette(node.skin) : rigid_palette(i);
      const auto& primitives = model_.meshes[index_of(node.mesh)].primitives;
      for (size_t p = 0; p < primitives.size(); ++p)
        read_primitive(primitives[p], fmt::format("/meshes/{}/primitives/{}", node.mesh, p), i, palette);
    }
    if (mesh.indices.empty()) {
      std::string reason = "has no triangles to draw";
      if (!options_.hide.empty()) reason += " once parts are hidden";
      throw Error(source_.where(), reason, model_.meshes.empty() ? "it holds no mesh" : "see its scene and its meshes");
    }
    if (mesh.file_vertices.size() == mesh.positions.size()) mesh.file_vertices.clear();
    report_weights();
  }

  // Arrays that all primitives or none have.
  void find_optional_attributes() {
    for (size_t i = 0; i < model_.nodes.size(); ++i) {
      if (!draws(i)) continue;
      for (const tinygltf::Primitive& p : model_.meshes[index_of(model_.nodes[i].mesh)].primitives) {
        if (p.mode < TINYGLTF_MODE_TRIANGLES) continue;
        if (p.attributes.count("COLOR_0") != 0) has_colours_ = true;
        if (p.material < 0) continue;
        const Material& m = character_.materials[index_of(p.material)];
        if (m.emissive_image >= 0 && !(base_uv_[index_of(p.material)] == emissive_uv_[index_of(p.material)]))
          has_emissive_uvs_ = true;
      }
    }
    if (has_colours_) character_.mesh.colours.reserve(plan_.vertices);
    if (has_emissive_uvs_) character_.mesh.emissive_uvs.reserve(plan_.vertices);
  }

  struct Palette {
    int first = 0;
    int count = 0;
    bool rigid = false;
  };

  Palette skin_palette(int skin) {
    auto& joints = character_.skeleton.joints;
    const auto [place, fresh] = skin_first_.emplace(skin, static_cast<int>(joints.size()));
    const tinygltf::Skin& in = model_.skins[index_of(skin)];
    const Palette palette{place->second, static_cast<int>(in.joints.size()), false};
    if (!fresh) return palette;
    if (first_skin_ < 0) first_skin_ = skin;
    std::optional<AccessorView> binds;
    if (in.inverseBindMatrices >= 0) binds = view_of(in.inverseBindMatrices);
    for (size_t j = 0; j < in.joints.size(); ++j) {
      Joint joint;
      joint.node = node_of_[index_of(in.joints[j])];
      joint.name = model_.nodes[index_of(in.joints[j])].name;
      if (binds) {
        for (int e = 0; e < 16; ++e) joint.inverse_bind[e / 4][e % 4] = finite(*binds, j, e);
        const glm::dmat4& m = joint.inverse_bind;
        if (std::abs(m[0][3]) + std::abs(m[1][3]) + std::abs(m[2][3]) + std::abs(m[3][3] - 1.0) > 1e-3)
          fail(binds->path, fmt::format("inverse bind matrix {} is not affine", j));
        for (int c = 0; c < 4; ++c) joint.inverse_bind[c][3] = c == 3 ? 1.0 : 0.0;
      }
      joints.push_back(std::move(joint));
    }
    return palette;
  }

  Palette rigid_palette(size_t node) {
    auto& joints = character_.skeleton.joints;
    Joint joint;
    joint.node = node_of_[node];
    joint.name = model_.nodes[node].name;
    joint.rigid = true;
    joints.push_back(std::move(joint));
    return {static_cast<int>(joints.size()) - 1, 1, true};
  }

  void read_primitive(const tinygltf::Primitive& in, const std::string& path, size_t node, const Palette& palette) {
    const auto position = in.attributes.find("POSITION");
    if (in.mode < TINYGLTF_MODE_TRIANGLES || position == in.attributes.end()) return;
    Mesh& mesh = character_.mesh;
    const AccessorView positions = view_of(position->second);
    const size_t count = positions.count;
    Primitive out;
    out.first_vertex = static_cast<uint32_t>(mesh.positions.size());
    out.first_index = static_cast<uint32_t>(mesh.indices.size());
    out.material = in.material >= 0 ? in.material : default_material();
    out.node = node_of_[node];
    out.gltf_node = static_cast<int>(node);
    out.mirrored = palette.rigid && is_mirrored(out.node);
    for (size_t i = 0; i < count; ++i) {
      mesh.positions.push_back(finite3(positions, i));
      mesh.file_vertices.push_back(out.first_vertex + static_cast<uint32_t>(i));
    }
    const UvSource& base = base_uv_[index_of(out.material)];
    read_uvs(in, path, base, character_.materials[index_of(out.material)].base_colour_image >= 0, count, mesh.uvs);
    if (has_emissive_uvs_) read_uvs(in, path, emissive_uv_[index_of(out.material)], false, count, mesh.emissive_uvs);
    if (has_colours_) read_colours(in, count);
    if (palette.rigid) {
      mesh.joints.insert(mesh.joints.end(), count, glm::u16vec4(static_cast<uint16_t>(palette.first), 0, 0, 0));
      mesh.weights.insert(mesh.weights.end(), count, glm::vec4(1.0F, 0.0F, 0.0F, 0.0F));
      character_.file_max_influences = std::max(character_.file_max_influences, 1);
    } else {
      read_weights(in, count, palette);
    }
    read_indices(in, path, out.first_vertex, count);
    out.index_count = static_cast<uint32_t>(mesh.indices.size()) - out.first_index;
    if (const auto normal = in.attributes.find("NORMAL"); normal != in.attributes.end())
      read_normals(view_of(normal->second));
    else
      flat_normals(out, path);
    out.vertex_count = static_cast<uint32_t>(mesh.positions.size()) - out.first_vertex;
    mesh.primitives.push_back(out);
  }

  void read_uvs(const tinygltf::Primitive& in, const std::string& path, const UvSource& uv, bool needed, size_t count,
                std::vector<glm::vec2>& out) {
    const auto found = in.attributes.find(fmt::format("TEXCOORD_{}", uv.set));
    if (found == in.attributes.end()) {
      if (needed) warn(fmt::format("{}: is textured but has no TEXCOORD_{}", path, uv.set));
      out.insert(out.end(), count, glm::vec2(0.0F));
      return;
    }
    const AccessorView view = view_of(found->second);
    // The extension turns counter-clockwise as seen with v pointing down, as the engines agree; its GLSL text has the
    // signs for v pointing up.
    const double c = std::cos(uv.rotation);
    const double s = std::sin(uv.rotation);
    for (size_t i = 0; i < count; ++i) {
      const double u = finite(view, i, 0) * uv.scale.x;
      const double v = finite(view, i, 1) * uv.scale.y;
      out.emplace_back(static_cast<float>(uv.offset.x + c * u + s * v),
                       static_cast<float>(uv.offset.y - s * u + c * v));
    }
  }

  void read_colours(const tinygltf::Primitive& in, size_t count) {
    auto& colours = character_.mesh.colours;
    const auto found = in.attributes.find("COLOR_0");
    if (found == in.attributes.end()) {
      colours.insert(colours.end(), count, glm::vec4(1.0F));
      return;
    }
    const AccessorView view = view_of(found->second);
    for (size_t i = 0; i < count; ++i) {
      glm::vec4 colour(1.0F);
      for (int c = 0; c < view.components; ++c)
        colour[c] = static_cast<float>(std::clamp(finite(view, i, c), 0.0, 1.0));
      colours.push_back(colour);
    }
  }

  void read_normals(const AccessorView& view) {
    for (size_t i = 0; i < view.count; ++i) {
      const glm::vec3 n = finite3(view, i);
      const float length = glm::length(n);
      if (length < 1e-6F) ++zero_normals_;
      character_.mesh.normals.push_back(length < 1e-6F ? glm::vec3(0.0F, 1.0F, 0.0F) : n / length);
    }
  }

  struct Influence {
    int joint = 0;
    double weight = 0;
  };

  void read_weights(const tinygltf::Primitive& in, size_t count, const Palette& palette) {
    std::vector<AccessorView> joints;
    std::vector<AccessorView> weights;
    for (int set = 0; set < limits_.influence_sets; ++set) {
      const auto j = in.attributes.find(fmt::format("JOINTS_{}", set));
      const auto w = in.attributes.find(fmt::format("WEIGHTS_{}", set));
      if (j == in.attributes.end() || w == in.attributes.end()) break;
      joints.push_back(view_of(j->second));
      weights.push_back(view_of(w->second));
      // Whole numbers are parts of the type's range, whether the file says so or not.
      if (weights.back().type != kF32) weights.back().normalized = true;
    }
    std::vector<Influence> all;
    for (size_t v = 0; v < count; ++v) {
      all.clear();
      double sum = 0;
      for (size_t set = 0; set < joints.size(); ++set)
        for (int c = 0; c < 4; ++c) sum += gather(joints[set], weights[set], v, c, palette.count, all);
      if (sum < 1e-9) {
        ++zero_weights_;
        const uint32_t first = joints[0].unsigned_at(v, 0);
        all.assign(1, {static_cast<int>(first) < palette.count ? static_cast<int>(first) : 0, 1.0});
        sum = 1.0;
      } else if (std::abs(sum - 1.0) > 0.05) {
        ++scaled_weights_;
      }
      character_.file_max_influences = std::max(character_.file_max_influences, static_cast<int>(all.size()));
      // The order among equals is the file's, so that the choice is the same everywhere.
      std::stable_sort(all.begin(), all.end(), [](const auto& a, const auto& b) { return a.weight > b.weight; });
      double kept = 0;
      const size_t n = std::min<size_t>(all.size(), kInfluences);
      for (size_t i = 0; i < n; ++i) kept += all[i].weight;
      if (all.size() > n) {
        ++reduced_;
        worst_lost_ = std::max(worst_lost_, 1.0 - kept / sum);
        lost_ += 1.0 - kept / sum;
      }
      glm::u16vec4 out_joints(0);
      glm::vec4 out_weights(0.0F);
      for (size_t i = 0; i < n; ++i) {
        out_joints[static_cast<int>(i)] = static_cast<uint16_t>(palette.first + all[i].joint);
        out_weights[static_cast<int>(i)] = static_cast<float>(all[i].weight / kept);
      }
      character_.mesh.joints.push_back(out_joints);
      character_.mesh.weights.push_back(out_weights);
    }
  }

  // Adds one influence (a joint named twice is one influence) and returns its weight.
  double gather(const AccessorView& joints, const AccessorView& weights, size_t v, int c, int palette_size,
                std::vector<Influence>& all) {
    const double weight = weights.at(v, c);
    const uint32_t joint = joints.unsigned_at(v, c);
    if (!std::isfinite(weight) || weight > limits_.magnitude)
      fail(weights.path, fmt::format("the weight of vertex {} is {}", v, weight));
    if (weight < -1e-4) fail(weights.path, fmt::format("the weight of vertex {} is {}, negative", v, weight));
    if (weight <= 0.0) return 0.0;
    if (joint >= static_cast<uint32_t>(palette_size))
      fail(joints.path, fmt::format("vertex {} names joint {}, its skin has {}", v, joint, palette_size));
    const auto same =
        std::find_if(all.begin(), all.end(), [&](const Influence& i) { return i.joint == static_cast<int>(joint); });
    if (same != all.end())
      same->weight += weight;
    else
      all.push_back({static_cast<int>(joint), weight});
    return weight;
  }

  void report_weights() {
    if (zero_normals_ > 0) warn(fmt::format("{} normals of length zero point up instead", zero_normals_));
    if (zero_weights_ > 0) warn(fmt::format("{} vertices without any weight follow their first joint", zero_weights_));
    if (scaled_weights_ > 0)
      warn(fmt::format("{} vertices with weights that do not sum to 1 were rescaled", scaled_weights_));
    if (reduced_ > 0)
      warn(
          fmt::format("{} vertices have up to {} influences; the {} largest are kept, which loses {:.2f} % of their "
                      "weight on average, {:.2f} % at most",
                      reduced_, character_.file_max_influences, kInfluences,
                      100.0 * lost_ / static_cast<double>(reduced_), 100.0 * worst_lost_));
  }

  void read_indices(const tinygltf::Primitive& in, const std::string& path, uint32_t first_vertex, size_t vertices) {
    std::optional<AccessorView> view;
    if (in.indices >= 0) view = view_of(in.indices);
    const size_t corners = view ? view->count : vertices;
    const auto corner = [&](size_t i) {
      const size_t index = view ? view->unsigned_at(i) : i;
      if (index >= vertices)
        fail(view->path, fmt::format("index {} is {}, but {} has {} vertices", i, index, path, vertices));
      return first_vertex + static_cast<uint32_t>(index);
    };
    auto& indices = character_.mesh.indices;
    if (in.mode == TINYGLTF_MODE_TRIANGLES) {
      for (size_t i = 0; i < corners; ++i) indices.push_back(corner(i));
      return;
    }
    for (size_t i = 0; i + 2 < corners; ++i) {
      if (in.mode == TINYGLTF_MODE_TRIANGLE_FAN) {
        for (const size_t k : {i + 1, i + 2, size_t{0}}) indices.push_back(corner(k));
      } else {
        // Every other triangle of a strip turns the other way round.
        const size_t odd = i % 2;
        for (const size_t k : {i, i + 1 + odd, i + 2 - odd}) indices.push_back(corner(k));
      }
    }
  }

  // Face normals; a vertex whose faces point apart is doubled at the end of the primitive's range.
  void flat_normals(const Primitive& primitive, const std::string& path) {
    Mesh& mesh = character_.mesh;
    const size_t first = primitive.first_vertex;
    const size_t count = mesh.positions.size() - first;
    mesh.normals.resize(mesh.positions.size(), glm::vec3(0.0F));
    std::vector<uint32_t> latest(count);  // the last copy made of each vertex
    for (size_t i = 0; i < count; ++i) latest[i] = static_cast<uint32_t>(first + i);
    for (size_t t = primitive.first_index; t + 2 < mesh.indices.size(); t += 3) {
      const glm::dvec3 a(mesh.positions[mesh.indices[t]]);
      const glm::dvec3 b(mesh.positions[mesh.indices[t + 1]]);
      const glm::dvec3 c(mesh.positions[mesh.indices[t + 2]]);
      const glm::dvec3 cross = glm::cross(b - a, c - a);
      const double length = glm::length(cross);
      const glm::vec3 normal = length > 1e-300 ? glm::vec3(cross / length) : glm::vec3(0.0F, 1.0F, 0.0F);
      for (size_t k = t; k < t + 3; ++k) {
        const uint32_t vertex = mesh.indices[k];
        uint32_t& copy = latest[vertex - first];
        if (mesh.normals[copy] == glm::vec3(0.0F)) mesh.normals[copy] = normal;
        if (glm::dot(mesh.normals[copy], normal) < kSameNormal) {
          if (mesh.positions.size() >= limits_.vertices)
            fail(path, fmt::format("flat normals need more than {} vertices", limits_.vertices), "export normals");
          copy = double_vertex(vertex, normal);
        }
        mesh.indices[k] = copy;
      }
    }
    for (size_t i = first; i < mesh.normals.size(); ++i)
      if (mesh.normals[i] == glm::vec3(0.0F)) mesh.normals[i] = glm::vec3(0.0F, 1.0F, 0.0F);
    if (!warned_flat_) warn(fmt::format("{}: has no normals and is drawn flat", path));
    warned_flat_ = true;
  }

  uint32_t double_vertex(uint32_t vertex, const glm::vec3& normal) {
    Mesh& mesh = character_.mesh;
    const auto again = [vertex](auto& array) {
      const auto value = array[vertex];
      array.push_back(value);
    };
    again(mesh.positions);
    again(mesh.uvs);
    again(mesh.joints);
    again(mesh.weights);
    if (!mesh.emissive_uvs.empty()) again(mesh.emissive_uvs);
    if (!mesh.colours.empty()) again(mesh.colours);
    mesh.normals.push_back(normal);
    return static_cast<uint32_t>(mesh.positions.size() - 1);
  }

  // --- skeleton root and clips ---

  void find_root() {
    Skeleton& skeleton = character_.skeleton;
    if (first_skin_ < 0) return;
    const tinygltf::Skin& skin = model_.skins[index_of(first_skin_)];
    if (skin.skeleton >= 0) {
      skeleton.root_node = node_of_[index_of(skin.skeleton)];
      return;
    }
    // The lowest common ancestor. A parent's index is below its child's, so the larger of two climbs until they meet.
    int common = node_of_[index_of(skin.joints[0])];
    const int fallback = common;
    for (const int joint : skin.joints) {
      int other = node_of_[index_of(joint)];
      while (common != other && common >= 0 && other >= 0) {
        int& later = common > other ? common : other;
        later = skeleton.nodes[index_of(later)].parent;
      }
      if (common != other) common = -1;
      if (common < 0) break;
    }
    skeleton.root_node = common < 0 ? fallback : common;
    if (common < 0) warn("the joints of the skin have no common root; the first joint counts as the root");
  }

  void read_clips() {
    if (model_.animations.size() * std::max<size_t>(model_.nodes.size(), 1) > limits_.clip_nodes)
      fail("/animations", fmt::format("{} clips of {} nodes, the limit is a product of {}", model_.animations.size(),
                                      model_.nodes.size(), limits_.clip_nodes));
    std::vector<std::string> still;
    for (size_t a = 0; a < model_.animations.size(); ++a) {
      const tinygltf::Animation& in = model_.animations[a];
      Clip clip;
      clip.name = in.name;
      clip.start = limits_.magnitude;
      clip.end = 0;
      for (const tinygltf::AnimationChannel& channel : in.channels)
        clip.channels.push_back(read_channel(in, channel, fmt::format("/animations/{}", a)));
      for (const Channel& channel : clip.channels) {
        clip.start = std::min(clip.start, channel.times.front());
        clip.end = std::max(clip.end, channel.times.back());
      }
      if (clip.channels.empty()) {
        clip.start = 0;
        warn(fmt::format("/animations/{}: moves no node", a));
      } else if (clip.end == clip.start) {
        still.push_back(clip.name.empty() ? fmt::format("{}", a) : printable(clip.name, 40));
      }
      character_.clips.push_back(std::move(clip));
    }
    if (still.empty()) return;
    const size_t listed = std::min<size_t>(still.size(), 8);
    warn(fmt::format("{} clips have zero length: {}{}", still.size(),
                     fmt::join(still.begin(), still.begin() + static_cast<std::ptrdiff_t>(listed), ", "),
                     listed < still.size() ? ", ..." : ""));
  }

  Channel read_channel(const tinygltf::Animation& animation, const tinygltf::AnimationChannel& in,
                       const std::string& path) {
    const tinygltf::AnimationSampler& sampler = animation.samplers[index_of(in.sampler)];
    Channel out;
    out.node = node_of_[index_of(in.target_node)];
    out.target = in.target_path == "rotation" ? Target::rotation
                 : in.target_path == "scale"  ? Target::scale
                                              : Target::translation;
    out.interpolation = sampler.interpolation == "STEP"          ? Interpolation::step
                        : sampler.interpolation == "CUBICSPLINE" ? Interpolation::cubic_spline
                                                                 : Interpolation::linear;
    make_animatable(character_.skeleton.nodes[index_of(out.node)], in.target_node, path);
    const AccessorView input = view_of(sampler.input);
    out.times.reserve(input.count);
    for (size_t i = 0; i < input.count; ++i) {
      const double t = finite(input, i, 0);
      if (t < 0) fail(input.path, fmt::format("key {} is at {} s, before 0", i, t));
      if (t > limits_.clip_seconds)
        fail(input.path, fmt::format("key {} is at {} s, the limit is {}", i, t, limits_.clip_seconds));
      if (i > 0 && t <= out.times.back())
        fail(input.path, fmt::format("key {} at {} s is not after key {} at {} s", i, t, i - 1, out.times.back()));
      out.times.push_back(t);
    }
    const AccessorView output = view_of(sampler.output);
    const bool cubic = out.interpolation == Interpolation::cubic_spline;
    out.values.reserve(output.count * static_cast<size_t>(output.components));
    for (size_t i = 0; i < output.count; ++i) {
      const size_t at = out.values.size();
      for (int c = 0; c < output.components; ++c) out.values.push_back(finite(output, i, c));
      // Tangents of a spline are no rotations.
      if (out.target == Target::rotation && (!cubic || i % 3 == 1)) normalise_rotation(&out.values[at], output, i);
    }
    return out;
  }

  void normalise_rotation(double* q, const AccessorView& view, size_t i) {
    const double length = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
    if (length < 1e-6) fail(view.path, fmt::format("rotation {} is a quaternion of length zero", i));
    if (std::abs(length - 1.0) > 1e-2 && !warned_length_) {
      warn(fmt::format("{}: rotation {} of length {:.3g} is normalised", view.path, i, length));
      warned_length_ = true;
    }
    for (int c = 0; c < 4; ++c) q[c] /= length;
  }

  // The specification wants translation, rotation and scale on an animated node; a matrix without shear is the same.
  void make_animatable(Node& node, int file_index, const std::string& path) {
    if (!node.has_matrix) return;
    const std::string where = fmt::format("{}: animates node {}, which has a matrix", path, file_index);
    glm::dmat3 axes(node.matrix);
    glm::dvec3 scale(glm::length(axes[0]), glm::length(axes[1]), glm::length(axes[2]));
    if (glm::determinant(axes) < 0) scale.x = -scale.x;
    bool sound = true;
    for (int i = 0; i < 3; ++i) {
      if (std::abs(scale[i]) < 1e-12) sound = false;
      axes[i] /= scale[i];
    }
    for (int i = 0; sound && i < 3; ++i)
      if (std::abs(glm::dot(axes[i], axes[(i + 1) % 3])) > 1e-4) sound = false;
    if (!sound) fail(path, fmt::format("animates node {}, whose matrix has shear or no volume", file_index));
    node.translation = glm::dvec3(node.matrix[3]);
    node.rotation = glm::normalize(glm::quat_cast(axes));
    node.scale = scale;
    node.has_matrix = false;
    node.matrix = glm::dmat4(1.0);
    warn(where + "; it is taken apart");
  }

  // A bound of the spectral norm that is exact for rotations: the root of the largest row sum of |M^T M|.
  static double most_stretch(const glm::dmat3& m) {
    double most = 0;
    for (int i = 0; i < 3; ++i)
      most = std::max(most,
                      std::abs(glm::dot(m[i], m[0])) + std::abs(glm::dot(m[i], m[1])) + std::abs(glm::dot(m[i], m[2])));
    return std::sqrt(most);
  }

  // How far any pose can reach: scales multiply down the hierarchy, and what no clip can move beyond the limit needs no
  // watch for overflow anywhere else.
  void check_reach() const {
    const auto& nodes = character_.skeleton.nodes;
    std::vector<double> scale(nodes.size());
    std::vector<double> offset(nodes.size());
    for (size_t i = 0; i < nodes.size(); ++i) {
      const Node& n = nodes[i];
      const auto largest = [](const glm::dvec3& v) { return std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)}); };
      scale[i] = n.has_matrix ? most_stretch(glm::dmat3(n.matrix)) : largest(n.scale);
      offset[i] = largest(n.has_matrix ? glm::dvec3(n.matrix[3]) : n.translation);
    }
    for (const Clip& clip : character_.clips) {
      for (const Channel& channel : clip.channels) {
        if (channel.target == Target::rotation) continue;
        double most = 0;
        for (const double v : channel.values) most = std::max(most, std::abs(v));
        // The tangents of a spline count by the time between keys.
        if (channel.interpolation == Interpolation::cubic_spline) most *= 1.0 + clip.duration();
        double& bound = (channel.target == Target::scale ? scale : offset)[index_of(channel.node)];
        bound = std::max(bound, most);
      }
    }
    for (size_t i = 0; i < nodes.size(); ++i) {
      if (nodes[i].parent >= 0) {
        const size_t parent = index_of(nodes[i].parent);
        offset[i] = offset[parent] + 2.0 * scale[parent] * offset[i];
        scale[i] *= scale[parent];
      }
      if (scale[i] <= limits_.reach && offset[i] <= limits_.reach) continue;
      const auto file_index = std::find(node_of_.begin(), node_of_.end(), static_cast<int>(i)) - node_of_.begin();
      fail(fmt::format("/nodes/{}", file_index), fmt::format("lies beyond the limit of {} once its parents' scales and "
                                                             "translations are applied",
                                                             limits_.reach));
    }
  }

  void finish() {
    check_reach();
    normalise(character_, options_.normalise);
    const Placement& p = character_.placement;
    if (!std::isfinite(p.height) || !std::isfinite(p.scale) || p.scale <= 0)
      throw Error(source_.where(), "its posed height is not a number", "its transforms collapse it");
    if (p.height <= 0) warn("has no height as posed; it is not scaled");
  }

  GltfSource& source_;
  GltfPlan plan_;
  const LoadOptions& options_;
  const GltfLimits& limits_;
  tinygltf::Model model_;
  Character character_;
  std::vector<int> node_of_;  // Skeleton::nodes index by file index
  std::vector<bool> hidden_;  // by file index
  std::vector<bool> material_used_;
  std::vector<UvSource> base_uv_;
  std::vector<UvSource> emissive_uv_;
  std::map<std::array<int, 5>, int> texture_index_;
  size_t decoded_bytes_ = 0;
  int default_material_ = -1;
  bool has_colours_ = false;
  bool has_emissive_uvs_ = false;
  std::map<int, int> skin_first_;
  int first_skin_ = -1;
  size_t zero_normals_ = 0;
  size_t zero_weights_ = 0;
  size_t scaled_weights_ = 0;
  size_t reduced_ = 0;
  double lost_ = 0;
  double worst_lost_ = 0;
  bool warned_flat_ = false;
  bool warned_length_ = false;
};

}  // namespace

Character load_character(const std::vector<uint8_t>& bytes, const std::string& where,
                         const std::filesystem::path& folder, const LoadOptions& options) {
  GltfSource source(bytes, printable(where, 300), folder, options.limits);
  GltfPlan plan = validate_gltf(source, options.limits);
  Character character = Loader(source, std::move(plan), options).run();
  character.name = std::filesystem::path(where).stem().string();
  character.source = where;
  return character;
}

Character load_character(const std::filesystem::path& path, const LoadOptions& options) {
  std::filesystem::path folder = path.parent_path();
  if (folder.empty()) folder = ".";
  return load_character(read_file(path, options.limits.file_bytes), path.string(), folder, options);
}

}  // namespace crowdbench::scene
