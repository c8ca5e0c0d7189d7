// Based on: Microsoft, "MSFT_lod" (glTF vendor extension), and the names that exporters and engines share: a base name
// and _LOD0, _LOD1, ... at its end.
#include <algorithm>
#include <cassert>
#include <cctype>
#include <charconv>
#include <map>
#include <optional>
#include <string_view>

#include "scene/gltf/gltf_check.h"

namespace crowdbench::scene {
namespace {

constexpr int kMostLevels = 64;

struct NamedLevel {
  std::string base;  // lower case
  int level = 0;
};

// "Body_LOD1": "body" and 1. The word is set off by one of "_-. " or is all of the name.
std::optional<NamedLevel> level_in(std::string_view name) {
  size_t digits = name.size();
  while (digits > 0 && std::isdigit(static_cast<unsigned char>(name[digits - 1])) != 0) --digits;
  if (digits == name.size() || name.size() - digits > 2) return std::nullopt;
  std::string front(name.substr(0, digits));
  for (char& c : front) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  if (front.ends_with('_')) front.pop_back();
  if (!front.ends_with("lod")) return std::nullopt;
  front.resize(front.size() - 3);
  if (!front.empty()) {
    if (std::string_view("_-. ").find(front.back()) == std::string_view::npos) return std::nullopt;
    front.pop_back();
  }
  NamedLevel out{std::move(front), 0};
  std::from_chars(name.data() + digits, name.data() + name.size(), out.level);
  if (out.level >= kMostLevels) return std::nullopt;
  return out;
}

// Trees of nodes that grow together: by the root of each.
class Roots {
 public:
  explicit Roots(const GltfPlan& plan) : above_(plan.node_parent) {}
  size_t of(size_t node) {
    size_t root = node;
    while (above_[root] >= 0) root = static_cast<size_t>(above_[root]);
    while (above_[node] >= 0) {
      const auto next = static_cast<size_t>(above_[node]);
      above_[node] = static_cast<int>(root);
      node = next;
    }
    return root;
  }
  void hang(size_t root, size_t below) { above_[root] = static_cast<int>(below); }

 private:
  std::vector<int> above_;
};

// Nodes that MSFT_lod names are mostly below no root: they hang where the finest one does, if they do not hold it.
void adopt(GltfPlan& plan, Roots& roots, size_t finest, size_t coarser) {
  if (plan.node_parent[coarser] >= 0 || plan.in_scene[coarser]) return;
  plan.in_scene[coarser] = plan.in_scene[finest];
  const int parent = plan.node_parent[finest];
  if (parent < 0 || roots.of(finest) == coarser) return;
  plan.node_parent[coarser] = parent;
  roots.hang(coarser, static_cast<size_t>(parent));
}

// Parents before children again, in the order that there was.
void order_again(GltfPlan& plan) {
  std::vector<std::vector<int>> children(plan.node_parent.size());
  std::vector<int> stack;
  for (const int node : plan.node_order)
    if (const int parent = plan.node_parent[static_cast<size_t>(node)]; parent >= 0)
      children[static_cast<size_t>(parent)].push_back(node);
  for (size_t i = plan.node_order.size(); i-- > 0;)
    if (plan.node_parent[static_cast<size_t>(plan.node_order[i])] < 0) stack.push_back(plan.node_order[i]);
  std::vector<int> order;
  while (!stack.empty()) {
    const int node = stack.back();
    stack.pop_back();
    order.push_back(node);
    const std::vector<int>& below = children[static_cast<size_t>(node)];
    stack.insert(stack.end(), below.rbegin(), below.rend());
  }
  assert(order.size() == plan.node_order.size());
  plan.node_order = std::move(order);
}

}  // namespace

void find_levels(GltfPlan& plan, const std::vector<std::vector<int>>& below, const std::vector<std::string>& names) {
  const size_t nodes = names.size();
  plan.lod_group.assign(nodes, -1);
  plan.lod.assign(nodes, 0);
  int groups = 0;
  Roots roots(plan);
  for (size_t i = 0; i < nodes; ++i) {
    if (below[i].empty()) continue;
    plan.lod_group[i] = groups;
    int level = 0;
    for (const int coarser : below[i]) {
      adopt(plan, roots, i, static_cast<size_t>(coarser));
      plan.lod_group[static_cast<size_t>(coarser)] = groups;
      plan.lod[static_cast<size_t>(coarser)] = std::min(++level, kMostLevels - 1);
    }
    ++groups;
  }
  if (groups > 0) order_again(plan);

  std::map<std::string, std::map<int, std::vector<size_t>>> named;  // base, level, nodes
  for (size_t i = 0; i < nodes; ++i)
    if (plan.lod_group[i] < 0)
      if (const auto found = level_in(names[i])) named[found->base][found->level].push_back(i);
  for (const auto& [base, levels] : named) {
    if (levels.size() < 2) continue;  // nothing to choose from
    int level = 0;
    for (const auto& [number, members] : levels) {
      for (const size_t i : members) {
        plan.lod_group[i] = groups;
        plan.lod[i] = level;
      }
      ++level;
    }
    ++groups;
  }
  for (const int node : plan.node_order) {
    const auto self = static_cast<size_t>(node);
    const int parent = plan.node_parent[self];
    if (parent < 0) continue;
    const auto above = static_cast<size_t>(parent);
    if (plan.in_scene[above]) plan.in_scene[self] = true;
    if (plan.lod_group[self] >= 0 || plan.lod_group[above] < 0) continue;
    plan.lod_group[self] = plan.lod_group[above];
    plan.lod[self] = plan.lod[above];
  }
}

}  // namespace crowdbench::scene
