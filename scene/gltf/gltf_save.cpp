// Character to .glb.
// Based on: Khronos Group, "glTF 2.0 Specification" (GLB container, accessors, skins) and KHR_materials_unlit,
// KHR_materials_emissive_strength.
#include <algorithm>
#include <cstring>
#include <map>
#include <nlohmann/json.hpp>
#include <set>

#include "core/error.h"
#include "core/files.h"
#include "core/image_io.h"
#include "core/version.h"
#include "scene/gltf/gltf.h"

namespace crowdbench::scene {
namespace {

int min_filter_number(MinFilter filter) {
  switch (filter) {
    case MinFilter::nearest: return 9728;
    case MinFilter::linear: return 9729;
    case MinFilter::nearest_mipmap_nearest: return 9984;
    case MinFilter::linear_mipmap_nearest: return 9985;
    case MinFilter::nearest_mipmap_linear: return 9986;
    case MinFilter::linear_mipmap_linear: break;
  }
  return 9987;
}

using nlohmann::ordered_json;

constexpr int kVertexData = 34962;  // ARRAY_BUFFER
constexpr int kIndexData = 34963;   // ELEMENT_ARRAY_BUFFER

class Writer {
 public:
  explicit Writer(const Character& character) : character_(character) {}

  std::vector<uint8_t> run() {
    doc_["asset"] = {{"version", "2.0"}, {"generator", fmt::format("crowdbench {}", version())}};
    doc_["scene"] = 0;
    doc_["scenes"] = ordered_json::array({{{"nodes", ordered_json::array()}}});
    write_nodes();
    write_images();
    write_materials();
    write_meshes();
    write_clips();
    doc_["buffers"] = ordered_json::array({{{"byteLength", bin_.size()}}});
    if (!extensions_.empty()) doc_["extensionsUsed"] = extensions_;
    return container();
  }

 private:
  size_t view(const void* data, size_t size, int target) {
    while (bin_.size() % 4 != 0) bin_.push_back(0);
    ordered_json out = {{"buffer", 0}, {"byteOffset", bin_.size()}, {"byteLength", size}};
    if (target != 0) out["target"] = target;
    const auto* bytes = static_cast<const uint8_t*>(data);
    bin_.insert(bin_.end(), bytes, bytes + size);
    doc_["bufferViews"].push_back(std::move(out));
    return doc_["bufferViews"].size() - 1;
  }

  template <typename T>
  size_t accessor(const std::vector<T>& data, int component_type, const char* type, size_t count, int target) {
    ordered_json out = {{"bufferView", view(data.data(), data.size() * sizeof(T), target)},
                        {"componentType", component_type},
                        {"count", count},
                        {"type", type}};
    doc_["accessors"].push_back(std::move(out));
    return doc_["accessors"].size() - 1;
  }

  // Floats with their bounds, which glTF wants for positions and key times.
  size_t float_accessor(const std::vector<float>& data, const char* type, size_t components, int target,
                        bool bounds = false) {
    const size_t index = accessor(data, 5126, type, data.size() / components, target);
    if (!bounds) return index;
    std::vector<float> low(data.begin(), data.begin() + static_cast<std::ptrdiff_t>(components));
    std::vector<float> high = low;
    for (size_t i = 0; i < data.size(); ++i) {
      low[i % components] = std::min(low[i % components], data[i]);
      high[i % components] = std::max(high[i % components], data[i]);
    }
    doc_["accessors"][index]["min"] = low;
    doc_["accessors"][index]["max"] = high;
    return index;
  }

  void write_nodes() {
    const auto& nodes = character_.skeleton.nodes;
    doc_["nodes"] = ordered_json::array();
    for (size_t i = 0; i < nodes.size(); ++i) {
      const Node& n = nodes[i];
      ordered_json out = ordered_json::object();
      if (!n.name.empty()) out["name"] = n.name;
      if (n.has_matrix) {
        for (int e = 0; e < 16; ++e) out["matrix"].push_back(n.matrix[e / 4][e % 4]);
      } else {
        if (n.translation != glm::dvec3(0.0)) out["translation"] = {n.translation.x, n.translation.y, n.translation.z};
        if (n.rotation != glm::dquat(1.0, 0.0, 0.0, 0.0))
          out["rotation"] = {n.rotation.x, n.rotation.y, n.rotation.z, n.rotation.w};
        if (n.scale != glm::dvec3(1.0)) out["scale"] = {n.scale.x, n.scale.y, n.scale.z};
      }
      doc_["nodes"].push_back(std::move(out));
      add_to_parent(i, n.parent);
    }
  }

