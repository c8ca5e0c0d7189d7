// Based on: M. Garland and P. Heckbert, "Surface simplification using quadric error metrics" (1997), edges in order of
// their cost and planes that hold borders; H. Hoppe, "New quadric metric for simplifying meshes with appearance
// attributes" (1999); A. Mohr and M. Gleicher, "Deformation sensitive decimation" (2003), quadrics summed over poses.
// Differs from the source: only onto ends of edges, so that every vertex keeps the weights that its artist gave it; a
// place where several vertices meet collapses as one, and stays closed.
#include "scene/character/simplify.h"

#include <algorithm>
#include <queue>

#include "scene/character/collapse.h"
#include "scene/character/quadric.h"
#include "scene/character/weld.h"

namespace crowdbench::scene {
namespace {

// Metres of displacement that count as much as one unit of a normal (57 degrees) or of a colour, of the figure's size;
// a texture that slides over the surface counts as this share of the slide.
constexpr float kNormalError = 0.003F;
constexpr float kColourError = 0.02F;
constexpr float kSlideError = 0.3F;
// Weights of the planes that hold borders, beside those of faces.
constexpr double kOpenBorder = 10;
constexpr double kSeam = 1;
// By how much dearer it is to close a surface or to draw across a seam.
constexpr double kLooseFactor = 3;
// And to lose what has closed up: a limb that is gone is seen, one that is thin is not.
constexpr double kLossFactor = 30;

// What a face of this area weighs: by its size and not by its area, thin limbs hold their own against broad backs.
double weight_of(double area) { return std::sqrt(area); }

double size_of(const std::vector<glm::vec3>& points) {
  if (points.empty()) return 0;
  glm::vec3 low = points.front();
  glm::vec3 high = low;
  for (const glm::vec3& p : points) {
    low = glm::min(low, p);
    high = glm::max(high, p);
  }
  return static_cast<double>(glm::length(high - low));
}

// Metres of surface a unit of texture, over all faces with either.
float metres_a_unit(const Mesh& mesh, const std::vector<glm::vec3>& pose, double size) {
  double surface = 0;
  double texture = 0;
  for (size_t i = 0; i + 2 < mesh.indices.size(); i += 3) {
    const uint32_t* v = &mesh.indices[i];
    surface += static_cast<double>(glm::length(glm::cross(pose[v[1]] - pose[v[0]], pose[v[2]] - pose[v[0]])));
    const glm::vec2 e = mesh.uvs[v[1]] - mesh.uvs[v[0]];
    const glm::vec2 f = mesh.uvs[v[2]] - mesh.uvs[v[0]];
    texture += std::abs(static_cast<double>(e.x * f.y - e.y * f.x));
  }
  return static_cast<float>(texture > 0 ? std::min(size, std::sqrt(surface / texture)) : size);
}

std::vector<Attributes> attributes_of(const Character& character, const std::vector<glm::vec3>& pose, double size) {
  const Mesh& mesh = character.mesh;
  const auto extent = static_cast<float>(size);
  const float slide = mesh.uvs.empty() ? 0.0F : kSlideError * metres_a_unit(mesh, pose, size);
  std::vector<Attributes> out(mesh.positions.size(), Attributes{});
  for (const Primitive& p : mesh.primitives) {
    const bool textured = is_textured(character.materials[static_cast<size_t>(p.material)]);
    for (uint32_t v = p.first_vertex; v < p.first_vertex + p.vertex_count; ++v) {
      Attributes& a = out[v];
      for (int i = 0; i < 3 && !p.flat; ++i) a[static_cast<size_t>(i)] = kNormalError * extent * mesh.normals[v][i];
      for (int i = 0; i < 2 && textured && !mesh.uvs.empty(); ++i) {
        a[static_cast<size_t>(3 + i)] = slide * mesh.uvs[v][i];
        if (!mesh.emissive_uvs.empty()) a[static_cast<size_t>(5 + i)] = slide * mesh.emissive_uvs[v][i];
      }
      for (int i = 0; i < 4 && !mesh.colours.empty(); ++i)
        a[static_cast<size_t>(7 + i)] = kColourError * extent * mesh.colours[v][i];
    }
  }
  return out;
}

class Simplifier {
 public:
  using Progress = std::function<void(size_t gone, size_t total)>;

