// Pieces: what one joint moves, as a surface of its own in the rest pose.
#pragma once
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "scene/character/character.h"
#include "scene/pose/pose_bank.h"

namespace crowdbench::renderers {

// The pose that pieces are cut and captured in: the bind pose, model space, metres. A joint that it scales to nothing,
// as game kits hide what is not held, takes its matrix from the first sample of the bank that shows it.
struct RestPose {
  std::vector<scene::Mat3x4> palette;         // by joint
  std::vector<scene::Mat3x4> inverse;         // of each; zeros where it has none
  std::vector<glm::vec3> positions, normals;  // by vertex; normals unit
};
RestPose rest_pose(const scene::Character& character, const scene::PoseBank& bank);

// Inverse of an affine map; zeros, and false, where its determinant is less than 1e-12 of what its scale would give.
bool invert_affine(const scene::Mat3x4& m, scene::Mat3x4& inverse);

// Which joints share a piece. A joint whose surface (by weight, with what already joined it) is less than `least` of
// all goes with the nearest joint above it: fingers with the hand.
struct JointPieces {
  std::vector<int> piece_of;  // by joint; -1: it moves nothing
  std::vector<int> joint;     // by piece: the one that carries it, an index into Skeleton::joints
  // By triangle. Where three or more share it so that none has half somewhere, the one that has most of the middle, to
  // which the triangle belongs whole, so that nothing is left out; else -1.
  std::vector<int> whole;
  int count() const { return static_cast<int>(joint.size()); }
};
JointPieces find_joint_pieces(const scene::Character& character, const RestPose& rest, double least);

// One piece's surface: corners lie on edges of the mesh, at `t` from a to b (a == b: at a vertex).
struct PieceSurface {
  struct Corner {
    uint32_t a = 0, b = 0;
    float t = 0;
  };
  std::vector<Corner> corners;
  std::vector<uint32_t> indices;          // triangles, into corners
  std::vector<uint32_t> primitive_first;  // by primitive of the mesh: its first index; one more at the end
};
// The surface on which the piece has at least `border` of the weights, which are linear along triangles. border: (0,
// 0.5]; two pieces of one joint meet at 0.5 and overlap below.
PieceSurface cut_joint_piece(const scene::Mesh& mesh, const JointPieces& pieces, int piece, float border);

// By triangle: the piece that has most of its middle.
std::vector<int> triangle_owners(const scene::Mesh& mesh, const JointPieces& pieces);

// Corners' positions of one of the mesh's arrays.
std::vector<glm::vec3> corner_positions(const PieceSurface& surface, const std::vector<glm::vec3>& positions);

// The piece as a character of one joint that does not move, drawn from both sides: its inside closes what a cut opens.
scene::Character piece_character(const scene::Character& character, const RestPose& rest, const PieceSurface& surface);

}  // namespace crowdbench::renderers