  void add_to_parent(size_t node, int parent) {
    if (parent < 0)
      doc_["scenes"][0]["nodes"].push_back(node);
    else
      doc_["nodes"][static_cast<size_t>(parent)]["children"].push_back(node);
  }

  void write_images() {
    for (const Texture& texture : character_.images) {
      const std::vector<uint8_t> png = encode_png(texture.image);
      doc_["images"].push_back({{"mimeType", "image/png"}, {"bufferView", view(png.data(), png.size(), 0)}});
      const auto wrap = [](bool repeat, bool mirrored) { return !repeat ? 33071 : mirrored ? 33648 : 10497; };
      doc_["samplers"].push_back({{"magFilter", texture.nearest ? 9728 : 9729},
                                  {"minFilter", min_filter_number(texture.min_filter)},
                                  {"wrapS", wrap(texture.repeat_u, texture.mirrored_u)},
                                  {"wrapT", wrap(texture.repeat_v, texture.mirrored_v)}});
      doc_["textures"].push_back({{"source", doc_["images"].size() - 1}, {"sampler", doc_["samplers"].size() - 1}});
    }
  }

  void write_materials() {
    for (const Material& m : character_.materials) {
      ordered_json out = ordered_json::object();
      if (!m.name.empty()) out["name"] = m.name;
      ordered_json pbr = {{"baseColorFactor", {m.base_colour.r, m.base_colour.g, m.base_colour.b, m.base_colour.a}},
                          {"metallicFactor", 0},
                          {"roughnessFactor", 1}};
      if (m.base_colour_image >= 0) pbr["baseColorTexture"] = {{"index", m.base_colour_image}};
      out["pbrMetallicRoughness"] = std::move(pbr);
      const float strength = std::max({m.emissive.r, m.emissive.g, m.emissive.b, 1.0F});
      if (m.emissive != glm::vec3(0.0F))
        out["emissiveFactor"] = {m.emissive.r / strength, m.emissive.g / strength, m.emissive.b / strength};
      if (m.emissive_image >= 0)
        out["emissiveTexture"] = {{"index", m.emissive_image},
                                  {"texCoord", character_.mesh.emissive_uvs.empty() ? 0 : 1}};
      if (strength > 1.0F) {
        out["extensions"]["KHR_materials_emissive_strength"] = {{"emissiveStrength", strength}};
        extensions_.insert("KHR_materials_emissive_strength");
      }
      if (m.unlit) {
        out["extensions"]["KHR_materials_unlit"] = ordered_json::object();
        extensions_.insert("KHR_materials_unlit");
      }
      if (m.double_sided) out["doubleSided"] = true;
      if (m.alpha_cutoff > 0) {
        out["alphaMode"] = "MASK";
        out["alphaCutoff"] = m.alpha_cutoff;
      }
      doc_["materials"].push_back(std::move(out));
    }
  }

  bool is_rigid(const Primitive& p) const {
    return character_.skeleton.joints[character_.mesh.joints[p.first_vertex].x].rigid;
  }

  // One new node for each run of primitives of one node, after all others: the order of vertices stays.
  void write_meshes() {
    const auto& primitives = character_.mesh.primitives;
    for (size_t first = 0; first < primitives.size();) {
      size_t last = first + 1;
      while (last < primitives.size() && primitives[last].gltf_node == primitives[first].gltf_node &&
             primitives[last].node == primitives[first].node)
        ++last;
      write_mesh(first, last);
      first = last;
    }
  }

