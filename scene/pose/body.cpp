// Based on: Kabsch, "A solution for the best rotation to relate two sets of vectors" (1976), in the plane of the
// ground.
#include "scene/pose/body.h"

#include <algorithm>
#include <cmath>

#include "scene/character/cut_out.h"
#include "scene/pose/hidden.h"
#include "scene/pose/pose.h"

namespace crowdbench::scene {
namespace {

// The mass of each vertex; held: what the joints of things that are held carry, those that are seen.
std::vector<double> vertex_masses(const Character& character, std::span<const uint32_t> unseen,
                                  std::vector<bool>& holds) {
  const Mesh& mesh = character.mesh;
  const Skeleton& skeleton = character.skeleton;
  auto bind = skin_positions(mesh, joint_matrices(character, -1, 0.0));
  put_aside(bind, unseen);
  const auto rigid = [&](uint32_t v) { return skeleton.joints[mesh.joints[v][0]].rigid; };
  const auto held = [&](uint32_t v) { return skeleton.root_node >= 0 && rigid(v); };
  std::vector<double> mass(bind.size(), 0.0);
  double total = 0;
  const auto add = [&](bool by_area, bool with_held) {
    for (const Primitive& p : mesh.primitives) {
      const CutOut cut_out(character, character.materials[static_cast<size_t>(p.material)]);
      for (size_t i = p.first_index; i + 2 < p.first_index + p.index_count; i += 3) {
        const uint32_t* t = &mesh.indices[i];
        const double area = by_area ? glm::length(glm::cross(bind[t[1]] - bind[t[0]], bind[t[2]] - bind[t[0]])) : 1.0;
        const TrianglePlace share = cut_out.cuts() && by_area ? 3.0 * cut_out.moment(t) : TrianglePlace(1.0);
        if (rigid(t[0]) && by_area && area * (share.x + share.y + share.z) > 0) holds[mesh.joints[t[0]][0]] = true;
        if (!with_held && held(t[0])) continue;
        for (int k = 0; k < 3; ++k) mass[t[k]] += area * share[k];
        total += area * (share.x + share.y + share.z) / 3;
      }
    }
  };
  add(true, false);
  if (!(total > 0)) add(true, true);
  if (!(total > 0)) add(false, true);
  return mass;
}

glm::dvec3 turned(const glm::dvec3& v, double sine, double cosine) {
  return {v.x * cosine + v.z * sine, v.y, v.z * cosine - v.x * sine};
}

}  // namespace

Body::Body(const Character& character, std::span<const uint32_t> unseen)
    : lumps_(character.skeleton.joints.size()), holds_(lumps_.size()) {
  const Mesh& mesh = character.mesh;
  const std::vector<double> mass = vertex_masses(character, unseen, holds_);
  const auto visit = [&](const auto& see) {
    for (size_t v = 0; v < mass.size(); ++v)
      for (int i = 0; mass[v] > 0 && i < kInfluences; ++i)
        if (const double weight = mesh.weights[v][i]; weight > 0)
          see(lumps_[mesh.joints[v][i]], mass[v] * weight, glm::dvec3(mesh.positions[v]));
  };
  visit([&](Lump& lump, double m, const glm::dvec3& p) {
    lump.mass += m;
    lump.centre += m * p;
    mass_ += m;
  });
  for (Lump& lump : lumps_)
    if (lump.mass > 0) lump.centre /= lump.mass;
  visit([](Lump& lump, double m, const glm::dvec3& p) {
    lump.spread += m / lump.mass * glm::dot(p - lump.centre, p - lump.centre);
  });
  for (Lump& lump : lumps_) lump.spread = std::sqrt(lump.spread);
}

glm::dvec3 Body::centre(const std::vector<glm::dmat4>& palette) const {
  glm::dvec3 sum(0.0);
  for (size_t j = 0; j < lumps_.size(); ++j)
    if (lumps_[j].mass > 0) sum += lumps_[j].mass * glm::dvec3(palette[j] * glm::dvec4(lumps_[j].centre, 1.0));
  return mass_ > 0 ? sum / mass_ : sum;
}

std::vector<Body::Point> Body::points(const std::vector<glm::dmat4>& palette) const {
  std::vector<Point> out;
  for (size_t j = 0; j < lumps_.size(); ++j) {
    const Lump& lump = lumps_[j];
    if (!(lump.mass > 0)) continue;
    const double share = lump.mass / mass_ / 4;
    const auto add = [&](const glm::dvec3& offset) {
      out.push_back({glm::dvec3(palette[j] * glm::dvec4(lump.centre + lump.spread * offset, 1.0)), share});
    };
    // A tetrahedron, whose middle is the centre.
    for (const glm::dvec3& corner : {glm::dvec3{1, 1, 1}, {1, -1, -1}, {-1, 1, -1}, {-1, -1, 1}})
      add(corner * 0.5773502691896258);
  }
  return out;
}

GroundFit fit_on_ground(const Body& body, const std::vector<glm::dmat4>& from, const std::vector<glm::dmat4>& to) {
  const glm::dvec3 start = body.centre(from);
  const glm::dvec3 end = body.centre(to);
  const auto a = body.points(from);
  const auto b = body.points(to);
  double along = 0;
  double across = 0;
  for (size_t i = 0; i < a.size(); ++i) {
    const glm::dvec3 p = a[i].at - start;
    const glm::dvec3 q = b[i].at - end;
    along += a[i].mass * (p.x * q.x + p.z * q.z);
    across += a[i].mass * (q.x * p.z - q.z * p.x);
  }
  GroundFit fit;
  fit.displacement = end - start;
  fit.yaw = along == 0 && across == 0 ? 0.0 : std::atan2(across, along);
  const auto left = [&](double yaw) {
    const double sine = std::sin(yaw);
    const double cosine = std::cos(yaw);
    double sum = 0;
    for (size_t i = 0; i < a.size(); ++i) {
      const glm::dvec3 d = b[i].at - (turned(a[i].at - start, sine, cosine) + start + fit.displacement);
      sum += a[i].mass * glm::dot(d, d);
    }
    return std::sqrt(sum);
  };
  fit.left = left(fit.yaw);
  fit.left_unturned = left(0.0);
  return fit;
}

}  // namespace crowdbench::scene
