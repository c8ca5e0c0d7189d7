// What a glTF document says of skins, nodes and scenes, and how much the scene that is shown adds up to.
#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>

#include "core/error.h"
#include "scene/gltf/gltf_check.h"
#include "scene/gltf/gltf_data.h"

namespace crowdbench::scene {
namespace {

using nlohmann::json;

class NodeCheck {
 public:
  NodeCheck(GltfCheck& check, const GltfData& data, const std::vector<GltfMeshSize>& meshes)
      : check_(check), data_(data), meshes_(meshes) {}

  void run() {
    if (check_.count_of("nodes") > check_.limits.nodes)
      check_.fail("/nodes", fmt::format("has {} nodes, more than the limit of {}", check_.count_of("nodes"),
                                        check_.limits.nodes));
    check_skins();
    check_hierarchy();
    check_scene();
    find_levels(check_.plan, coarser_, names_);
    check_totals();
  }

 private:
  void check_skins() {
    check_.each("skins", [&](const json& skin, const std::string& path) {
      GltfSkin out;
      check_.name_of(skin, path);
      const json* joints = check_.member(skin, "joints");
      if (!joints || !joints->is_array() || joints->empty()) check_.fail(path, "has no joints");
      std::set<int> seen;
      for (size_t i = 0; i < joints->size(); ++i) {
        const std::string where = check_.item(path + "/joints", i);
        const int node = check_.index((*joints)[i], where, "nodes");
        if (!seen.insert(node).second) check_.fail(where, fmt::format("names node {} twice", node));
        out.joints.push_back(node);
      }
      if (const auto bind = check_.index_or_none(skin, path, "inverseBindMatrices", "accessors")) {
        const std::string where = path + "/inverseBindMatrices";
        data_.require_format(*bind, where, {16}, {{kF32, 0}});
        if (data_.accessor(*bind).count < joints->size())
          check_.fail(where, fmt::format("has {} matrices for {} joints", data_.accessor(*bind).count, joints->size()));
        out.inverse_binds = *bind;
      }
      if (const auto root = check_.index_or_none(skin, path, "skeleton", "nodes")) out.skeleton = *root;
      check_.plan.model.skins.push_back(std::move(out));
    });
  }

  void check_hierarchy() {
    const size_t nodes = check_.count_of("nodes");
    check_.plan.node_parent.assign(nodes, -1);
    check_.plan.hidden.assign(nodes, false);
    children_.resize(nodes);
    coarser_.resize(nodes);
    names_.resize(nodes);
    size_t node = 0;
    check_.each("nodes", [&](const json& object, const std::string& path) { check_node(object, path, node++); });
    order_nodes();
  }

  void check_node(const json& node, const std::string& path, size_t self) {
    GltfNode out;
    out.name = check_.name_of(node, path);
    names_[self] = out.name;
    check_coarser(node, path, self);
    if (const json* visibility = check_.extension(node, path, "KHR_node_visibility"))
      if (const json* visible = check_.member(*visibility, "visible")) {
        if (!visible->is_boolean())
          check_.fail(path + "/extensions/KHR_node_visibility/visible",
                      fmt::format("is {}, not true or false", visible->type_name()));
        check_.plan.hidden[self] = !visible->get<bool>();
      }
    check_transform(node, path, out);
    if (const json* children = check_.member(node, "children")) {
      const std::string where = path + "/children";
      if (!children->is_array()) check_.fail(where, fmt::format("is {}, not an array", children->type_name()));
      for (size_t i = 0; i < children->size(); ++i) {
        const int child = check_.index((*children)[i], check_.item(where, i), "nodes");
        int& parent = check_.plan.node_parent[static_cast<size_t>(child)];
        if (static_cast<size_t>(child) == self)
          check_.fail(check_.item(where, i), fmt::format("makes node {} its own child", child));
        if (parent >= 0)
          check_.fail(check_.item(where, i),
                      fmt::format("node {} has two parents, nodes {} and {}", child, parent, self));
        parent = static_cast<int>(self);
        children_[self].push_back(child);
      }
    }
    const auto mesh = check_.index_or_none(node, path, "mesh", "meshes");
    const auto skin = check_.index_or_none(node, path, "skin", "skins");
    out.mesh = mesh.value_or(-1);
    out.skin = mesh && skin ? *skin : -1;
    if (mesh && skin) check_skinned(*mesh, path);
    check_.plan.model.nodes.push_back(std::move(out));
  }

