// Which joint carries which triangle, and in which pose the mesh is best captured: the choices before a relief bake,
// all on the CPU, in double, deterministic.
#pragma once
#include <array>
#include <cstdint>
#include <glm/glm.hpp>
#include <limits>
#include <string>
#include <vector>

#include "renderers/bake/bake_progress.h"
#include "scene/character/character.h"
#include "scene/pose/pose_bank.h"

namespace crowdbench::renderers {

// Which triangles a joint's box captures.
enum class TriangleRule : uint8_t {
  dominant,   // the one joint with the largest summed weight over the three vertices: gaps open when joints bend
  any,        // every joint with a non-zero weight on any vertex: no gaps, most overlap
  threshold,  // every joint whose summed weight (of 3) exceeds a threshold, and always the dominant one
};

// The pose in which the mesh is captured.
struct CapturePose {
  int clip = -1;     // into Character::clips; -1: the bind pose
  double phase = 0;  // [0, 1)
};
// Model-space palette of that pose, in double from the bank's matrices.
std::vector<glm::dmat4> capture_palette(const scene::Character& character, const CapturePose& pose);

// carrier[joint]: the joint whose box carries it; itself, unless joints were merged.
using Carriers = std::vector<int>;
Carriers own_carriers(const scene::Character& character);

inline constexpr size_t kShares = 8;  // two uvec4 of BoxRecord

// One joint's part in moving a piece.
struct Share {
  int joint = 0;
  double weight = 1;  // the mean over the piece's skin; of all shares together 1
  // How the weight changes over the piece, to first order: what this joint's matrix is multiplied by beside the mean,
  // from capture space (homogeneous). Over all shares these cancel at the capture pose.
  glm::dmat4 change{0.0};
};

// The part of a triangle that lies next to what a piece carries: its points whose weights of the corners that are not
// shared with the piece sum to at most `reach`.
struct Skirt {
  uint32_t triangle = 0;
  std::array<bool, 3> shared{};
  double reach = 1;
};

// What one box carries, and what moves it: a point p of capture space goes to the sum over the shares of
// M_joint (weight B^-1 + change) p, where B is the mean matrix, the sum of weight M_joint, at the capture pose.
struct Piece {
  std::vector<Share> shares;  // 1 to kShares, the heaviest first; the box stands along the first one's axes
  std::vector<uint32_t> triangles;
  std::vector<Skirt> skirts;  // of other pieces' triangles, so that no gap opens between boxes
  double texel = 0;           // metres; above 0: finer texels are not needed
  // In the first joint's own frame: what lies between is captured. A piece in parts has parts of the same surface.
  glm::dvec3 low{-std::numeric_limits<double>::infinity()};
  glm::dvec3 high{std::numeric_limits<double>::infinity()};
  int joint() const { return shares[0].joint; }
};
// The mean matrix: sum of weight times matrix.
glm::dmat4 matrix_of(const Piece& piece, const std::vector<glm::dmat4>& palette);
// Of every joint, the nearest joint above it; -1 for none.
std::vector<int> parents_of(const scene::Character& character);
// One piece for every joint that has triangles.
std::vector<Piece> joint_pieces(const scene::Character& character, TriangleRule rule, double threshold,
                                const Carriers& carriers);

// triangles_of[joint]: indices of the triangles that the joint's box captures; weights count for the carrier.
std::vector<std::vector<uint32_t>> assign_triangles(const scene::Character& character, TriangleRule rule,
                                                    double threshold, const Carriers& carriers);

// At most `most` poses spread evenly over a bank, each a palette in double.
std::vector<std::vector<glm::dmat4>> spread_poses(const scene::PoseBank& bank, size_t most);
// Zero for a matrix without volume, which carries nothing anywhere.
glm::dmat4 inverse_or_zero(const glm::dmat4& m);

// How far joints deviate when another joint carries them: the skin in some poses of a bank against the skin at the
// capture pose moved rigidly.
class JointMerger {
 public:
  // Up to 12 poses spread over the bank, up to 24 vertices a joint.
  JointMerger(const scene::Character& character, const scene::PoseBank& bank, const CapturePose& capture);
  // Merges joints with their parents, the least error first, while no joint's root-mean-square distance to where its
  // skin should be grows beyond `tolerance` metres (root of the sum of squares with what rigid skinning costs anyway).
  Carriers merged(double tolerance);

 private:
  double error(size_t joint, size_t carrier);  // mean square, metres^2
  std::vector<std::vector<size_t>> vertices_;  // sampled, by dominant joint
  std::vector<int> parent_;                    // nearest joint above, -1
  std::vector<std::vector<glm::dvec3>> posed_;
  std::vector<std::vector<glm::dmat4>> moved_;  // palette times the inverse of the palette at the capture
  std::vector<glm::dvec3> captured_;
  std::vector<double> errors_;  // memo, joint x joint; negative: not computed
};

// A pose's mean silhouette error over a bank: pixels that differ between the skin and the rigid pieces captured in that
// pose, over pixels of the skin, in three views (front, side, half-way) of up to eight poses, 96 pixels tall.
struct CaptureScore {
  CapturePose pose;
  double silhouette_error = 0;
  double box_volume = 0;  // metres^3, of all boxes
};
// The bind pose and eight phases of every clip of the bank; progress counts these poses.
std::vector<CaptureScore> score_captures(const scene::Character& character, const scene::PoseBank& bank,
                                         TriangleRule rule, double threshold, const BakeProgress& progress = {});
// The least error; among those within 2 % of it (of the error, relative), the least volume. scores not empty.
CaptureScore choose_capture(const std::vector<CaptureScore>& scores);

}  // namespace crowdbench::renderers
