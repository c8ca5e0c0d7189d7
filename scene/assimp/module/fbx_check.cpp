#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "scene/assimp/module/conversion.h"
#include "scene/assimp/module/fbx_reader.h"
#include "scene/assimp/module/source_check.h"

namespace crowdbench::scene::assimp_module {
namespace {

// "Geometry::body" and "body\0\1Geometry" are body.
std::string plain_fbx_name(const FbxNode& node) {
  if (node.strings.empty()) return {};
  const std::string& full = node.strings[0];
  if (const size_t end = full.find('\0'); end != std::string::npos) return full.substr(0, end);
  const size_t colons = full.find("::");
  return colons == std::string::npos ? full : full.substr(colons + 2);
}

struct FbxLayer {
  std::string kind;  // of the list: "Normals", "UV", "Colors"
  std::string mapping;
  bool by_index = false;
  uint64_t values = 0;
  std::vector<double> indices;
  bool has_indices = false;
};

struct FbxMesh {
  std::string name;
  uint64_t numbers = 0;
  std::vector<double> corners;
  std::vector<FbxLayer> layers;
  uint64_t vertices() const { return numbers / 3; }
};

struct FbxCluster {
  std::string name;
  std::vector<double> indices;
  uint64_t weights = 0;
};

struct FbxCurve {
  std::vector<double> times;
  uint64_t values = 0;
};

uint64_t components(const std::string& kind) { return kind == "UV" ? 2 : kind == "Colors" ? 4 : 3; }

void check_corners(const FbxMesh& mesh) {
  const std::string name = "mesh " + shown(mesh.name);
  if (mesh.numbers % 3 != 0)
    throw Refusal{fmt::format("{}: Vertices holds {} numbers, which is not three a vertex", name, mesh.numbers)};
  for (size_t i = 0; i < mesh.corners.size(); ++i) {
    const double vertex = mesh.corners[i] < 0 ? -mesh.corners[i] - 1 : mesh.corners[i];
    if (!(vertex < static_cast<double>(mesh.vertices())))
      throw Refusal{fmt::format("{}: index {} of PolygonVertexIndex names vertex {:.0f} of {}", name, i, vertex,
                                mesh.vertices())};
  }
  if (!mesh.corners.empty() && mesh.corners.back() >= 0)
    throw Refusal{fmt::format("{}: PolygonVertexIndex ends within a polygon", name)};
}

void check_layer(const FbxMesh& mesh, const FbxLayer& layer) {
  const std::string name = "mesh " + shown(mesh.name);
  const uint64_t values = layer.values / components(layer.kind);
  for (size_t i = 0; layer.by_index && i < layer.indices.size(); ++i)
    if (layer.indices[i] != -1 && !(layer.indices[i] >= 0 && layer.indices[i] < static_cast<double>(values)))
      throw Refusal{fmt::format("{}: index {} of {}Index names element {:.0f} of {}", name, i, layer.kind,
                                layer.indices[i], values)};
  const bool by_corner = layer.mapping == "ByPolygonVertex";
  if (!by_corner && layer.mapping != "ByVertice" && layer.mapping != "ByVertex") return;
  const uint64_t needed = by_corner ? mesh.corners.size() : mesh.vertices();
  if (layer.by_index && !layer.has_indices) return;
  const uint64_t given = layer.by_index ? layer.indices.size() : values;
  if (given != needed)
    throw Refusal{fmt::format("{}: {}{} has {} elements for {} {}", name, layer.kind, layer.by_index ? "Index" : "",
                              given, needed, by_corner ? "corners" : "vertices")};
}

class FbxChecks : public FbxVisitor {
 public:
  bool wants(const std::string& name) const override {
    return name == "PolygonVertexIndex" || name == "NormalsIndex" || name == "NormalIndex" || name == "UVIndex" ||
           name == "ColorIndex" || name == "Indexes" || name == "KeyTime";
  }