  void write_mesh(size_t first, size_t last) {
    const Mesh& mesh = character_.mesh;
    const Primitive& front = mesh.primitives[first];
    const bool rigid = is_rigid(front);
    const std::string& node_name = character_.skeleton.nodes[static_cast<size_t>(front.node)].name;
    const std::string name = node_name.empty() ? character_.name : node_name + "_mesh";
    ordered_json node = {{"name", name}, {"mesh", doc_["meshes"].size()}};
    std::vector<uint16_t> slot;  // by palette entry: its place in the skin
    if (!rigid) node["skin"] = write_skin(first, last, slot);
    ordered_json out = {{"name", name}, {"primitives", ordered_json::array()}};
    for (size_t p = first; p < last; ++p) out["primitives"].push_back(write_primitive(mesh.primitives[p], slot));
    doc_["meshes"].push_back(std::move(out));
    doc_["nodes"].push_back(std::move(node));
    add_to_parent(doc_["nodes"].size() - 1, rigid ? front.node : -1);
  }

  // All skins in one where no node is in two of them, else the joints that these primitives use.
  size_t write_skin(size_t first, size_t last, std::vector<uint16_t>& slot) {
    const auto& joints = character_.skeleton.joints;
    std::vector<size_t> entries;
    std::set<int> nodes;
    bool unique = true;
    for (size_t j = 0; j < joints.size(); ++j) {
      if (joints[j].rigid) continue;
      entries.push_back(j);
      unique = nodes.insert(joints[j].node).second && unique;
    }
    if (!unique) {
      std::set<size_t> used;
      for (size_t p = first; p < last; ++p) {
        const Primitive& primitive = character_.mesh.primitives[p];
        for (size_t v = primitive.first_vertex; v < primitive.first_vertex + primitive.vertex_count; ++v)
          for (int i = 0; i < kInfluences; ++i)
            if (character_.mesh.weights[v][i] > 0) used.insert(character_.mesh.joints[v][i]);
      }
      entries.assign(used.begin(), used.end());
    }
    slot.assign(joints.size(), 0);
    for (size_t i = 0; i < entries.size(); ++i) slot[entries[i]] = static_cast<uint16_t>(i);
    const auto [place, fresh] = skins_.emplace(entries, doc_["skins"].size());
    if (!fresh) return place->second;
    ordered_json skin = {{"joints", ordered_json::array()}};
    std::vector<float> binds;
    for (const size_t j : entries) {
      skin["joints"].push_back(joints[j].node);
      for (int e = 0; e < 16; ++e) binds.push_back(static_cast<float>(joints[j].inverse_bind[e / 4][e % 4]));
    }
    skin["inverseBindMatrices"] = float_accessor(binds, "MAT4", 16, 0);
    if (character_.skeleton.root_node >= 0) skin["skeleton"] = character_.skeleton.root_node;
    doc_["skins"].push_back(std::move(skin));
    return place->second;
  }

  template <typename V>
  size_t vectors(const std::vector<V>& all, const Primitive& p, const char* type, bool bounds = false) {
    std::vector<float> flat;
    for (size_t v = p.first_vertex; v < p.first_vertex + p.vertex_count; ++v)
      for (int c = 0; c < V::length(); ++c) flat.push_back(all[v][c]);
    return float_accessor(flat, type, V::length(), kVertexData, bounds);
  }

