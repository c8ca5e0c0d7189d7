// Triangles, and the skins that bend them.
//
// Assimp has a mesh for each material, with bones of its own, and FBX files a vertex for each corner. Vertices that are
// the same to the bit become one again, and meshes share a skin wherever no node is bound by two matrices.
#include <algorithm>
#include <nlohmann/json.hpp>

#include "scene/assimp/module/conversion.h"

namespace crowdbench::scene::assimp_module {
namespace {

constexpr size_t kMostInfluences = 16;  // JOINTS_0..JOINTS_3
constexpr unsigned kMostUvSets = 4;

struct Skin {
  std::vector<int> nodes;
  std::vector<aiMatrix4x4> binds;
  std::map<int, size_t> slot;  // by node
};

struct Influence {
  uint16_t slot;
  float weight;
};

struct Converted {
  nlohmann::json primitive;  // null: nothing to draw
  int skin = -1;
};

class Meshes {
 public:
  explicit Meshes(Conversion& c) : c_(c), converted_(c.scene.mNumMeshes), known_(c.scene.mNumMeshes, false) {}

  void run() {
    for (size_t n = 0; n < c_.nodes.size(); ++n)
      if (c_.nodes[n]->mNumMeshes > 0) add_to_node(n);
    for (const Skin& skin : skins_) write_skin(skin);
  }

 private:
  // A node has one mesh with one skin; meshes of further skins go to children that do not move.
  void add_to_node(size_t n) {
    std::map<int, nlohmann::json> by_skin;
    for (unsigned m = 0; m < c_.nodes[n]->mNumMeshes; ++m) {
      const Converted& one = mesh(c_.nodes[n]->mMeshes[m], static_cast<int>(n));
      if (!one.primitive.is_null()) by_skin[one.skin].push_back(one.primitive);
    }
    const std::string name = c_.nodes[n]->mName.C_Str();
    bool first = true;
    for (auto& [skin, primitives] : by_skin) {
      const int index = c_.glb.add("meshes", {{"name", name}, {"primitives", std::move(primitives)}});
      c_.label("meshes", index, "mesh " + shown(name));
      size_t at = n;
      if (!first) {
        at = static_cast<size_t>(c_.glb.add("nodes", {{"name", name}}));
        c_.label("nodes", static_cast<int>(at), "node " + shown(name));
        c_.glb.document()["nodes"][n]["children"].push_back(at);
      }
      c_.glb.document()["nodes"][at]["mesh"] = index;
      if (skin >= 0) c_.glb.document()["nodes"][at]["skin"] = skin;
      first = false;
    }
  }

  // A mesh that several nodes show is converted once, bound as at the first.
  const Converted& mesh(unsigned index, int node) {
    if (!known_[index]) converted_[index] = convert(*c_.scene.mMeshes[index], node);
    known_[index] = true;
    return converted_[index];
  }

  Converted convert(const aiMesh& mesh, int node) {
    Converted out;
    std::vector<std::vector<Influence>> influences;
    if (mesh.HasBones()) influences = read_bones(mesh, node, out.skin);
    size_t sets = 0;
    for (const auto& some : influences) sets = std::max(sets, (some.size() + 3) / 4);
    const std::vector<uint32_t> corners = corners_of(mesh);
    if (corners.empty()) return out;
    std::vector<uint32_t> chosen;  // the mesh's vertices that become vertices
    const std::vector<uint32_t> indices = join(mesh, influences, corners, chosen);
    const std::string name = shown(mesh.mName.C_Str());
    nlohmann::json attributes;
    write_attributes(mesh, chosen, name, attributes);
    for (size_t set = 0; set < sets; ++set) write_influences(influences, chosen, set, name, attributes);
    out.primitive = {{"attributes", std::move(attributes)},
                     {"indices", c_.glb.accessor(indices, "SCALAR", indices.size())},
                     {"material", mesh.mMaterialIndex}};
    return out;
  }

  std::vector<uint32_t> corners_of(const aiMesh& mesh) {
    std::vector<uint32_t> corners;
    for (unsigned f = 0; f < mesh.mNumFaces; ++f) {
      const aiFace& face = mesh.mFaces[f];
      if (face.mNumIndices == 3)
        corners.insert(corners.end(), face.mIndices, face.mIndices + 3);
      else
        c_.lost.insert("points and lines");
    }
    return corners;
  }

  // --- skins ---

