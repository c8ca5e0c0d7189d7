// The hierarchy, in metres and with +Y up.
// Based on: Autodesk, "FBX SDK Programmer's Guide", FbxAxisSystem and FbxSystemUnit (a file's unit in centimetres; its
// up, front and right axes with their signs, which Assimp passes on as metadata and does not apply). Of COLLADA files
// Assimp puts both into the root's transform.
#include <cmath>
#include <string_view>

#include "scene/assimp/module/conversion.h"

namespace crowdbench::scene::assimp_module {
namespace {

struct Axis {
  int index;
  int sign;
};

Axis axis_of(const aiMetadata& settings, const std::string& name, Axis otherwise) {
  int32_t index = otherwise.index;
  int32_t sign = otherwise.sign;
  if (!settings.Get(name, index) || index < 0 || index > 2) return otherwise;
  if (!settings.Get(name + "Sign", sign) || (sign != 1 && sign != -1)) sign = 1;
  return {index, sign};
}

// From the file's axes and unit to ours: the columns of a row-major matrix say where its axes go.
aiMatrix4x4 metres_and_up(const aiScene& scene) {
  aiMatrix4x4 out;
  if (!scene.mMetaData) return out;
  const Axis right = axis_of(*scene.mMetaData, "CoordAxis", {0, 1});
  const Axis up = axis_of(*scene.mMetaData, "UpAxis", {1, 1});
  const Axis front = axis_of(*scene.mMetaData, "FrontAxis", {2, 1});
  if (right.index == up.index || up.index == front.index || front.index == right.index)
    throw Refusal{"states axes of which two are one"};
  double unit = 1.0;  // centimetres
  if (!scene.mMetaData->Get("UnitScaleFactor", unit)) {
    float single = 1.0F;
    if (scene.mMetaData->Get("UnitScaleFactor", single)) unit = single;
  }
  if (!std::isfinite(unit) || unit <= 0) throw Refusal{fmt::format("has a unit of {} cm", unit)};
  const auto metres = static_cast<float>(unit * 0.01);
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 3; ++column) out[row][column] = 0;
  out[0][right.index] = metres * static_cast<float>(right.sign);
  out[1][up.index] = metres * static_cast<float>(up.sign);
  out[2][front.index] = metres * static_cast<float>(front.sign);
  return out;
}

nlohmann::json vector_json(const aiVector3D& v) { return {v.x, v.y, v.z}; }

// What animations move needs translation, rotation and scale; all else keeps its matrix to the bit.
nlohmann::json transform_json(const aiMatrix4x4& m, bool moves) {
  if (m.IsIdentity()) return nlohmann::json::object();
  if (!moves) {
    nlohmann::json matrix = nlohmann::json::array();
    for (unsigned column = 0; column < 4; ++column)
      for (unsigned row = 0; row < 4; ++row) matrix.push_back(m[row][column]);
    return {{"matrix", matrix}};
  }
  aiVector3D scale;
  aiQuaternion rotation;
  aiVector3D translation;
  m.Decompose(scale, rotation, translation);
  return {{"translation", vector_json(translation)},
          {"rotation", {rotation.x, rotation.y, rotation.z, rotation.w}},
          {"scale", vector_json(scale)}};
}

std::set<std::string> moved_names(const aiScene& scene) {
  std::set<std::string> names;
  for (unsigned a = 0; a < scene.mNumAnimations; ++a)
    for (unsigned c = 0; c < scene.mAnimations[a]->mNumChannels; ++c)
      names.insert(scene.mAnimations[a]->mChannels[c]->mNodeName.C_Str());
  return names;
}

// Whether the node, or the one that an FBX pivot's helper nodes lead to, has meshes.
bool shows(const aiNode& node) {
  const aiNode* at = &node;
  while (at->mNumMeshes == 0 && at->mNumChildren == 1 &&
         std::string_view(at->mName.C_Str()).find("$AssimpFbx$") != std::string_view::npos)
    at = at->mChildren[0];
  return at->mNumMeshes > 0;
}

// Assimp names what bones and animations mean, and in FBX files a mesh may have the name of the bone that moves it.
// Such a name means the bone.
void find_names(Conversion& c, const std::set<std::string>& moved) {
  size_t unclear = 0;
  for (size_t i = 0; i < c.nodes.size(); ++i) {
    const std::string name = c.nodes[i]->mName.C_Str();
    const auto [place, fresh] = c.node_of_name.emplace(name, static_cast<int>(i));
    if (fresh) continue;
    const bool first_shows = shows(*c.nodes[static_cast<size_t>(place->second)]);
    if (first_shows == shows(*c.nodes[i]) && moved.contains(name)) ++unclear;
    if (first_shows && !shows(*c.nodes[i])) place->second = static_cast<int>(i);
  }
  if (unclear > 0)
    c.warn(fmt::format("{} moving nodes share a name with another; only the first of each name moves", unclear));
}

}  // namespace

void convert_nodes(Conversion& c) {
  c.nodes = {c.scene.mRootNode};
  const std::set<std::string> moved = moved_names(c.scene);
  for (size_t i = 0; i < c.nodes.size(); ++i) {
    const aiNode& node = *c.nodes[i];
    const std::string name = node.mName.C_Str();
    aiMatrix4x4 m = node.mTransformation;
    if (i == 0 && c.request.format == Format::fbx) m = metres_and_up(c.scene) * m;
    nlohmann::json out = transform_json(m, i != 0 && moved.contains(name));
    out["name"] = name;
    for (unsigned k = 0; k < node.mNumChildren; ++k) {
      out["children"].push_back(c.nodes.size());
      c.nodes.push_back(node.mChildren[k]);
    }
    c.label("nodes", c.glb.add("nodes", std::move(out)), "node " + shown(name));
  }
  find_names(c, moved);
  c.glb.document["scenes"] = {{{"nodes", {0}}}};
  c.glb.document["scene"] = 0;
}

}  // namespace crowdbench::scene::assimp_module