  void check_transform(const json& node, const std::string& path, GltfNode& out) {
    const auto numbers = [&](const char* key, size_t count) -> std::optional<std::vector<double>> {
      const json* value = check_.member(node, key);
      if (!value) return std::nullopt;
      return check_.numbers(*value, path + "/" + key, count);
    };
    if (const auto m = numbers("matrix", 16)) {
      out.matrix.emplace();
      for (int i = 0; i < 16; ++i) (*out.matrix)[i / 4][i % 4] = (*m)[static_cast<size_t>(i)];
    }
    if (const auto v = numbers("translation", 3)) out.translation = glm::dvec3((*v)[0], (*v)[1], (*v)[2]);
    if (const auto v = numbers("scale", 3)) out.scale = glm::dvec3((*v)[0], (*v)[1], (*v)[2]);
    if (const auto q = numbers("rotation", 4)) out.rotation = glm::dquat((*q)[3], (*q)[0], (*q)[1], (*q)[2]);
    if (out.matrix && (out.translation || out.scale || out.rotation))
      check_.fail(path, "has both a matrix and a translation, rotation or scale");
    if (out.matrix) snap_last_row(*out.matrix, path + "/matrix");
    if (out.rotation && glm::dot(*out.rotation, *out.rotation) < 1e-12)
      check_.fail(path + "/rotation", "is a quaternion of length zero");
  }

  // MSFT_lod: the nodes that stand for this one where it is small.
  void check_coarser(const json& node, const std::string& path, size_t self) {
    const json* lod = check_.extension(node, path, "MSFT_lod");
    if (!lod) return;
    const std::string where = path + "/extensions/MSFT_lod/ids";
    const json* ids = check_.member(*lod, "ids");
    if (!ids || !ids->is_array()) check_.fail(where, "is not an array of nodes");
    for (size_t i = 0; i < ids->size(); ++i) {
      const int other = check_.index((*ids)[i], check_.item(where, i), "nodes");
      if (static_cast<size_t>(other) == self || !named_coarser_.insert(other).second)
        check_.fail(check_.item(where, i), fmt::format("names node {} a second time", other));
      coarser_[self].push_back(other);
    }
  }

  // Exporters that multiply matrices leave rounding in the last row; the specification wants exactly (0, 0, 0, 1).
  void snap_last_row(glm::dmat4& m, const std::string& path) {
    constexpr double kRounding = 1e-6;
    bool exact = true;
    for (int column = 0; column < 4; ++column) {
      const double wanted = column == 3 ? 1.0 : 0.0;
      double& value = m[column][3];
      const double off = std::abs(value - wanted);
      if (off > kRounding)
        check_.fail(path, fmt::format("is not affine: element {} is {:.9g}, not {}", 4 * column + 3, value, wanted),
                    "the last row must be (0, 0, 0, 1): export the node with translation, rotation and scale");
      exact = exact && off == 0;
      value = wanted;
    }
    if (!exact) check_.warn_once(path, "its last row is (0, 0, 0, 1) but for rounding and is snapped");
  }

  void check_skinned(int mesh, const std::string& path) {
    if (!skinned_checked_.insert(mesh).second) return;
    const std::vector<GltfPrimitive>& primitives = check_.plan.model.meshes[static_cast<size_t>(mesh)];
    for (size_t i = 0; i < primitives.size(); ++i)
      if (primitives[i].mode >= kGltfTriangles && !primitives[i].attributes.contains("JOINTS_0"))
        check_.fail(fmt::format("/meshes/{}/primitives/{}/attributes", mesh, i),
                    fmt::format("has no JOINTS_0, but {} gives it a skin", path));
  }

  void order_nodes() {
    const size_t nodes = children_.size();
    std::vector<int> stack;
    for (size_t i = nodes; i-- > 0;)
      if (check_.plan.node_parent[i] < 0) stack.push_back(static_cast<int>(i));
    while (!stack.empty()) {
      const int node = stack.back();
      stack.pop_back();
      check_.plan.node_order.push_back(node);
      const std::vector<int>& below = children_[static_cast<size_t>(node)];
      stack.insert(stack.end(), below.rbegin(), below.rend());
    }
    if (check_.plan.node_order.size() == nodes) return;
    // Every node has one parent at most, so what no root reaches is a cycle and what hangs from it.
    std::vector<bool> reached(nodes, false);
    for (const int node : check_.plan.node_order) reached[static_cast<size_t>(node)] = true;
    const auto lost = static_cast<size_t>(std::find(reached.begin(), reached.end(), false) - reached.begin());
    check_.fail(fmt::format("/nodes/{}", lost), "belongs to a cycle of parents and children");
  }

