// Based on: H. Hoppe et al., "Mesh optimization" (1993), for the condition that keeps a surface's connections; the
// half-edge collapse is that of M. Garland and P. Heckbert (1997), restricted to the ends of the edge.
#include "scene/character/collapse.h"

#include <algorithm>
#include <map>
#include <tuple>

namespace crowdbench::scene {
namespace {

template <typename T>
void sort_unique(std::vector<T>& list) {
  std::sort(list.begin(), list.end());
  list.erase(std::unique(list.begin(), list.end()), list.end());
}

}  // namespace

bool is_textured(const Material& material) { return material.base_colour_image >= 0 || material.emissive_image >= 0; }

CollapsingMesh::CollapsingMesh(const Character& character, std::span<const std::vector<glm::vec3>> poses,
                               std::vector<uint32_t> point_of)
    : character_(character), poses_(poses), point_of_(std::move(point_of)) {
  const Mesh& mesh = character.mesh;
  around_.resize(mesh.positions.size());
  vertex_primitive_.resize(mesh.positions.size());
  live_of_material_.resize(character.materials.size());
  for (uint32_t p = 0; p < mesh.primitives.size(); ++p) {
    const Primitive& primitive = mesh.primitives[p];
    for (uint32_t v = 0; v < primitive.vertex_count; ++v) vertex_primitive_[primitive.first_vertex + v] = p;
    for (uint32_t i = primitive.first_index; i + 2 < primitive.first_index + primitive.index_count; i += 3) {
      const auto t = static_cast<uint32_t>(faces_.size());
      faces_.push_back({mesh.indices[i], mesh.indices[i + 1], mesh.indices[i + 2]});
      primitive_of_.push_back(p);
      dead_.push_back(false);
      ++live_of_material_[static_cast<size_t>(primitive.material)];
      ++live_;
      for (const uint32_t v : faces_.back()) around_[point_of_[v]].push_back(t);
    }
  }
  name_charts();
  for (uint32_t t = 0; t < faces_.size(); ++t) {
    const auto [a, b, c] = faces_[t];
    if (point_of_[a] == point_of_[b] || point_of_[b] == point_of_[c] || point_of_[c] == point_of_[a]) kill(t);
  }
}

void CollapsingMesh::name_charts() {
  const Mesh& mesh = character_.mesh;
  using Key = std::tuple<uint32_t, uint32_t, std::array<float, 8>>;
  std::map<Key, uint32_t> first;
  chart_of_.resize(mesh.positions.size());
  for (uint32_t v = 0; v < mesh.positions.size(); ++v) {
    std::array<float, 8> look{};
    const uint32_t p = vertex_primitive_[v];
    const bool textured =
        !mesh.primitives.empty() && is_textured(character_.materials[static_cast<size_t>(mesh.primitives[p].material)]);
    if (textured) std::copy_n(&mesh.uvs[v].x, 2, look.begin());
    if (textured && !mesh.emissive_uvs.empty()) std::copy_n(&mesh.emissive_uvs[v].x, 2, look.begin() + 2);
    if (!mesh.colours.empty()) std::copy_n(&mesh.colours[v].x, 4, look.begin() + 4);
    chart_of_[v] = first.try_emplace({point_of_[v], p, look}, v).first->second;
  }
}

std::optional<uint32_t> CollapsingMesh::corner_at(uint32_t triangle, uint32_t point) const {
  for (const uint32_t v : faces_[triangle])
    if (point_of_[v] == point) return v;
  return std::nullopt;
}

std::vector<uint32_t> CollapsingMesh::neighbours(uint32_t point) const {
  std::vector<uint32_t> out;
  for (const uint32_t t : around_[point])
    if (!dead_[t])
      for (const uint32_t v : faces_[t])
        if (point_of_[v] != point) out.push_back(point_of_[v]);
  sort_unique(out);
  return out;
}

size_t CollapsingMesh::count_with(uint32_t a, uint32_t b) const {
  return static_cast<size_t>(
      std::ranges::count_if(around_[a], [&](uint32_t t) { return !dead_[t] && corner_at(t, b).has_value(); }));
}

std::vector<uint32_t> CollapsingMesh::vertices_at(uint32_t point) const {
  std::vector<uint32_t> out;
  for (const uint32_t t : around_[point])
    if (!dead_[t]) out.push_back(*corner_at(t, point));
  sort_unique(out);
  return out;
}

// Of the vertices `there` that are of the same primitive (and of the chart, where one is named), the one that looks
// most like this one; itself where there is none.
uint32_t CollapsingMesh::best_of(uint32_t vertex, std::span<const uint32_t> there,
                                 std::optional<uint32_t> chart) const {
  const Mesh& mesh = character_.mesh;
  uint32_t best = vertex;
  float least = 0;
  for (const uint32_t other : there) {
    if (vertex_primitive_[other] != vertex_primitive_[vertex] || (chart && chart_of_[other] != *chart)) continue;
    float apart = 1 - glm::dot(mesh.normals[vertex], mesh.normals[other]);
    if (!chart && !mesh.uvs.empty()) apart += 4 * glm::length(mesh.uvs[vertex] - mesh.uvs[other]);
    if (best == vertex || apart < least) {
      best = other;
      least = apart;
    }
  }
  return best;
}

std::optional<CollapsingMesh::Moves> CollapsingMesh::moves(uint32_t from, uint32_t to, Care care) const {
  Moves out;
  std::map<uint32_t, uint32_t> chart_goes;  // chart at `from` to chart at `to`, along an edge
  std::map<uint32_t, uint32_t> vertex_goes;
  for (const uint32_t t : around_[from]) {
    if (dead_[t]) continue;
    const auto b = corner_at(t, to);
    if (!b) continue;
    const uint32_t a = *corner_at(t, from);
    const auto [known, fresh] = chart_goes.try_emplace(chart_of_[a], chart_of_[*b]);
    if (!fresh && known->second != chart_of_[*b] && care == Care::whole) return std::nullopt;  // the end of a seam
    vertex_goes.try_emplace(a, *b);
  }
  const std::vector<uint32_t> there = vertices_at(to);
  for (const uint32_t a : vertices_at(from)) {
    uint32_t b = a;
    if (const auto known = vertex_goes.find(a); known != vertex_goes.end())
      b = known->second;
    else if (const auto chart = chart_goes.find(chart_of_[a]); chart != chart_goes.end())
      b = best_of(a, there, chart->second);
    else if (care == Care::loose)
      b = best_of(a, there, std::nullopt);
    if (b == a) return std::nullopt;
    out.emplace_back(a, b);
  }
  return out;
}

bool CollapsingMesh::keeps_materials(uint32_t from, uint32_t to) const {
  std::map<size_t, size_t> lost;
  for (const uint32_t t : around_[from])
    if (!dead_[t] && corner_at(t, to))
      ++lost[static_cast<size_t>(character_.mesh.primitives[primitive_of_[t]].material)];
  return std::ranges::all_of(lost, [&](const auto& l) { return live_of_material_[l.first] > l.second; });
}

bool CollapsingMesh::keeps_connections(uint32_t from, uint32_t to) const {
  const std::vector<uint32_t> a = neighbours(from);
  const std::vector<uint32_t> b = neighbours(to);
  std::vector<uint32_t> common;
  std::set_intersection(a.begin(), a.end(), b.begin(), b.end(), std::back_inserter(common));
  const size_t shared = count_with(from, to);
  if (common.size() != shared || shared > 2) return false;
  if (shared == 1) return true;
  // A border moves along itself only: a point of it may not be drawn into the surface.
  return std::ranges::none_of(a, [&](uint32_t p) { return count_with(from, p) == 1; });
}

bool CollapsingMesh::turns_over(uint32_t triangle, uint32_t from, uint32_t to, Care care) const {
  float worst = 1;
  float sum = 0;
  for (const std::vector<glm::vec3>& pose : poses_) {
    std::array<glm::vec3, 3> before;
    std::array<glm::vec3, 3> after;
    for (size_t i = 0; i < 3; ++i) {
      const uint32_t point = point_of_[faces_[triangle][i]];
      before[i] = pose[point];
      after[i] = pose[point == from ? to : point];
    }
    const glm::vec3 n = glm::cross(before[1] - before[0], before[2] - before[0]);
    const glm::vec3 m = glm::cross(after[1] - after[0], after[2] - after[0]);
    const float scale = glm::length(n) * glm::length(m);
    const float cosine = scale > 0 ? glm::dot(n, m) / scale : 1.0F;
    worst = std::min(worst, cosine);
    sum += cosine;
  }
  constexpr float kLeast = 0.2F;  // within 78 degrees
  return (care == Care::whole ? worst : sum / static_cast<float>(poses_.size())) < kLeast;
}

bool CollapsingMesh::is_sound(uint32_t from, uint32_t to, Care care) const {
  if (!keeps_materials(from, to)) return false;
  if (care == Care::whole && !keeps_connections(from, to)) return false;
  return std::ranges::none_of(
      around_[from], [&](uint32_t t) { return !dead_[t] && !corner_at(t, to) && turns_over(t, from, to, care); });
}

void CollapsingMesh::kill(uint32_t triangle) {
  dead_[triangle] = true;
  if (changes_ != nullptr) changes_->push_back({triangle, Change::kGone, 0});
  --live_;
  --live_of_material_[static_cast<size_t>(character_.mesh.primitives[primitive_of_[triangle]].material)];
}

void CollapsingMesh::collapse(uint32_t from, uint32_t to, const Moves& moves) {
  for (const uint32_t t : around_[from]) {
    if (dead_[t]) continue;
    if (corner_at(t, to)) {
      kill(t);
      continue;
    }
    for (uint32_t corner = 0; corner < 3; ++corner) {
      uint32_t& v = faces_[t][corner];
      if (point_of_[v] != from) continue;
      v = std::ranges::find_if(moves, [&](const auto& move) { return move.first == v; })->second;
      if (changes_ != nullptr) changes_->push_back({t, corner, v});
    }
    around_[to].push_back(t);
  }
  around_[from].clear();
  std::erase_if(around_[to], [&](uint32_t t) { return dead_[t]; });
}

void CollapsingMesh::drop_doubles(uint32_t point, const std::function<bool(const Faces& face)>& may_be_lost) {
  std::map<std::array<uint32_t, 3>, uint32_t> seen;
  const auto material = [&](uint32_t t) {
    return static_cast<size_t>(character_.mesh.primitives[primitive_of_[t]].material);
  };
  for (const uint32_t t : std::vector<uint32_t>(around_[point])) {
    std::array<uint32_t, 3> key{};
    for (size_t i = 0; i < 3; ++i) key[i] = point_of_[faces_[t][i]];
    // Turned so that the smallest comes first: the order of the other two is the side.
    std::rotate(key.begin(), std::min_element(key.begin(), key.end()), key.end());
    const std::array<uint32_t, 3> back = {key[0], key[2], key[1]};
    if (const auto same = seen.find(key); same != seen.end()) {
      if (live_of_material_[material(t)] > 1) kill(t);
      continue;
    }
    if (const auto other = seen.find(back); other != seen.end() && may_be_lost(faces_[t])) {
      const size_t needed = material(t) == material(other->second) ? 2 : 1;
      if (live_of_material_[material(t)] > needed && live_of_material_[material(other->second)] > needed) {
        kill(t);
        kill(other->second);
        seen.erase(other);
        continue;
      }
    }
    seen.emplace(key, t);
  }
}

}  // namespace crowdbench::scene
