// glTF to Character, after validation.
// Based on: Khronos Group, "glTF 2.0 Specification" (skins 3.7.3, triangle strips and fans 3.7.2.1, instantiation).
#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <optional>
#include <set>

#include "core/error.h"
#include "core/files.h"
#include "scene/character/flat_normals.h"
#include "scene/gltf/gltf.h"
#include "scene/gltf/gltf_asset.h"
#include "scene/gltf/gltf_clips.h"
#include "scene/gltf/gltf_materials.h"
#include "scene/gltf/gltf_validate.h"
#include "scene/gltf/gltf_weights.h"
#include "scene/pose/normalise.h"
#include "scene/pose/reach.h"
#include "scene/pose/visible.h"

namespace crowdbench::scene {
namespace {

class Loader {
 public:
  explicit Loader(GltfAsset& asset) : asset_(asset), weights_(asset) {}

  void run() {
    read_nodes();
    for (const GltfHumanBone& bone : plan_.human_bones)
      if (const int node = node_of_[index_of(bone.node)]; node >= 0)
        character_.skeleton.human_bones.push_back({bone.name, node});
    find_hidden();
    if (options_.may_lack_mesh && !draws_anything()) {
      read_clips(asset_);
      check_reach();
      return;
    }
    materials_.emplace(asset_, used_materials());
    read_meshes();
    find_root();
    read_clips(asset_);
    leave_out_invisible();
    finish();
  }

 private:
  // --- nodes ---

  glm::dquat unit_rotation(const glm::dquat& r, int file_index) {
    const double length = glm::length(r);
    if (std::abs(length - 1.0) > 1e-2)
      asset_.warn(fmt::format("/nodes/{}: rotation of length {:.3g} is normalised", file_index, length));
    return glm::normalize(r);
  }