  Simplifier(const Character& character, std::span<const std::vector<glm::vec3>> poses, double size,
             const Progress& progress)
      : poses_(poses),
        progress_(progress),
        mesh_(character, poses, weld(poses, static_cast<float>(1e-5 * size))),
        attributes_(attributes_of(character, poses.front(), size)),
        places_(mesh_.points() * poses.size()),
        looks_(mesh_.points()),
        changes_(mesh_.points()),
        all_(mesh_.triangles()) {
    for (uint32_t t = 0; t < mesh_.faces().size(); ++t)
      if (mesh_.is_live(t)) add_face(t);
  }

  void reduce_to(size_t triangles) {
    // What was refused may be possible once its surroundings have changed.
    while (mesh_.triangles() > triangles && pass(triangles)) {
    }
  }

  const CollapsingMesh& mesh() const { return mesh_; }

  // After each collapse: triangles that are left, and the changes so far.
  struct Step {
    size_t triangles;
    size_t changes;
  };
  // What happens from now on is written there; both must outlive this.
  void write_to(std::vector<CollapsingMesh::Change>& changes, std::vector<Step>& steps) {
    mesh_.write_to(changes);
    changes_so_far_ = &changes;
    steps_ = &steps;
  }

 private:
  struct Edge {
    double cost;
    uint32_t from, to;
    uint32_t from_changes, to_changes;
    Care care;
    bool operator>(const Edge& o) const {
      return std::tie(cost, from, to, care) > std::tie(o.cost, o.from, o.to, o.care);
    }
  };
  using Queue = std::priority_queue<Edge, std::vector<Edge>, std::greater<>>;

  Quadric& place(uint32_t point, size_t pose) { return places_[point * poses_.size() + pose]; }
  const Quadric& place(uint32_t point, size_t pose) const { return places_[point * poses_.size() + pose]; }

  void add_face(uint32_t t) {
    const Faces& face = mesh_.faces()[t];
    std::array<glm::dvec3, 3> p;
    for (size_t pose = 0; pose < poses_.size(); ++pose) {
      for (size_t i = 0; i < 3; ++i) p[i] = glm::dvec3(poses_[pose][mesh_.point_of(face[i])]);
      const glm::dvec3 normal = glm::cross(p[1] - p[0], p[2] - p[0]);
      const double length = glm::length(normal);
      if (!(length > 0)) continue;
      const glm::dvec3 n = normal / length;
      for (const uint32_t v : face)
        place(mesh_.point_of(v), pose).add_plane(n, -glm::dot(n, p[0]), weight_of(length / 2));
      for (size_t i = 0; i < 3; ++i) hold_border(t, i, pose, n);
      if (pose != 0) continue;
      const std::array<const Attributes*, 3> s = {&attributes_[face[0]], &attributes_[face[1]], &attributes_[face[2]]};
      for (const uint32_t v : face) looks_[v].add_face(p, s, weight_of(length / 2));
    }
  }

  // A plane through an edge that the surface, a material or a texture's chart ends at, upright on the face.
  void hold_border(uint32_t t, size_t edge, size_t pose, const glm::dvec3& normal) {
    const uint32_t a = mesh_.faces()[t][edge];
    const uint32_t b = mesh_.faces()[t][(edge + 1) % 3];
    const double weight = border_weight(t, a, b);
    if (weight == 0) return;
    const glm::dvec3 from(poses_[pose][mesh_.point_of(a)]);
    const glm::dvec3 along = glm::dvec3(poses_[pose][mesh_.point_of(b)]) - from;
    const double length = glm::length(along);
    if (!(length > 0)) return;
    const glm::dvec3 n = glm::cross(along / length, normal);
    for (const uint32_t v : {a, b}) place(mesh_.point_of(v), pose).add_plane(n, -glm::dot(n, from), weight * length);
  }

  double border_weight(uint32_t t, uint32_t a, uint32_t b) const {
    const uint32_t from = mesh_.point_of(a);
    const uint32_t to = mesh_.point_of(b);
    size_t others = 0;
    bool seam = false;
    for (const uint32_t other : mesh_.around(from)) {
      if (other == t || !mesh_.is_live(other)) continue;
      const auto there = mesh_.corner_at(other, to);
      if (!there) continue;
      ++others;
      if (mesh_.primitive_of(other) != mesh_.primitive_of(t)) return kOpenBorder;
      seam = seam || mesh_.chart_of(*there) != mesh_.chart_of(b) ||
             mesh_.chart_of(*mesh_.corner_at(other, from)) != mesh_.chart_of(a);
    }
    return others == 0 ? kOpenBorder : seam ? kSeam : 0;
  }