  void begin(const std::vector<std::string>& path, const FbxNode& node) override {
    if (path.empty()) return;
    if (path.size() == 1 && path[0] == "Objects") object(node);
    if (path[0] == "Connections" && node.numbers.size() >= 2) connect(node);
    if (path.size() < 2 || path[0] != "Objects") return;
    if (mesh_) in_mesh(path, node);
    if (cluster_ && path.size() == 2) in_cluster(node);
    if (curve_ && path.size() == 2) in_curve(node);
  }

  void end(const std::vector<std::string>& path, const std::string& /*name*/) override {
    if (path.size() != 1 || path[0] != "Objects") return;
    if (mesh_) check_mesh(*mesh_);
    mesh_ = nullptr;
    cluster_ = nullptr;
    curve_ = nullptr;
  }

  void finish() const {
    for (const auto& [id, cluster] : clusters_) check_cluster(id, cluster);
    for (const auto& [id, curve] : curves_) check_curve(id, curve);
    std::map<int64_t, bool> seen;
    for (const auto& [id, name] : models_) check_above(id, seen);
  }

 private:
  void object(const FbxNode& node) {
    const int64_t id = node.numbers.empty() ? --unnumbered_ : static_cast<int64_t>(node.numbers[0]);
    const std::string name = plain_fbx_name(node);
    const std::string kind = node.strings.empty() ? "" : node.strings.back();
    if (node.name == "Geometry" || (node.name == "Model" && node.numbers.empty())) {
      mesh_ = &(meshes_[id] = {});
      mesh_->name = name;
    }
    if (node.name == "Model" && !node.numbers.empty()) models_[id] = name;
    if (node.name == "Deformer" && kind == "Cluster") {
      cluster_ = &(clusters_[id] = {});
      cluster_->name = name;
    }
    if (node.name == "AnimationCurve") curve_ = &(curves_[id] = {});
  }

  // A list that says how long it is.
  void same_length(const std::string& owner, const FbxNode& node) const {
    if (node.declared >= 0 && static_cast<uint64_t>(node.declared) != node.count)
      throw Refusal{fmt::format("{}: {} says {} numbers and holds {}", owner, node.name, node.declared, node.count)};
  }

  void in_mesh(const std::vector<std::string>& path, const FbxNode& node) {
    FbxMesh& mesh = *mesh_;
    const bool layer = path.size() == 3 && path[2].starts_with("LayerElement");
    if (path.size() == 2 || layer) same_length("mesh " + shown(mesh.name), node);
    if (path.size() == 2 && node.name == "Vertices") mesh.numbers = node.count;
    if (path.size() == 2 && node.name == "PolygonVertexIndex") mesh.corners = node.numbers;
    if (path.size() == 2 && node.name.starts_with("LayerElement")) mesh.layers.emplace_back();
    if (layer && !mesh.layers.empty()) in_layer(mesh.layers.back(), node);
  }

  static void in_layer(FbxLayer& layer, const FbxNode& node) {
    if (node.name == "MappingInformationType" && !node.strings.empty()) layer.mapping = node.strings[0];
    if (node.name == "ReferenceInformationType" && !node.strings.empty()) layer.by_index = node.strings[0] != "Direct";
    if (node.name == "Normals" || node.name == "UV" || node.name == "Colors") {
      layer.kind = node.name;
      layer.values = node.count;
    }
    if (node.name == "NormalsIndex" || node.name == "NormalIndex" || node.name == "UVIndex" ||
        node.name == "ColorIndex") {
      layer.indices = node.numbers;
      layer.has_indices = true;
    }
  }

  void in_cluster(const FbxNode& node) {
    same_length("bone " + shown(cluster_->name), node);
    if (node.name == "Indexes") cluster_->indices = node.numbers;
    if (node.name == "Weights") cluster_->weights = node.count;
  }

  void in_curve(const FbxNode& node) {
    same_length("an animation curve", node);
    if (node.name == "KeyTime") curve_->times = node.numbers;
    if (node.name == "KeyValueFloat") curve_->values = node.count;
  }