  std::vector<std::vector<Influence>> read_bones(const aiMesh& mesh, int node, int& skin) {
    std::vector<std::pair<int, aiMatrix4x4>> bones;
    std::vector<const aiBone*> sources;
    for (unsigned b = 0; b < mesh.mNumBones; ++b) {
      const int at = c_.node_named(mesh.mBones[b]->mName);
      if (at < 0) {
        c_.warn(fmt::format("mesh {} has a bone {} that is not a node; it is left out", shown(mesh.mName.C_Str()),
                            shown(mesh.mBones[b]->mName.C_Str())));
        continue;
      }
      bones.emplace_back(at, mesh.mBones[b]->mOffsetMatrix);
      sources.push_back(mesh.mBones[b]);
    }
    std::vector<bool> held(mesh.mNumVertices, false);
    for (const aiBone* bone : sources)
      for (unsigned w = 0; w < bone->mNumWeights; ++w)
        if (bone->mWeights[w].mWeight > 0) held[bone->mWeights[w].mVertexId] = true;
    // What no bone holds stays with the mesh's own node.
    const bool loose = std::find(held.begin(), held.end(), false) != held.end();
    if (loose) bones.emplace_back(node, aiMatrix4x4());
    skin = skin_for(bones);
    const auto slot = [&](size_t b) {
      return static_cast<uint16_t>(skins_[static_cast<size_t>(skin)].slot.at(bones[b].first));
    };
    std::vector<std::vector<Influence>> out(mesh.mNumVertices);
    for (size_t b = 0; b < sources.size(); ++b)
      for (unsigned w = 0; w < sources[b]->mNumWeights; ++w)
        if (sources[b]->mWeights[w].mWeight > 0)
          out[sources[b]->mWeights[w].mVertexId].push_back({slot(b), sources[b]->mWeights[w].mWeight});
    for (size_t v = 0; v < out.size(); ++v) {
      if (!held[v]) out[v].push_back({slot(bones.size() - 1), 1.0F});
      keep_largest(out[v]);
    }
    return out;
  }

  void keep_largest(std::vector<Influence>& all) {
    if (all.size() <= kMostInfluences) return;
    std::stable_sort(all.begin(), all.end(), [](const auto& a, const auto& b) { return a.weight > b.weight; });
    all.resize(kMostInfluences);
    c_.lost.insert(fmt::format("influences beyond {} a vertex", kMostInfluences));
  }

  // The first skin that binds none of these nodes otherwise, extended by those that it lacks.
  int skin_for(const std::vector<std::pair<int, aiMatrix4x4>>& bones) {
    const auto agrees = [&](const Skin& skin) {
      return std::all_of(bones.begin(), bones.end(), [&](const auto& bone) {
        const auto found = skin.slot.find(bone.first);
        return found == skin.slot.end() || skin.binds[found->second] == bone.second;
      });
    };
    auto skin = std::find_if(skins_.begin(), skins_.end(), agrees);
    if (skin == skins_.end()) skin = skins_.insert(skin, Skin{});
    for (const auto& [node, bind] : bones) {
      if (!skin->slot.emplace(node, skin->nodes.size()).second) continue;
      skin->nodes.push_back(node);
      skin->binds.push_back(bind);
    }
    if (skin->nodes.size() > 65535) throw Refusal{"has a skin of more than 65535 joints"};
    return static_cast<int>(skin - skins_.begin());
  }

  void write_skin(const Skin& skin) {
    std::vector<float> binds;
    for (const aiMatrix4x4& m : skin.binds)
      for (unsigned column = 0; column < 4; ++column)
        for (unsigned row = 0; row < 4; ++row) binds.push_back(m[row][column]);
    const int accessor = c_.glb.accessor(binds, "MAT4", skin.binds.size());
    c_.label("accessors", accessor, "bind matrices of a skin");
    c_.label("skins", c_.glb.add("skins", {{"joints", skin.nodes}, {"inverseBindMatrices", accessor}}), "a skin");
  }

  // --- vertices ---

  // The corners as indices into `chosen`.
  static std::vector<uint32_t> join(const aiMesh& mesh, const std::vector<std::vector<Influence>>& influences,
                                    const std::vector<uint32_t>& corners, std::vector<uint32_t>& chosen) {
    std::unordered_map<std::string, uint32_t> places;
    std::vector<uint32_t> place(mesh.mNumVertices, UINT32_MAX);
    std::vector<uint32_t> out;
    out.reserve(corners.size());
    std::string record;
    for (const uint32_t v : corners) {
      if (place[v] == UINT32_MAX) {
        make_record(mesh, influences, v, record);
        const auto [found, fresh] = places.emplace(record, static_cast<uint32_t>(chosen.size()));
        if (fresh) chosen.push_back(v);
        place[v] = found->second;
      }
      out.push_back(place[v]);
    }
    return out;
  }