  double cost(uint32_t from, uint32_t to, const CollapsingMesh::Moves& moves) const {
    double sum = 0;
    for (size_t pose = 0; pose < poses_.size(); ++pose) {
      const glm::dvec3 p(poses_[pose][to]);
      sum += place(from, pose).at(p) + place(to, pose).at(p);
    }
    sum /= static_cast<double>(poses_.size());
    const glm::dvec3 p(poses_.front()[to]);
    for (const auto& [a, b] : moves) sum += looks_[a].at(p, attributes_[b]) + looks_[b].at(p, attributes_[b]);
    return std::max(sum, 0.0);
  }

  // With the most care that there can be from `care` on.
  void enter(Queue& queue, uint32_t from, uint32_t to, Care care) const {
    auto moves = mesh_.moves(from, to, care);
    if (!moves && care == Care::whole) moves = mesh_.moves(from, to, care = Care::loose);
    if (!moves) return;
    const double factor = care == Care::whole ? 1 : kLooseFactor;
    queue.push({factor * cost(from, to, *moves), from, to, changes_[from], changes_[to], care});
  }

  // Collapses until there are so few, or nothing is left to collapse. Whether there was anything.
  bool pass(size_t triangles) {
    Queue queue;
    for (uint32_t p = 0; p < mesh_.points(); ++p)
      for (const uint32_t q : mesh_.neighbours(p)) enter(queue, p, q, Care::whole);
    bool any = false;
    while (mesh_.triangles() > triangles && !queue.empty()) {
      const Edge edge = queue.top();
      queue.pop();
      if (edge.from_changes != changes_[edge.from] || edge.to_changes != changes_[edge.to]) continue;
      if (mesh_.count_with(edge.from, edge.to) == 0) continue;
      const auto moves = mesh_.moves(edge.from, edge.to, edge.care);
      if (!moves || !mesh_.is_sound(edge.from, edge.to, edge.care)) {
        if (edge.care == Care::whole) enter(queue, edge.from, edge.to, Care::loose);
        continue;
      }
      apply(edge, *moves);
      any = true;
      constexpr size_t kOften = 64;  // edges
      if (progress_ && ++collapsed_ % kOften == 0) progress_(all_ - mesh_.triangles(), all_ - triangles);
      for (const uint32_t p : mesh_.neighbours(edge.to)) {
        enter(queue, p, edge.to, Care::whole);
        enter(queue, edge.to, p, Care::whole);
      }
    }
    return any;
  }

  void apply(const Edge& edge, const CollapsingMesh::Moves& moves) {
    mesh_.collapse(edge.from, edge.to, moves);
    mesh_.drop_doubles(edge.to, [&](const Faces& face) { return kLossFactor * cost_of_loss(face) <= edge.cost; });
    for (size_t pose = 0; pose < poses_.size(); ++pose) place(edge.to, pose).add(place(edge.from, pose));
    for (const auto& [a, b] : moves) looks_[b].add(looks_[a]);
    if (steps_ != nullptr) steps_->push_back({mesh_.triangles(), changes_so_far_->size()});
    ++changes_[edge.from];
    ++changes_[edge.to];
  }

  // Of a face that is left out, as if it had gone to one of its corners.
  double cost_of_loss(const Faces& face) const {
    double sum = 0;
    for (const std::vector<glm::vec3>& pose : poses_) {
      const glm::dvec3 a(pose[mesh_.point_of(face[0])]);
      const glm::dvec3 e(glm::dvec3(pose[mesh_.point_of(face[1])]) - a);
      const glm::dvec3 f(glm::dvec3(pose[mesh_.point_of(face[2])]) - a);
      sum += weight_of(glm::length(glm::cross(e, f)) / 2) * std::max(glm::dot(e, e), glm::dot(f, f));
    }
    return sum / static_cast<double>(poses_.size());
  }

