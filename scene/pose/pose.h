// Poses: curves evaluated in double, and linear blend skinning on the CPU (the oracle for the GPU mesh).
#pragma once
#include <glm/glm.hpp>
#include <vector>

#include "scene/character/character.h"

namespace crowdbench::scene {

// World matrices of all nodes in glTF space. clip -1: the nodes' own transforms. time: the file's own seconds; each
// channel clamps to its own key range. Rotations by slerp on the shortest arc, the rest linear; cubic splines by glTF's
// Hermite form, rotations renormalised.
std::vector<glm::dmat4> node_matrices(const Character& character, int clip, double time);

// Palette in glTF space: world(joint's node) * inverse bind, one for each entry of Skeleton::joints.
std::vector<glm::dmat4> joint_matrices(const Character& character, int clip, double time);

// Takes back how the body has moved over the ground when `progress` of a clip has passed (1: at its last key); in the
// space and unit of the motion.
glm::dmat4 travel_undone(const ClipMotion& motion, double progress);

// Palette in model space at a phase in [0, 1) of a looping clip: start + phase * duration, the body's travel and turn
// over the ground stripped, model_from_gltf applied. A loop whose last key does not repeat the first is closed by
// extending its cycle by one key interval, in which the last pose blends to the first.
std::vector<glm::dmat4> model_matrices(const Character& character, int clip, double phase);
// Seconds of one cycle as model_matrices plays it (duration plus the closing interval where there is one); 0 for a
// still clip.
double cycle_seconds(const Character& character, int clip);
// The phase at which model_matrices shows the file's own time (clamped to the clip); exact, not rounded to bank
// samples.
double phase_of_time(const Character& character, int clip, double time);

// Linear blend skinning: position = sum of weight * matrix * position.
std::vector<glm::dvec3> skin_positions(const Mesh& mesh, const std::vector<glm::dmat4>& palette);
// By the weighted upper 3x3 (not its inverse transpose), then normalised.
std::vector<glm::dvec3> skin_normals(const Mesh& mesh, const std::vector<glm::dmat4>& palette);

}  // namespace crowdbench::scene
