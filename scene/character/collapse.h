// A mesh whose edges are collapsed onto one of their ends: who is where, and which collapses keep it whole. Internal to
// simplify.
#pragma once
#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "scene/character/character.h"

namespace crowdbench::scene {

// How much a collapse may change beside places.
enum class Care : uint8_t {
  whole,  // texture seams, open borders and the surface's connections stay as they are
  loose   // surfaces may close up, and seams be drawn across; materials still keep their borders
};

using Faces = std::array<uint32_t, 3>;  // vertices of a triangle

// Vertices of one place are a point, named by the first of them; those of a point that have also the same material's
// primitive, texture coordinates and colour are a chart's corner, named likewise: they differ in their normals at most.
class CollapsingMesh {
 public:
  // point_of: by vertex, as `weld` gives it. poses: positions of the vertices.
  CollapsingMesh(const Character& character, std::span<const std::vector<glm::vec3>> poses,
                 std::vector<uint32_t> point_of);

  size_t triangles() const { return live_; }
  size_t points() const { return around_.size(); }  // as many as vertices: most are of no use
  const std::vector<Faces>& faces() const { return faces_; }
  bool is_live(uint32_t triangle) const { return !dead_[triangle]; }
  uint32_t point_of(uint32_t vertex) const { return point_of_[vertex]; }
  uint32_t chart_of(uint32_t vertex) const { return chart_of_[vertex]; }
  // Points that share an edge with this one, ascending.
  std::vector<uint32_t> neighbours(uint32_t point) const;

  // Where the vertices of point `from` go, each to one of point `to`; std::nullopt: not all can.
  using Moves = std::vector<std::pair<uint32_t, uint32_t>>;
  std::optional<Moves> moves(uint32_t from, uint32_t to, Care care) const;
  // Whether the collapse keeps every material, turns no face over and, with care, keeps the surface's connections.
  bool is_sound(uint32_t from, uint32_t to, Care care) const;
  void collapse(uint32_t from, uint32_t to, const Moves& moves);
  // Of two triangles at the point that have the same three points, removes one where they show the same side, and both
  // where they are back to back, have no inside and may be lost.
  void drop_doubles(uint32_t point, const std::function<bool(const Faces& face)>& may_be_lost);

  // The corner of a triangle at a point; std::nullopt: it has none there.
  std::optional<uint32_t> corner_at(uint32_t triangle, uint32_t point) const;
  // Live triangles that have both points.
  size_t count_with(uint32_t a, uint32_t b) const;
  const std::vector<uint32_t>& around(uint32_t point) const { return around_[point]; }  // with dead ones
  uint32_t primitive_of(uint32_t triangle) const { return primitive_of_[triangle]; }
  const std::vector<bool>& dead() const { return dead_; }  // by triangle

  // What became of triangles, in order: a corner that is another vertex now, or the triangle's end.
  struct Change {
    static constexpr uint32_t kGone = 3;
    uint32_t triangle;
    uint32_t corner;  // 0..2, or kGone
    uint32_t vertex;
  };
  // From now on all changes are written there; it must outlive this.
  void write_to(std::vector<Change>& changes) { changes_ = &changes; }

 private:
  void name_charts();
  uint32_t best_of(uint32_t vertex, std::span<const uint32_t> there, std::optional<uint32_t> chart) const;
  bool keeps_materials(uint32_t from, uint32_t to) const;
  bool keeps_connections(uint32_t from, uint32_t to) const;
  bool turns_over(uint32_t triangle, uint32_t from, uint32_t to, Care care) const;
  void kill(uint32_t triangle);
  std::vector<uint32_t> vertices_at(uint32_t point) const;  // of live triangles, ascending

  const Character& character_;
  std::span<const std::vector<glm::vec3>> poses_;
  std::vector<uint32_t> point_of_, chart_of_;
  std::vector<Faces> faces_;
  std::vector<uint32_t> primitive_of_;  // by triangle
  std::vector<bool> dead_;
  std::vector<std::vector<uint32_t>> around_;  // by point
  std::vector<size_t> live_of_material_;
  std::vector<uint32_t> vertex_primitive_;
  size_t live_ = 0;
  std::vector<Change>* changes_ = nullptr;
};

// Whether the pictures of a material make texture coordinates matter.
bool is_textured(const Material& material);

}  // namespace crowdbench::scene
