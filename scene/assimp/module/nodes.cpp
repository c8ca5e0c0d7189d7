// The hierarchy, in metres and with +Y up.
// Based on: Autodesk, "FBX SDK Programmer's Guide", FbxAxisSystem and FbxSystemUnit (a file's unit in centimetres; its
// up, front and right axes with their signs, which Assimp passes on as metadata and does not apply). Of COLLADA files
// Assimp puts both into the root's transform.
#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
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

bool is_pivot(const aiNode& node) {
  return std::string_view(node.mName.C_Str()).find("$AssimpFbx$") != std::string_view::npos;
}

// Whether the node, or the one that an FBX pivot's helper nodes lead to, has meshes.
bool shows(const aiNode& node) {
  const aiNode* at = &node;
  while (at->mNumMeshes == 0 && at->mNumChildren == 1 && is_pivot(*at)) at = at->mChildren[0];
  return at->mNumMeshes > 0;
}

class Nodes {
 public:
  explicit Nodes(Conversion& c) : c_(c), moved_(moved_names(c.scene)) {}

  void run() {
    collect();
    fold_pivots();
    write();
    find_names();
  }

 private:
  bool moves(size_t node) const { return moved_.contains(c_.nodes[node]->mName.C_Str()); }

  void collect() {
    c_.nodes = {c_.scene.mRootNode};
    parents_ = {0};
    for (size_t i = 0; i < c_.nodes.size(); ++i) {
      const aiNode& node = *c_.nodes[i];
      local_.push_back(node.mTransformation);
      c_.nodes.insert(c_.nodes.end(), node.mChildren, node.mChildren + node.mNumChildren);
      parents_.insert(parents_.end(), node.mNumChildren, i);
    }
    if (c_.request.format == Format::fbx) local_[0] = metres_and_up(c_.scene) * local_[0];
  }

  // Where a node has no pivot but is turned before its own rotation, Assimp 5.2 makes a helper node of that turn and
  // yet animates the node by its whole transform. What its helpers do goes into the node then, and they do nothing.
  void fold_pivots() {
    if (c_.request.format != Format::fbx) return;
    for (size_t i = 1; i < c_.nodes.size(); ++i) {
      if (!moves(i) || is_pivot(*c_.nodes[i])) continue;
      const std::string prefix = std::string(c_.nodes[i]->mName.C_Str()) + "_$AssimpFbx$_";
      std::vector<size_t> helpers;
      const auto helps = [&](size_t n) { return std::string_view(c_.nodes[n]->mName.C_Str()).starts_with(prefix); };
      for (size_t at = parents_[i]; at != 0 && helps(at); at = parents_[at]) helpers.push_back(at);
      if (std::any_of(helpers.begin(), helpers.end(), [&](size_t n) { return moves(n); })) continue;
      for (const size_t helper : helpers) {
        local_[i] = local_[helper] * local_[i];
        local_[helper] = aiMatrix4x4();
      }
    }
  }

  void write() {
    for (size_t i = 0; i < c_.nodes.size(); ++i) {
      const std::string name = c_.nodes[i]->mName.C_Str();
      nlohmann::json out = transform_json(local_[i], i != 0 && moves(i));
      out["name"] = name;
      c_.label("nodes", c_.glb.add("nodes", std::move(out)), "node " + shown(name));
    }
    for (size_t i = 1; i < c_.nodes.size(); ++i) c_.glb.document()["nodes"][parents_[i]]["children"].push_back(i);
    c_.glb.document()["scenes"] = {{{"nodes", {0}}}};
    c_.glb.document()["scene"] = 0;
  }

  // Assimp names what bones and animations mean, and in FBX files a mesh may have the name of the bone that moves it.
  // Such a name means the bone.
  void find_names() {
    size_t unclear = 0;
    for (size_t i = 0; i < c_.nodes.size(); ++i) {
      const auto [place, fresh] = c_.node_of_name.emplace(c_.nodes[i]->mName.C_Str(), static_cast<int>(i));
      if (fresh) continue;
      const bool first_shows = shows(*c_.nodes[static_cast<size_t>(place->second)]);
      if (first_shows == shows(*c_.nodes[i]) && moves(i)) ++unclear;
      if (first_shows && !shows(*c_.nodes[i])) place->second = static_cast<int>(i);
    }
    if (unclear > 0)
      c_.warn(fmt::format("{} moving nodes share a name with another; only the first of each name moves", unclear));
  }

  Conversion& c_;
  const std::set<std::string> moved_;
  std::vector<size_t> parents_;  // the root's is itself
  std::vector<aiMatrix4x4> local_;
};

}  // namespace

void convert_nodes(Conversion& c) { Nodes(c).run(); }

}  // namespace crowdbench::scene::assimp_module