  ordered_json write_primitive(const Primitive& p, const std::vector<uint16_t>& slot) {
    const Mesh& mesh = character_.mesh;
    ordered_json attributes = ordered_json::object();
    attributes["POSITION"] = vectors(mesh.positions, p, "VEC3", true);
    if (!p.flat) attributes["NORMAL"] = vectors(mesh.normals, p, "VEC3");
    attributes["TEXCOORD_0"] = vectors(mesh.uvs, p, "VEC2");
    if (!mesh.emissive_uvs.empty()) attributes["TEXCOORD_1"] = vectors(mesh.emissive_uvs, p, "VEC2");
    if (!mesh.colours.empty()) attributes["COLOR_0"] = vectors(mesh.colours, p, "VEC4");
    if (!slot.empty()) {
      std::vector<uint16_t> joints;
      for (size_t v = p.first_vertex; v < p.first_vertex + p.vertex_count; ++v)
        for (int i = 0; i < kInfluences; ++i)
          joints.push_back(mesh.weights[v][i] > 0 ? slot[mesh.joints[v][i]] : uint16_t{0});
      attributes["JOINTS_0"] = accessor(joints, 5123, "VEC4", p.vertex_count, kVertexData);
      attributes["WEIGHTS_0"] = vectors(mesh.weights, p, "VEC4");
    }
    std::vector<uint32_t> indices;
    for (size_t i = p.first_index; i < p.first_index + p.index_count; ++i)
      indices.push_back(mesh.indices[i] - p.first_vertex);
    ordered_json out = {{"attributes", std::move(attributes)}, {"material", p.material}};
    if (p.vertex_count < 65536)
      out["indices"] =
          accessor(std::vector<uint16_t>(indices.begin(), indices.end()), 5123, "SCALAR", indices.size(), kIndexData);
    else
      out["indices"] = accessor(indices, 5125, "SCALAR", indices.size(), kIndexData);
    return out;
  }

  void write_clips() {
    for (const Clip& clip : character_.clips) {
      if (clip.channels.empty()) continue;  // glTF does not allow an empty animation
      ordered_json out = ordered_json::object();
      if (!clip.name.empty()) out["name"] = clip.name;
      for (const Channel& channel : clip.channels) {
        static constexpr const char* kPaths[] = {"translation", "rotation", "scale"};
        static constexpr const char* kKinds[] = {"STEP", "LINEAR", "CUBICSPLINE"};
        const bool rotation = channel.target == Target::rotation;
        out["samplers"].push_back({{"input", key_times(channel.times)},
                                   {"output", float_accessor({channel.values.begin(), channel.values.end()},
                                                             rotation ? "VEC4" : "VEC3", rotation ? 4 : 3, 0)},
                                   {"interpolation", kKinds[static_cast<size_t>(channel.interpolation)]}});
        out["channels"].push_back(
            {{"sampler", out["samplers"].size() - 1},
             {"target", {{"node", channel.node}, {"path", kPaths[static_cast<size_t>(channel.target)]}}}});
      }
      doc_["animations"].push_back(std::move(out));
    }
  }

  // Channels mostly share their key times.
  size_t key_times(const std::vector<double>& times) {
    const auto found = times_.find(times);
    if (found != times_.end()) return found->second;
    const size_t index = float_accessor({times.begin(), times.end()}, "SCALAR", 1, 0, true);
    times_.emplace(times, index);
    return index;
  }

  std::vector<uint8_t> container() {
    std::string text = doc_.dump(-1, ' ', false, ordered_json::error_handler_t::replace);
    while (text.size() % 4 != 0) text += ' ';
    while (bin_.size() % 4 != 0) bin_.push_back(0);
    const size_t total = 12 + 8 + text.size() + 8 + bin_.size();
    std::vector<uint8_t> out;
    out.reserve(total);
    const auto u32 = [&](size_t value) {
      const auto v = static_cast<uint32_t>(value);
      uint8_t bytes[4];
      std::memcpy(bytes, &v, 4);
      out.insert(out.end(), bytes, bytes + 4);
    };
    u32(0x46546C67);  // "glTF"
    u32(2);
    u32(total);
    u32(text.size());
    u32(0x4E4F534A);  // "JSON"
    out.insert(out.end(), text.begin(), text.end());
    u32(bin_.size());
    u32(0x004E4942);  // "BIN"
    out.insert(out.end(), bin_.begin(), bin_.end());
    return out;
  }

  const Character& character_;
  ordered_json doc_;
  std::vector<uint8_t> bin_;
  std::set<std::string> extensions_;
  std::map<std::vector<size_t>, size_t> skins_;
  std::map<std::vector<double>, size_t> times_;
};

}  // namespace

void save_character(const Character& character, const std::filesystem::path& path) {
  if (path.extension() != ".glb")
    throw Error(path.string(), "can only be written as .glb", "give the name the extension .glb");
  const std::vector<uint8_t> bytes = Writer(character).run();
  write_file(path, bytes.data(), bytes.size());
}

}  // namespace crowdbench::scene
