// Based on: Beacco, Spanlang, Andujar and Pelechano 2012 (geometry by the joint that drives it). Differs from the
// source: README.md.
#include "renderers/perjoint/perjoint_pieces.h"

#include <algorithm>
#include <cmath>
#include <map>

namespace crowdbench::renderers {
namespace {

glm::mat3 linear_part(const scene::Mat3x4& m) {
  return glm::transpose(glm::mat3(glm::vec3(m.rows[0]), glm::vec3(m.rows[1]), glm::vec3(m.rows[2])));
}

glm::vec3 shift_of(const scene::Mat3x4& m) { return {m.rows[0].w, m.rows[1].w, m.rows[2].w}; }

// Unit normals of the rest pose.
std::vector<glm::vec3> rest_normals(const scene::Mesh& mesh, const std::vector<scene::Mat3x4>& palette) {
  std::vector<glm::mat3> turns;
  for (const scene::Mat3x4& m : palette) {
    const glm::mat3 a = linear_part(m);
    const float determinant = glm::determinant(a);
    turns.push_back(std::abs(determinant) > 1e-30F ? glm::transpose(glm::inverse(a)) : glm::mat3(0.0F));
  }
  std::vector<glm::vec3> normals;
  for (size_t v = 0; v < mesh.normals.size(); ++v) {
    glm::vec3 sum(0.0F);
    for (int k = 0; k < scene::kInfluences; ++k) {
      const glm::vec3 turned = turns[mesh.joints[v][k]] * mesh.normals[v];
      const float length = glm::length(turned);
      if (length > 1e-30F) sum += mesh.weights[v][k] / length * turned;
    }
    const float length = glm::length(sum);
    normals.push_back(length > 1e-6F ? sum / length : mesh.normals[v]);
  }
  return normals;
}

float piece_share(const scene::Mesh& mesh, const JointPieces& pieces, uint32_t v, int piece) {
  float sum = 0;
  for (int k = 0; k < scene::kInfluences; ++k)
    if (pieces.piece_of[mesh.joints[v][k]] == piece) sum += mesh.weights[v][k];
  return sum;
}

struct Owner {
  int piece = -1;       // that has most of a triangle's middle
  bool shared = false;  // somewhere no piece has half
};

// Of weights by piece, summed over a triangle's corners, the largest.
std::pair<int, float> most_of(const std::map<int, glm::vec3>& shares, const glm::vec3& at) {
  std::pair<int, float> best{-1, 0.0F};
  for (const auto& [piece, share] : shares)
    if (const float sum = glm::dot(share, at); sum > best.second) best = {piece, sum};
  return best;
}

Owner owner_of(const scene::Mesh& mesh, const JointPieces& pieces, const std::array<uint32_t, 3>& triangle) {
  std::map<int, glm::vec3> shares;  // at the corners
  for (int corner = 0; corner < 3; ++corner) {
    const uint32_t v = triangle[static_cast<size_t>(corner)];
    for (int k = 0; k < scene::kInfluences; ++k)
      if (mesh.weights[v][k] > 0) shares[pieces.piece_of[mesh.joints[v][k]]][corner] += mesh.weights[v][k];
  }
  // Corners, middles of edges, and the middle.
  static const std::array<glm::vec3, 7> places = {
      glm::vec3(1, 0, 0),       glm::vec3(0, 1, 0),       glm::vec3(0, 0, 1),    glm::vec3(0.5F, 0.5F, 0),
      glm::vec3(0.5F, 0, 0.5F), glm::vec3(0, 0.5F, 0.5F), glm::vec3(1.0F / 3.0F)};
  Owner out;
  constexpr float kHalf = 0.4999F;
  for (const glm::vec3& place : places) {
    const auto [piece, share] = most_of(shares, place);
    out.piece = piece;
    out.shared = out.shared || share < kHalf;
  }
  return out;
}

std::array<uint32_t, 3> corners_of_triangle(const scene::Mesh& mesh, size_t triangle) {
  return {mesh.indices[3 * triangle], mesh.indices[3 * triangle + 1], mesh.indices[3 * triangle + 2]};
}

class PieceCutter {
 public:
  PieceCutter(const scene::Mesh& mesh, const JointPieces& pieces, int piece, float border, PieceSurface& out)
      : border_(border), out_(out) {
    shares_.reserve(mesh.positions.size());
    for (uint32_t v = 0; v < mesh.positions.size(); ++v) shares_.push_back(piece_share(mesh, pieces, v, piece));
  }

  bool touches(const std::array<uint32_t, 3>& t) const {
    return std::max({shares_[t[0]], shares_[t[1]], shares_[t[2]]}) >= border_;
  }

  void whole(const std::array<uint32_t, 3>& triangle) {
    for (const uint32_t v : triangle) out_.indices.push_back(corner(v, v));
  }

