#include "scene/character/drawn.h"

#include <algorithm>
#include <limits>
#include <string>
#include <unordered_map>

namespace crowdbench::scene {
namespace {

constexpr uint32_t kGone = std::numeric_limits<uint32_t>::max();

// Moves the elements that stay to the front.
template <typename T>
void compact(std::vector<T>& array, const std::vector<uint32_t>& to) {
  if (array.empty()) return;
  size_t left = 0;
  for (size_t v = 0; v < to.size(); ++v)
    if (to[v] != kGone) array[left++] = array[v];
  array.resize(left);
}

void drop_vertices(Mesh& mesh) {
  std::vector<uint32_t> to(mesh.positions.size(), kGone);
  for (const uint32_t v : mesh.indices) to[v] = 0;
  uint32_t left = 0;
  for (Primitive& p : mesh.primitives) {
    const uint32_t first = left;
    for (uint32_t v = p.first_vertex; v < p.first_vertex + p.vertex_count; ++v)
      if (to[v] != kGone) to[v] = left++;
    p.first_vertex = first;
    p.vertex_count = left - first;
  }
  if (left == mesh.positions.size()) return;
  for (uint32_t& v : mesh.indices) v = to[v];
  compact(mesh.positions, to);
  compact(mesh.normals, to);
  compact(mesh.uvs, to);
  compact(mesh.emissive_uvs, to);
  compact(mesh.colours, to);
  compact(mesh.joints, to);
  compact(mesh.weights, to);
  std::erase_if(mesh.file_vertices, [&](uint32_t v) { return to[v] == kGone; });
  for (uint32_t& v : mesh.file_vertices) v = to[v];
}

std::string bytes_of_vertex(const Mesh& mesh, uint32_t v) {
  std::string out;
  const auto add = [&](const auto& array) {
    if (!array.empty()) out.append(reinterpret_cast<const char*>(&array[v]), sizeof array[v]);
  };
  add(mesh.positions);
  add(mesh.normals);
  add(mesh.uvs);
  add(mesh.emissive_uvs);
  add(mesh.colours);
  add(mesh.joints);
  add(mesh.weights);
  return out;
}

}  // namespace

size_t count_vertices(const Mesh& mesh) {
  std::unordered_map<std::string, size_t> most;  // of one primitive, by what they are
  for (const Primitive& p : mesh.primitives) {
    std::unordered_map<std::string, size_t> own;
    for (uint32_t v = p.first_vertex; v < p.first_vertex + p.vertex_count; ++v) ++own[bytes_of_vertex(mesh, v)];
    for (const auto& [vertex, count] : own) most[vertex] = std::max(most[vertex], count);
  }
  size_t sum = 0;
  for (const auto& [vertex, count] : most) sum += count;
  return sum;
}

size_t keep_drawn(Mesh& mesh, const std::function<bool(const uint32_t* corners, const Primitive& primitive)>& seen) {
  std::vector<uint32_t> kept;
  std::vector<uint32_t> counts;
  kept.reserve(mesh.indices.size());
  for (const Primitive& p : mesh.primitives) {
    const size_t before = kept.size();
    for (size_t i = p.first_index; i + 2 < p.first_index + p.index_count; i += 3)
      if (seen(&mesh.indices[i], p)) kept.insert(kept.end(), &mesh.indices[i], &mesh.indices[i] + 3);
    counts.push_back(static_cast<uint32_t>(kept.size() - before));
  }
  const size_t removed = (mesh.indices.size() - kept.size()) / 3;
  if (removed == 0 || kept.empty()) return 0;
  mesh.indices = std::move(kept);
  uint32_t first = 0;
  for (size_t p = 0; p < counts.size(); ++p) {
    mesh.primitives[p].first_index = first;
    mesh.primitives[p].index_count = counts[p];
    first += counts[p];
  }
  drop_vertices(mesh);
  std::erase_if(mesh.primitives, [](const Primitive& p) { return p.index_count == 0; });
  return removed;
}

}  // namespace crowdbench::scene