  void read_nodes() {
    node_of_.assign(model_.nodes.size(), -1);
    auto& nodes = character_.skeleton.nodes;
    for (const int file_index : plan_.node_order) {
      const GltfNode& in = model_.nodes[index_of(file_index)];
      Node out;
      out.name = in.name;
      const int parent = plan_.node_parent[index_of(file_index)];
      out.parent = parent < 0 ? -1 : node_of_[index_of(parent)];
      out.has_matrix = in.matrix.has_value();
      if (in.matrix) out.matrix = *in.matrix;
      if (in.translation) out.translation = *in.translation;
      if (in.rotation) out.rotation = unit_rotation(*in.rotation, file_index);
      if (in.scale) out.scale = *in.scale;
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
    hidden_ = plan_.hidden;
    for (const std::string& name : options_.hide) {
      bool found = false;
      for (size_t i = 0; i < model_.nodes.size(); ++i) {
        if (model_.nodes[i].name != name) continue;
        hidden_[i] = true;
        found = true;
      }
      if (found) continue;
      std::vector<std::string> names;
      for (const GltfNode& node : model_.nodes)
        if (node.mesh >= 0 && !node.name.empty()) names.push_back(node.name);
      const std::string near = nearest_name(name, names);
      std::string listed;
      for (size_t i = 0; i < std::min<size_t>(names.size(), 20); ++i)
        listed += (i ? ", " : "") + printable(names[i], 40);
      throw Error(asset_.source.where(), fmt::format("has no node named {} to hide", printable(name, 60)),
                  near.empty() ? "its meshes are on " + (listed.empty() ? "nodes without names" : listed)
                               : fmt::format("did you mean {}?", printable(near, 60)));
    }
    for (const int node : plan_.node_order) {
      const int parent = plan_.node_parent[index_of(node)];
      if (parent >= 0 && hidden_[index_of(parent)]) hidden_[index_of(node)] = true;
    }
  }

  // By material.
  std::vector<bool> used_materials() const {
    std::vector<bool> used(model_.materials.size(), false);
    for (size_t i = 0; i < model_.nodes.size(); ++i) {
      if (!draws(i)) continue;
      for (const GltfPrimitive& p : model_.meshes[index_of(model_.nodes[i].mesh)])
        if (p.material >= 0) used[index_of(p.material)] = true;
    }
    return used;
  }

  // --- meshes ---

  bool draws(size_t node) const {
    const GltfNode& n = model_.nodes[node];
    if (n.mesh < 0 || !plan_.in_scene[node] || hidden_[node]) return false;
    return n.skin >= 0 || options_.rigid_meshes || model_.skins.empty();
  }

  // Of the levels of a group that are shown, the one asked for, or the coarsest where there are not so many; all else
  // at every level.
  bool draws_at(size_t node, size_t level) const {
    if (!draws(node)) return false;
    const int group = plan_.lod_group[node];
    if (group < 0) return true;
    const std::set<int>& shown = shown_levels_.at(group);
    return plan_.lod[node] == *std::next(shown.begin(), static_cast<std::ptrdiff_t>(std::min(level, shown.size() - 1)));
  }

  void find_levels_shown() {
    for (size_t i = 0; i < model_.nodes.size(); ++i)
      if (plan_.lod_group[i] >= 0 && draws(i)) shown_levels_[plan_.lod_group[i]].insert(plan_.lod[i]);
    for (const auto& [group, shown] : shown_levels_) levels_ = std::max(levels_, shown.size());
  }

  bool draws_anything() const {
    for (size_t i = 0; i < model_.nodes.size(); ++i)
      if (draws(i)) return true;
    return false;
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
    find_levels_shown();
    read_level(0);
    if (mesh.indices.empty()) {
      std::string reason = "has no triangles to draw";
      if (!options_.hide.empty()) reason += " once parts are hidden";
      throw Error(asset_.source.where(), reason,
                  model_.meshes.empty() ? "it holds no mesh"
                  : shown_elsewhere() ? "the scene that it shows by default is without meshes, others have some: make "
                                        "one of these its `scene`"
                                      : "see its scene and its meshes");
    }
    for (const int accessor : position_accessors_)
      character_.file_vertices += plan_.accessors[index_of(accessor)].count;
    read_coarser_levels();
    if (zero_normals_ > 0) asset_.warn(fmt::format("{} normals of length zero point up instead", zero_normals_));
    weights_.report();
  }

  // Has a node a mesh that is in no part of the scene that is shown?
  bool shown_elsewhere() const {
    for (size_t i = 0; i < model_.nodes.size(); ++i)
      if (model_.nodes[i].mesh >= 0 && !plan_.in_scene[i]) return true;
    return false;
  }

  void read_level(size_t level) {
    for (size_t i = 0; i < model_.nodes.size(); ++i) {
      if (!draws_at(i, level)) continue;
      const GltfNode& node = model_.nodes[i];
      const Palette palette = node.skin >= 0 ? skin_palette(node.skin) : rigid_palette(i);
      const auto& primitives = model_.meshes[index_of(node.mesh)];
      // The same triangles again, in the same material, would not be seen.
      std::set<GltfPrimitive> read;
      for (size_t p = 0; p < primitives.size(); ++p) {
        const GltfPrimitive& in = primitives[p];
        const std::string path = fmt::format("/meshes/{}/primitives/{}", node.mesh, p);
        if (read.insert(in).second || options_.undrawn)
          read_primitive(in, path, i, palette);
        else
          leave_out_repeated(in, path, level);
      }
    }
  }

  void leave_out_repeated(const GltfPrimitive& primitive, const std::string& path, size_t level) {
    if (primitive.mode < kGltfTriangles) return;
    if (!warned_repeated_) asset_.warn(path + ": repeats another primitive of its mesh and is drawn once");
    warned_repeated_ = true;
    const auto position = primitive.attributes.find("POSITION");
    if (level > 0 || position == primitive.attributes.end()) return;
    const size_t corners = asset_.view_of(primitive.indices >= 0 ? primitive.indices : position->second).count;
    repeated_triangles_ += primitive.mode == kGltfTriangles ? corners / 3 : corners - 2;
  }

  // Character::levels, each read where the finest one was; together within the limits of one mesh.
  void read_coarser_levels() {
    if (levels_ < 2) return;
    Mesh finest = std::move(character_.mesh);
    size_t vertices = 0;
    size_t corners = 0;
    for (size_t level = 1; level < levels_; ++level) {
      character_.mesh = {};
      read_level(level);
      Mesh& mesh = character_.mesh;
      vertices += mesh.positions.size();
      corners += mesh.indices.size();
      if (mesh.indices.empty() || vertices > limits_.vertices || corners / 3 > limits_.triangles) break;
      mesh.file_vertices.clear();
      character_.levels.push_back(std::move(mesh));
    }
    character_.mesh = std::move(finest);
    asset_.warn(fmt::format("{} levels of detail; LOD0 is drawn, the option lod=1 draws the next", levels_));
    if (character_.levels.size() + 1 < levels_)
      asset_.warn(
          fmt::format("LOD{} and coarser ones are left out: no triangles, or too many", character_.levels.size() + 1));
  }

  // Arrays that all primitives or none have.
  void find_optional_attributes() {
    for (size_t i = 0; i < model_.nodes.size(); ++i) {
      if (!draws(i)) continue;
      for (const GltfPrimitive& p : model_.meshes[index_of(model_.nodes[i].mesh)]) {
        if (p.mode < kGltfTriangles) continue;
        if (p.attributes.count("COLOR_0") != 0) has_colours_ = true;
        if (p.material < 0) continue;
        const Material& m = character_.materials[index_of(p.material)];
        if (m.emissive_image >= 0 && !(materials_->base_uv(p.material) == materials_->emissive_uv(p.material)))
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
    const GltfSkin& in = model_.skins[index_of(skin)];
    const Palette palette{place->second, static_cast<int>(in.joints.size()), false};
    if (!fresh) return palette;
    if (first_skin_ < 0) first_skin_ = skin;
    std::optional<AccessorView> binds;
    if (in.inverse_binds >= 0) binds = asset_.view_of(in.inverse_binds);
    for (size_t j = 0; j < in.joints.size(); ++j) {
      Joint joint;
      joint.node = node_of_[index_of(in.joints[j])];
      joint.name = model_.nodes[index_of(in.joints[j])].name;
      if (binds) {
        for (int e = 0; e < 16; ++e) joint.inverse_bind[e / 4][e % 4] = asset_.finite(*binds, j, e);
        snap_last_row(joint.inverse_bind, binds->path, j);
      }
      joints.push_back(std::move(joint));
    }
    return palette;
  }

  // Exporters round; the specification wants exactly (0, 0, 0, 1).
  void snap_last_row(glm::dmat4& m, const std::string& path, size_t j) {
    const double off = std::abs(m[0][3]) + std::abs(m[1][3]) + std::abs(m[2][3]) + std::abs(m[3][3] - 1.0);
    if (off > 1e-3)
      asset_.fail(path,
                  fmt::format("inverse bind matrix {} is not affine: its last row is ({:.6g}, {:.6g}, {:.6g}, {:.6g})",
                              j, m[0][3], m[1][3], m[2][3], m[3][3]),
                  "its last row must be (0, 0, 0, 1); export the skin again");
    if (off > 0 && !warned_row_)
      asset_.warn(fmt::format("{}: the last row of inverse bind matrix {} is off (0, 0, 0, 1) by {:.2g} and is snapped",
                              path, j, off));
    warned_row_ = warned_row_ || off > 0;
    for (int c = 0; c < 4; ++c) m[c][3] = c == 3 ? 1.0 : 0.0;
  }

  Palette rigid_palette(size_t node) {
    auto& joints = character_.skeleton.joints;
    const auto [place, fresh] = rigid_first_.emplace(node, static_cast<int>(joints.size()));
    if (!fresh) return {place->second, 1, true};
    Joint joint;
    joint.node = node_of_[node];
    joint.name = model_.nodes[node].name;
    joint.rigid = true;
    joints.push_back(std::move(joint));
    return {static_cast<int>(joints.size()) - 1, 1, true};
  }

  void read_primitive(const GltfPrimitive& in, const std::string& path, size_t node, const Palette& palette) {
    const auto position = in.attributes.find("POSITION");
    if (in.mode < kGltfTriangles || position == in.attributes.end()) return;
    position_accessors_.insert(position->second);
    Mesh& mesh = character_.mesh;
    const AccessorView& positions = asset_.view_of(position->second);
    Primitive out;
    out.first_vertex = static_cast<uint32_t>(mesh.positions.size());
    out.first_index = static_cast<uint32_t>(mesh.indices.size());
    out.material = in.material >= 0 ? in.material : materials_->default_material();
    out.node = node_of_[node];
    out.gltf_node = static_cast<int>(node);
    out.mirrored = is_mirrored(out.node);
    read_indices(in, path, positions.count);
    const std::vector<uint32_t> used = number_used(out, positions.count);
    if (mesh.positions.size() + used.size() > limits_.vertices)
      asset_.fail(path,
                  fmt::format("brings the vertices to {}, the limit is {}", mesh.positions.size() + used.size(),
                              limits_.vertices),
                  "simplify the mesh");
    for (const uint32_t v : used) {
      mesh.file_vertices.push_back(static_cast<uint32_t>(mesh.positions.size()));
      mesh.positions.push_back(asset_.finite3(positions, v));
    }
    const UvSource& base = materials_->base_uv(out.material);
    read_uvs(in, path, base, character_.materials[index_of(out.material)].base_colour_image >= 0, used, mesh.uvs);
    if (has_emissive_uvs_) read_uvs(in, path, materials_->emissive_uv(out.material), false, used, mesh.emissive_uvs);
    if (has_colours_) read_colours(in, path, used);
    if (palette.rigid) {
      mesh.joints.insert(mesh.joints.end(), used.size(), glm::u16vec4(static_cast<uint16_t>(palette.first), 0, 0, 0));
      mesh.weights.insert(mesh.weights.end(), used.size(), glm::vec4(1.0F, 0.0F, 0.0F, 0.0F));
      character_.file_max_influences = std::max(character_.file_max_influences, 1);
    } else {
      weights_.read(in, used, palette.first, palette.count);
    }
    out.index_count = static_cast<uint32_t>(mesh.indices.size()) - out.first_index;
    if (const auto normal = in.attributes.find("NORMAL"); normal != in.attributes.end())
      read_normals(asset_.view_of(normal->second), used);
    else
      draw_flat(out, path);
    out.vertex_count = static_cast<uint32_t>(mesh.positions.size()) - out.first_vertex;
    mesh.primitives.push_back(out);
  }

  // The file's vertices that the primitive's triangles name, ascending; its indices then count through these. A buffer
  // may hold many vertices that others use, or nobody.
  std::vector<uint32_t> number_used(const Primitive& out, size_t count) {
    auto& indices = character_.mesh.indices;
    std::vector<uint32_t> used;
    if (options_.undrawn) {
      used.resize(std::min(count, limits_.vertices + 1));
      std::iota(used.begin(), used.end(), 0U);
    } else if (const std::span<uint32_t> corners(indices.begin() + out.first_index, indices.end());
               count > corners.size()) {
      used.assign(corners.begin(), corners.end());
      std::sort(used.begin(), used.end());
      used.erase(std::unique(used.begin(), used.end()), used.end());
      for (uint32_t& corner : corners)
        corner = static_cast<uint32_t>(std::lower_bound(used.begin(), used.end(), corner) - used.begin());
    } else {
      std::vector<uint32_t> place(count, UINT32_MAX);
      for (const uint32_t corner : corners) place[corner] = 0;
      for (uint32_t v = 0; v < count; ++v) {
        if (place[v] != 0) continue;
        place[v] = static_cast<uint32_t>(used.size());
        used.push_back(v);
      }
      for (uint32_t& corner : corners) corner = place[corner];
    }
    for (size_t i = out.first_index; i < indices.size(); ++i) indices[i] += out.first_vertex;
    return used;
  }

  void read_uvs(const GltfPrimitive& in, const std::string& path, const UvSource& uv, bool needed,
                const std::vector<uint32_t>& vertices, std::vector<glm::vec2>& out) {
    const auto found = in.attributes.find(fmt::format("TEXCOORD_{}", uv.set));
    if (found == in.attributes.end()) {
      if (needed) asset_.warn(fmt::format("{}: is textured but has no TEXCOORD_{}", path, uv.set));
      out.insert(out.end(), vertices.size(), glm::vec2(0.0F));
      return;
    }
    const AccessorView& view = asset_.view_of(found->second);
    // The extension turns counter-clockwise as seen with v pointing down, as the engines agree; its GLSL text has the
    // signs for v pointing up.
    const double c = std::cos(uv.rotation);
    const double s = std::sin(uv.rotation);
    for (const uint32_t i : vertices) {
      const double u = asset_.finite(view, i, 0) * uv.scale.x;
      const double v = asset_.finite(view, i, 1) * uv.scale.y;
      out.emplace_back(static_cast<float>(uv.offset.x + c * u + s * v),
                       static_cast<float>(uv.offset.y - s * u + c * v));
    }
  }

  void read_colours(const GltfPrimitive& in, const std::string& path, const std::vector<uint32_t>& vertices) {
    auto& colours = character_.mesh.colours;
    const auto found = in.attributes.find("COLOR_0");
    if (found == in.attributes.end()) {
      colours.insert(colours.end(), vertices.size(), glm::vec4(1.0F));
      return;
    }
    const AccessorView& view = asset_.view_of(found->second);
    bool black = true;
    for (const uint32_t i : vertices) {
      glm::vec4 colour(1.0F);
      for (int c = 0; c < view.components; ++c)
        colour[c] = static_cast<float>(std::clamp(asset_.finite(view, i, c), 0.0, 1.0));
      colours.push_back(colour);
      black = black && glm::vec3(colour) == glm::vec3(0.0F);
    }
    // Masks for other shaders are kept in colours too; as the specification has it, they multiply.
    if (black && !warned_black_)
      asset_.warn(
          fmt::format("{}: COLOR_0 is black at every vertex, and so is what is drawn; export without it", path));
    warned_black_ = warned_black_ || black;
  }

  void read_normals(const AccessorView& view, const std::vector<uint32_t>& vertices) {
    for (const uint32_t i : vertices) {
      const glm::vec3 n = asset_.finite3(view, i);
      const float length = glm::length(n);
      if (length < 1e-6F) ++zero_normals_;
      character_.mesh.normals.push_back(length < 1e-6F ? glm::vec3(0.0F, 1.0F, 0.0F) : n / length);
    }
  }

  static bool restarts(const AccessorView& indices, size_t index) {
    return index == (indices.type == kU8 ? UINT8_MAX : indices.type == kU16 ? UINT16_MAX : UINT32_MAX);
  }

  // The corners of its triangles, as the file numbers its `vertices`.
  void read_indices(const GltfPrimitive& in, const std::string& path, size_t vertices) {
    std::optional<AccessorView> view;
    if (in.indices >= 0) view = asset_.view_of(in.indices);
    const size_t corners = view ? view->count : vertices;
    const auto corner = [&](size_t i) {
      const size_t index = view ? view->unsigned_at(i) : i;
      if (index >= vertices)
        asset_.fail(view->path, fmt::format("index {} is {}, but {} has {} vertices", i, index, path, vertices),
                    in.mode > kGltfTriangles && restarts(*view, index)
                        ? "glTF strips do not restart at the largest index: export triangles"
                        : "");
      return static_cast<uint32_t>(index);
    };
    auto& indices = character_.mesh.indices;
    if (in.mode == kGltfTriangles) {
      for (size_t i = 0; i < corners; ++i) indices.push_back(corner(i));
      return;
    }
    for (size_t i = 0; i + 2 < corners; ++i) {
      if (in.mode == kGltfFan) {
        for (const size_t k : {i + 1, i + 2, size_t{0}}) indices.push_back(corner(k));
      } else {
        // Every other triangle of a strip turns the other way round.
        const size_t odd = i % 2;
        for (const size_t k : {i, i + 1 + odd, i + 2 - odd}) indices.push_back(corner(k));
      }
    }
  }

  void draw_flat(Primitive& primitive, const std::string& path) {
    primitive.flat = true;
    if (!add_flat_normals(character_.mesh, primitive, limits_.vertices))
      asset_.fail(path, fmt::format("flat normals need more than {} vertices", limits_.vertices), "export normals");
    if (!warned_flat_) asset_.warn(fmt::format("{}: has no normals and is drawn flat", path));
    warned_flat_ = true;
  }

  // --- the whole ---

  void find_root() {
    Skeleton& skeleton = character_.skeleton;
    if (first_skin_ < 0) return;
    const GltfSkin& skin = model_.skins[index_of(first_skin_)];
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
    if (common < 0) asset_.warn("the joints of the skin have no common root; the first joint counts as the root");
  }

  void leave_out_invisible() {
    Mesh& mesh = character_.mesh;
    character_.file_triangles = character_.triangles() + repeated_triangles_;
    if (!options_.undrawn) {
      const Invisible invisible = drop_invisible(character_);
      if (invisible.all)
        asset_.warn(
            "nothing of it can be seen: every triangle is without area, transparent, or below the cutoff of its mask");
      else if (invisible.removed > 0)
        asset_.warn(
            fmt::format("{} of {} triangles cannot be seen (without area or fully transparent) and are left out",
                        invisible.removed, character_.file_triangles));
    }
    if (mesh.file_vertices.size() == mesh.positions.size()) mesh.file_vertices.clear();
  }

  void check_reach() {
    if (const auto node = node_beyond_reach(character_, limits_.reach)) {
      const auto file_index = std::find(node_of_.begin(), node_of_.end(), static_cast<int>(*node)) - node_of_.begin();
      asset_.fail(fmt::format("/nodes/{}", file_index),
                  fmt::format("lies beyond the limit of {} once its parents' scales and "
                              "translations are applied",
                              limits_.reach));
    }
  }

  void finish() {
    check_reach();
    normalise(character_, options_.normalise);
    const Placement& p = character_.placement;
    if (!std::isfinite(p.height) || !std::isfinite(p.scale) || p.scale <= 0)
      throw Error(asset_.source.where(), "its height as posed is not a number", "check the transforms of its nodes");
    if (p.height <= 0) asset_.warn("has no height as posed; it is not scaled");
  }

  GltfAsset& asset_;
  const GltfModel& model_ = asset_.plan.model;
  const GltfPlan& plan_ = asset_.plan;
  const LoadOptions& options_ = asset_.options;
  const GltfLimits& limits_ = asset_.limits;
  Character& character_ = asset_.character;
  std::vector<int>& node_of_ = asset_.node_of;
  std::optional<GltfMaterials> materials_;
  GltfWeights weights_;
  std::vector<bool> hidden_;  // by file index
  bool has_colours_ = false;
  bool has_emissive_uvs_ = false;
  std::set<int> position_accessors_;  // of what is shown
  std::map<int, int> skin_first_;
  std::map<size_t, int> rigid_first_;
  std::map<int, std::set<int>> shown_levels_;  // by group
  size_t levels_ = 1;                          // the finest among them
  int first_skin_ = -1;
  size_t zero_normals_ = 0;
  bool warned_flat_ = false;
  bool warned_row_ = false;
  bool warned_black_ = false;
  bool warned_repeated_ = false;
  size_t repeated_triangles_ = 0;
};

}  // namespace

Character load_character(const std::vector<uint8_t>& bytes, const std::string& where,
                         const std::filesystem::path& folder, const LoadOptions& options) {
  GltfSource source(bytes, printable(where, 300), folder, options.limits);
  GltfPlan plan = validate_gltf(source, options.limits);
  GltfAsset asset(source, std::move(plan), options);
  asset.character.name = std::filesystem::path(where).stem().string();
  asset.character.source = where;
  Loader(asset).run();
  return std::move(asset.character);
}

Character load_character(const std::filesystem::path& path, const LoadOptions& options) {
  std::filesystem::path folder = path.parent_path();
  if (folder.empty()) folder = ".";
  return load_character(read_file(path, options.limits.file_bytes), path.string(), folder, options);
}

}  // namespace crowdbench::scene