  void check_scene() {
    const size_t nodes = children_.size();
    check_.plan.in_scene.assign(nodes, false);
    std::vector<int> roots;
    bool first = true;
    const auto wanted = check_.index_or_none(check_.root(), "", "scene", "scenes").value_or(0);
    size_t scene_index = 0;
    check_.each("scenes", [&](const json& scene, const std::string& path) {
      first = false;
      const bool chosen = scene_index++ == static_cast<size_t>(wanted);
      const json* list = check_.member(scene, "nodes");
      if (!list) return;
      if (!list->is_array()) check_.fail(path + "/nodes", fmt::format("is {}, not an array", list->type_name()));
      std::set<int> seen;
      for (size_t i = 0; i < list->size(); ++i) {
        const std::string where = check_.item(path + "/nodes", i);
        const int node = check_.index((*list)[i], where, "nodes");
        if (!seen.insert(node).second) check_.fail(where, fmt::format("names node {} twice", node));
        const int parent = check_.plan.node_parent[static_cast<size_t>(node)];
        if (parent >= 0) check_.fail(where, fmt::format("names node {}, which is a child of node {}", node, parent));
        if (chosen) roots.push_back(node);
      }
    });
    if (first) {
      if (nodes != 0) check_.warn("has no scene; every root node is shown");
      for (size_t i = 0; i < nodes; ++i)
        if (check_.plan.node_parent[i] < 0) roots.push_back(static_cast<int>(i));
    }
    for (const int root : roots) check_.plan.in_scene[static_cast<size_t>(root)] = true;
    for (const int node : check_.plan.node_order) {
      const int parent = check_.plan.node_parent[static_cast<size_t>(node)];
      if (parent >= 0 && check_.plan.in_scene[static_cast<size_t>(parent)])
        check_.plan.in_scene[static_cast<size_t>(node)] = true;
    }
  }

  // Counts before anything is allocated: a mesh on many nodes multiplies.
  void check_totals() {
    size_t primitives = 0;
    std::set<int> skins;
    size_t palette = 0;
    const GltfModel& model = check_.plan.model;
    for (size_t i = 0; i < model.nodes.size(); ++i) {
      const auto [mesh, skin] = std::pair(model.nodes[i].mesh, model.nodes[i].skin);
      if (mesh < 0 || !check_.plan.in_scene[i]) continue;
      const std::string path = fmt::format("/nodes/{}", i);
      const GltfMeshSize& size = meshes_[static_cast<size_t>(mesh)];
      primitives += size.primitives;
      check_.plan.vertices += size.vertices;
      check_.plan.triangles += size.triangles;
      const auto bound = [&](size_t have, size_t limit, const char* what) {
        if (have > limit)
          check_.fail(path, fmt::format("brings the scene to {} {}, the limit is {}", have, what, limit));
      };
      bound(primitives, check_.limits.primitives, "primitives");
      bound(check_.plan.vertices, check_.limits.vertices, "vertices");
      bound(check_.plan.triangles, check_.limits.triangles, "triangles");
      if (skin < 0) {
        ++palette;
      } else if (skins.insert(skin).second) {
        palette += model.skins[static_cast<size_t>(skin)].joints.size();
      }
      bound(palette, check_.limits.joints, "joints and rigid meshes");
    }
  }

  GltfCheck& check_;
  const GltfData& data_;
  const std::vector<GltfMeshSize>& meshes_;
  std::vector<std::vector<int>> children_;
  std::vector<std::vector<int>> coarser_;
  std::set<int> named_coarser_;
  std::vector<std::string> names_;
  std::set<int> skinned_checked_;
};

}  // namespace

void check_nodes(GltfCheck& check, const GltfData& data, const std::vector<GltfMeshSize>& meshes) {
  NodeCheck(check, data, meshes).run();
}

}  // namespace crowdbench::scene