  static void make_record(const aiMesh& mesh, const std::vector<std::vector<Influence>>& influences, uint32_t v,
                          std::string& out) {
    out.clear();
    const auto append = [&](const auto& value) { out.append(reinterpret_cast<const char*>(&value), sizeof value); };
    append(mesh.mVertices[v]);
    if (mesh.HasNormals()) append(mesh.mNormals[v]);
    for (unsigned set = 0; set < kMostUvSets; ++set)
      if (mesh.HasTextureCoords(set)) append(mesh.mTextureCoords[set][v]);
    if (mesh.HasVertexColors(0)) append(mesh.mColors[0][v]);
    if (influences.empty()) return;
    for (const Influence& one : influences[v]) {
      append(one.slot);
      append(one.weight);
    }
  }

  void write_floats(const std::vector<uint32_t>& chosen, size_t components, const char* type, const std::string& what,
                    nlohmann::json& accessor, const auto& value) {
    std::vector<float> data;
    data.reserve(chosen.size() * components);
    for (const uint32_t v : chosen)
      for (unsigned i = 0; i < components; ++i) data.push_back(value(v, i));
    const int index = c_.glb.accessor(data, type, chosen.size());
    c_.label("accessors", index, what);
    accessor = index;
  }

  // The first texel of a picture is at v = 1 in both formats, at v = 0 in glTF.
  void write_attributes(const aiMesh& mesh, const std::vector<uint32_t>& chosen, const std::string& name,
                        nlohmann::json& attributes) {
    write_floats(chosen, 3, "VEC3", "positions of mesh " + name, attributes["POSITION"],
                 [&](uint32_t v, unsigned i) { return mesh.mVertices[v][i]; });
    if (mesh.HasNormals())
      write_floats(chosen, 3, "VEC3", "normals of mesh " + name, attributes["NORMAL"],
                   [&](uint32_t v, unsigned i) { return mesh.mNormals[v][i]; });
    for (unsigned set = 0; set < kMostUvSets && mesh.HasTextureCoords(set); ++set)
      write_floats(chosen, 2, "VEC2", "texture coordinates of mesh " + name,
                   attributes[fmt::format("TEXCOORD_{}", set)], [&](uint32_t v, unsigned i) {
                     const float value = mesh.mTextureCoords[set][v][i];
                     return i == 0 ? value : 1.0F - value;
                   });
    if (mesh.HasVertexColors(0))
      write_floats(chosen, 4, "VEC4", "colours of mesh " + name, attributes["COLOR_0"],
                   [&](uint32_t v, unsigned i) { return mesh.mColors[0][v][i]; });
    if (mesh.HasVertexColors(1)) c_.lost.insert("further sets of vertex colours");
  }

  void write_influences(const std::vector<std::vector<Influence>>& influences, const std::vector<uint32_t>& chosen,
                        size_t set, const std::string& name, nlohmann::json& attributes) {
    std::vector<uint16_t> joints(chosen.size() * 4, 0);
    std::vector<float> weights(chosen.size() * 4, 0.0F);
    for (size_t i = 0; i < chosen.size(); ++i) {
      const std::vector<Influence>& all = influences[chosen[i]];
      for (size_t k = 0; k < 4 && set * 4 + k < all.size(); ++k) {
        joints[i * 4 + k] = all[set * 4 + k].slot;
        weights[i * 4 + k] = all[set * 4 + k].weight;
      }
    }
    const int j = c_.glb.accessor(joints, "VEC4", chosen.size());
    const int w = c_.glb.accessor(weights, "VEC4", chosen.size());
    c_.label("accessors", j, "joints of mesh " + name);
    c_.label("accessors", w, "weights of mesh " + name);
    attributes[fmt::format("JOINTS_{}", set)] = j;
    attributes[fmt::format("WEIGHTS_{}", set)] = w;
  }

  Conversion& c_;
  std::vector<Converted> converted_;  // by mesh
  std::vector<bool> known_;
  std::vector<Skin> skins_;
};

}  // namespace

void convert_meshes(Conversion& c) { Meshes(c).run(); }

}  // namespace crowdbench::scene::assimp_module