  void cut(const std::array<uint32_t, 3>& triangle) {
    std::array<uint32_t, 4> polygon{};
    size_t count = 0;
    for (size_t k = 0; k < 3; ++k) {
      const uint32_t a = triangle[k];
      const uint32_t b = triangle[(k + 1) % 3];
      if (shares_[a] >= border_) polygon[count++] = corner(a, a);
      if ((shares_[a] >= border_) != (shares_[b] >= border_)) polygon[count++] = corner(std::min(a, b), std::max(a, b));
    }
    for (size_t k = 2; k < count; ++k)
      out_.indices.insert(out_.indices.end(), {polygon[0], polygon[k - 1], polygon[k]});
  }

 private:
  uint32_t corner(uint32_t a, uint32_t b) {
    const auto [found, fresh] = corners_.try_emplace({a, b}, static_cast<uint32_t>(out_.corners.size()));
    if (fresh) {
      const float t = a == b ? 0.0F : std::clamp((border_ - shares_[a]) / (shares_[b] - shares_[a]), 0.0F, 1.0F);
      out_.corners.push_back({a, b, t});
    }
    return found->second;
  }

  float border_;
  PieceSurface& out_;
  std::vector<float> shares_;
  std::map<std::pair<uint32_t, uint32_t>, uint32_t> corners_;
};

// The surface that each node moves, by weight.
std::vector<double> node_areas(const scene::Character& character, const RestPose& rest) {
  const scene::Mesh& mesh = character.mesh;
  std::vector<double> areas(character.skeleton.nodes.size(), 0);
  for (size_t i = 0; i + 2 < mesh.indices.size(); i += 3) {
    const glm::dvec3 a(rest.positions[mesh.indices[i]]);
    const glm::dvec3 b(rest.positions[mesh.indices[i + 1]]);
    const glm::dvec3 c(rest.positions[mesh.indices[i + 2]]);
    const double area = glm::length(glm::cross(b - a, c - a)) / 6;
    for (size_t corner = 0; corner < 3; ++corner) {
      const uint32_t v = mesh.indices[i + corner];
      for (int k = 0; k < scene::kInfluences; ++k)
        areas[static_cast<size_t>(character.skeleton.joints[mesh.joints[v][k]].node)] +=
            area * static_cast<double>(mesh.weights[v][k]);
    }
  }
  return areas;
}

}  // namespace

bool invert_affine(const scene::Mat3x4& m, scene::Mat3x4& inverse) {
  const glm::dmat3 a(linear_part(m));
  const double scale = std::sqrt(glm::dot(a[0], a[0]) + glm::dot(a[1], a[1]) + glm::dot(a[2], a[2]));
  const double determinant = glm::determinant(a);
  inverse = {{glm::vec4(0.0F), glm::vec4(0.0F), glm::vec4(0.0F)}};
  if (scale < 1e-9 || std::abs(determinant) < 1e-12 * scale * scale * scale) return false;
  const glm::dmat3 b = glm::inverse(a);
  const glm::dvec3 shift = -(b * glm::dvec3(shift_of(m)));
  for (int row = 0; row < 3; ++row)
    inverse.rows[row] = glm::vec4(glm::dvec4(b[0][row], b[1][row], b[2][row], shift[row]));
  return true;
}

RestPose rest_pose(const scene::Character& character, const scene::PoseBank& bank) {
  RestPose rest;
  const scene::PoseBank bind = scene::PoseBank::exact(character, -1, 0);
  rest.palette = bind.palette(bind.sample(0, 0));
  const auto joints = static_cast<size_t>(bank.joints());
  rest.inverse.resize(joints);
  for (size_t j = 0; j < joints; ++j)
    for (size_t s = 0; !invert_affine(rest.palette[j], rest.inverse[j]) && s < bank.matrices().size() / joints; ++s)
      rest.palette[j] = bank.matrices()[s * joints + j];
  rest.positions = scene::skin_points(character.mesh, rest.palette);
  rest.normals = rest_normals(character.mesh, rest.palette);
  return rest;
}

JointPieces find_joint_pieces(const scene::Character& character, const RestPose& rest, double least) {
  const auto& nodes = character.skeleton.nodes;
  const auto& joints = character.skeleton.joints;
  std::vector<double> areas = node_areas(character, rest);
  double total = 0;
  for (const double a : areas) total += a;
  std::vector<int> joint_of(nodes.size(), -1);
  for (size_t j = joints.size(); j-- > 0;)
    if (rest.inverse[j].rows[0] != glm::vec4(0.0F) || rest.inverse[j].rows[1] != glm::vec4(0.0F))
      joint_of[static_cast<size_t>(joints[j].node)] = static_cast<int>(j);
  // Nodes that a joint hangs on, from the leaves up: parents come before children.
  std::vector<int> with(nodes.size());
  for (size_t n = 0; n < nodes.size(); ++n) with[n] = static_cast<int>(n);
  for (size_t n = nodes.size(); n-- > 0;) {
    if (areas[n] <= 0 || (areas[n] >= least * total && joint_of[n] >= 0)) continue;
    int above = nodes[n].parent;
    while (above >= 0 && joint_of[static_cast<size_t>(above)] < 0) above = nodes[static_cast<size_t>(above)].parent;
    if (above < 0) continue;
    with[n] = above;
    areas[static_cast<size_t>(above)] += areas[n];
    areas[n] = 0;
  }
  JointPieces out;
  std::vector<int> piece_of_node(nodes.size(), -1);
  for (size_t n = 0; n < nodes.size(); ++n) {
    if (with[n] != static_cast<int>(n)) {
      piece_of_node[n] = piece_of_node[static_cast<size_t>(with[n])];
    } else if (areas[n] > 0 && joint_of[n] >= 0) {
      piece_of_node[n] = out.count();
      out.joint.push_back(joint_of[n]);
    }
  }
  for (const scene::Joint& j : joints) out.piece_of.push_back(piece_of_node[static_cast<size_t>(j.node)]);
  for (size_t t = 0; t < character.triangles(); ++t) {
    const Owner owner = owner_of(character.mesh, out, corners_of_triangle(character.mesh, t));
    out.whole.push_back(owner.shared ? owner.piece : -1);
  }
  return out;
}

std::vector<int> triangle_owners(const scene::Mesh& mesh, const JointPieces& pieces) {
  std::vector<int> owners;
  for (size_t t = 0; t < mesh.indices.size() / 3; ++t)
    owners.push_back(owner_of(mesh, pieces, corners_of_triangle(mesh, t)).piece);
  return owners;
}

PieceSurface cut_joint_piece(const scene::Mesh& mesh, const JointPieces& pieces, int piece, float border) {
  PieceSurface out;
  PieceCutter cutter(mesh, pieces, piece, border, out);
  for (const scene::Primitive& primitive : mesh.primitives) {
    out.primitive_first.push_back(static_cast<uint32_t>(out.indices.size()));
    for (uint32_t t = primitive.first_index / 3; t < (primitive.first_index + primitive.index_count) / 3; ++t) {
      const std::array<uint32_t, 3> triangle = corners_of_triangle(mesh, t);
      if (pieces.whole[t] == piece)
        cutter.whole(triangle);
      else if (cutter.touches(triangle))
        cutter.cut(triangle);
    }
  }
  out.primitive_first.push_back(static_cast<uint32_t>(out.indices.size()));
  return out;
}

std::vector<glm::vec3> corner_positions(const PieceSurface& surface, const std::vector<glm::vec3>& positions) {
  std::vector<glm::vec3> out;
  for (const PieceSurface::Corner& c : surface.corners) out.push_back(glm::mix(positions[c.a], positions[c.b], c.t));
  return out;
}

namespace {

// The corners that one primitive uses, numbered from `first` on, and its indices.
void add_primitive(const scene::Mesh& from, const RestPose& rest, const PieceSurface& surface,
                   std::span<const uint32_t> indices, scene::Mesh& to) {
  std::map<uint32_t, uint32_t> numbers;
  for (const uint32_t i : indices) {
    const auto [found, fresh] = numbers.try_emplace(i, static_cast<uint32_t>(to.positions.size()));
    to.indices.push_back(found->second);
    if (!fresh) continue;
    const auto& [a, b, t] = surface.corners[i];
    to.positions.push_back(glm::mix(rest.positions[a], rest.positions[b], t));
    const glm::vec3 normal = glm::mix(rest.normals[a], rest.normals[b], t);
    const float length = glm::length(normal);
    to.normals.push_back(length > 1e-6F ? normal / length : rest.normals[a]);
    to.uvs.push_back(glm::mix(from.uvs[a], from.uvs[b], t));
    if (!from.emissive_uvs.empty()) to.emissive_uvs.push_back(glm::mix(from.emissive_uvs[a], from.emissive_uvs[b], t));
    if (!from.colours.empty()) to.colours.push_back(glm::mix(from.colours[a], from.colours[b], t));
    to.joints.emplace_back(0);
    to.weights.emplace_back(1.0F, 0.0F, 0.0F, 0.0F);
  }
}

}  // namespace

scene::Character piece_character(const scene::Character& character, const RestPose& rest, const PieceSurface& surface) {
  scene::Character out;
  out.name = character.name;
  out.content_hash = character.content_hash;
  out.materials = character.materials;
  out.images = character.images;
  for (scene::Material& material : out.materials) material.double_sided = true;
  out.skeleton.nodes.emplace_back();
  out.skeleton.joints.emplace_back();
  out.skeleton.root_node = 0;
  out.mesh.primitives = character.mesh.primitives;
  for (size_t p = 0; p < out.mesh.primitives.size(); ++p) {
    scene::Primitive& primitive = out.mesh.primitives[p];
    primitive.node = 0;
    primitive.first_vertex = static_cast<uint32_t>(out.mesh.positions.size());
    primitive.first_index = static_cast<uint32_t>(out.mesh.indices.size());
    const uint32_t first = surface.primitive_first[p];
    add_primitive(character.mesh, rest, surface,
                  std::span(surface.indices).subspan(first, surface.primitive_first[p + 1] - first), out.mesh);
    primitive.vertex_count = static_cast<uint32_t>(out.mesh.positions.size()) - primitive.first_vertex;
    primitive.index_count = static_cast<uint32_t>(out.mesh.indices.size()) - primitive.first_index;
  }
  return out;
}

}  // namespace crowdbench::renderers