  static void check_mesh(const FbxMesh& mesh) {
    if (mesh.numbers == 0 && mesh.corners.empty()) return;
    check_corners(mesh);
    for (const FbxLayer& layer : mesh.layers)
      if (!layer.kind.empty()) check_layer(mesh, layer);
  }

  void connect(const FbxNode& node) {
    above_.emplace(static_cast<int64_t>(node.numbers[0]), static_cast<int64_t>(node.numbers[1]));
  }

  // The first of `in` that stands above, at most so many steps.
  template <typename Of>
  const Of* owner(int64_t id, const std::map<int64_t, Of>& in, int steps) const {
    const auto [first, last] = above_.equal_range(id);
    for (auto it = first; it != last; ++it) {
      if (const auto found = in.find(it->second); found != in.end()) return &found->second;
      if (steps > 1)
        if (const Of* found = owner(it->second, in, steps - 1)) return found;
    }
    return nullptr;
  }

  void check_cluster(int64_t id, const FbxCluster& cluster) const {
    const FbxMesh* mesh = owner(id, meshes_, 2);
    const std::string where =
        fmt::format("{}bone {}", mesh ? fmt::format("mesh {}: ", shown(mesh->name)) : "", shown(cluster.name));
    if (cluster.indices.size() != cluster.weights)
      throw Refusal{fmt::format("{} has {} indices and {} weights", where, cluster.indices.size(), cluster.weights)};
    for (size_t i = 0; mesh && i < cluster.indices.size(); ++i)
      if (!(cluster.indices[i] >= 0 && cluster.indices[i] < static_cast<double>(mesh->vertices())))
        throw Refusal{fmt::format("{}: index {} of Indexes names vertex {:.0f} of {}", where, i, cluster.indices[i],
                                  mesh->vertices())};
  }

  void check_curve(int64_t id, const FbxCurve& curve) const {
    const std::string* node = owner(id, models_, 2);
    const std::string where = node ? fmt::format("a curve of node {}", shown(*node)) : fmt::format("curve {}", id);
    if (curve.times.size() != curve.values)
      throw Refusal{fmt::format("{} has {} key times and {} values", where, curve.times.size(), curve.values)};
    for (size_t k = 1; k < curve.times.size(); ++k)
      if (!(curve.times[k] >= curve.times[k - 1]))
        throw Refusal{fmt::format("{}: key {} of KeyTime lies before the one in front", where, k)};
  }

  // seen: of models, false while what stands above them is followed.
  void check_above(int64_t id, std::map<int64_t, bool>& seen) const {
    std::vector<std::pair<int64_t, bool>> stack = {{id, false}};
    while (!stack.empty()) {
      const auto [at, done] = stack.back();
      stack.pop_back();
      if (done) {
        seen[at] = true;
        continue;
      }
      const auto [place, fresh] = seen.emplace(at, false);
      if (!fresh && place->second) continue;
      if (!fresh) throw Refusal{fmt::format("node {} is its own ancestor", shown(models_.at(at)))};
      stack.emplace_back(at, true);
      const auto [first, last] = above_.equal_range(at);
      for (auto it = first; it != last; ++it)
        if (models_.contains(it->second)) stack.emplace_back(it->second, false);
    }
  }

  std::map<int64_t, FbxMesh> meshes_;
  std::map<int64_t, FbxCluster> clusters_;
  std::map<int64_t, FbxCurve> curves_;
  std::map<int64_t, std::string> models_;
  std::multimap<int64_t, int64_t> above_;
  FbxMesh* mesh_ = nullptr;
  FbxCluster* cluster_ = nullptr;
  FbxCurve* curve_ = nullptr;
  int64_t unnumbered_ = 0;
};

}  // namespace

void check_fbx(std::span<const uint8_t> bytes) {
  FbxChecks checks;
  walk_fbx(bytes, checks);
  checks.finish();
}

}  // namespace crowdbench::scene::assimp_module