  std::span<const std::vector<glm::vec3>> poses_;
  const Progress& progress_;
  CollapsingMesh mesh_;
  std::vector<Attributes> attributes_;   // by vertex
  std::vector<Quadric> places_;          // by point and pose
  std::vector<AttributeQuadric> looks_;  // by vertex, in the first pose
  std::vector<uint32_t> changes_;        // of a point's surroundings
  size_t all_ = 0;                       // triangles at first
  size_t collapsed_ = 0;                 // edges
  const std::vector<CollapsingMesh::Change>* changes_so_far_ = nullptr;
  std::vector<Step>* steps_ = nullptr;
};

// The mesh with those of the faces that are not dead, in the order of its primitives.
Mesh with_faces(const Mesh& mesh, const CollapsingMesh& reduced, const std::vector<Faces>& faces,
                const std::vector<bool>& dead) {
  Mesh out = mesh;
  out.indices.clear();
  uint32_t t = 0;
  for (uint32_t p = 0; p < out.primitives.size(); ++p) {
    out.primitives[p].first_index = static_cast<uint32_t>(out.indices.size());
    for (; t < faces.size() && reduced.primitive_of(t) == p; ++t)
      if (!dead[t]) out.indices.insert(out.indices.end(), faces[t].begin(), faces[t].end());
    out.primitives[p].index_count = static_cast<uint32_t>(out.indices.size()) - out.primitives[p].first_index;
  }
  return out;
}

constexpr const char* kWhyMore =
    "every material keeps a triangle, and none of the edges left can go without turning faces over";

}  // namespace

SimplifiedMesh simplify(const Character& character, std::span<const std::vector<glm::vec3>> poses, size_t triangles,
                        const std::function<void(size_t gone, size_t total)>& progress) {
  if (character.triangles() <= triangles) return {character.mesh, {}};
  Simplifier simplifier(character, poses, size_of(poses.front()), progress);
  simplifier.reduce_to(triangles);
  const CollapsingMesh& reduced = simplifier.mesh();
  SimplifiedMesh out{with_faces(character.mesh, reduced, reduced.faces(), reduced.dead()), {}};
  if (reduced.triangles() > triangles) out.why_more = kWhyMore;
  return out;
}

struct Simplification::Steps {
  const Character& character;
  Simplifier simplifier;
  std::vector<Faces> faces;  // before the first collapse
  std::vector<bool> dead;
  size_t triangles;  // likewise
  std::vector<CollapsingMesh::Change> changes;
  std::vector<Simplifier::Step> steps;
  Steps(const Character& of, std::span<const std::vector<glm::vec3>> poses, const Simplifier::Progress& progress)
      : character(of),
        simplifier(of, poses, size_of(poses.front()), progress),
        faces(simplifier.mesh().faces()),
        dead(simplifier.mesh().dead()),
        triangles(simplifier.mesh().triangles()) {
    simplifier.write_to(changes, steps);
  }
};

Simplification::Simplification(const Character& character, std::span<const std::vector<glm::vec3>> poses, size_t least,
                               const std::function<void(size_t gone, size_t total)>& progress)
    : steps_(std::make_unique<Steps>(character, poses, progress)) {
  steps_->simplifier.reduce_to(least);
}

Simplification::~Simplification() = default;

SimplifiedMesh Simplification::at(size_t triangles) const {
  const Steps& all = *steps_;
  if (all.character.triangles() <= triangles) return {all.character.mesh, {}};
  size_t left = all.triangles;
  size_t end = 0;  // of the changes
  for (size_t i = 0; left > triangles && i < all.steps.size(); ++i) {
    left = all.steps[i].triangles;
    end = all.steps[i].changes;
  }
  std::vector<Faces> faces = all.faces;
  std::vector<bool> dead = all.dead;
  for (size_t i = 0; i < end; ++i) {
    const CollapsingMesh::Change& change = all.changes[i];
    if (change.corner == CollapsingMesh::Change::kGone)
      dead[change.triangle] = true;
    else
      faces[change.triangle][change.corner] = change.vertex;
  }
  SimplifiedMesh out{with_faces(all.character.mesh, all.simplifier.mesh(), faces, dead), {}};
  if (left > triangles) out.why_more = kWhyMore;
  return out;
}

}  // namespace crowdbench::scene
