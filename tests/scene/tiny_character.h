// A character small enough to work out by hand: a root, and above it by one unit an arm with one vertex at each end.
#pragma once
#include <vector>

#include "scene/character/character.h"

namespace crowdbench::scene {

// Nodes: 0 root at the origin, 1 arm one unit above it. Vertices: 0 at the origin on the root, 1 at (0, 2, 0) and 2 at
// (0, 2, 0.5) on the arm. Two units tall.
inline Character tiny_character() {
  Character c;
  c.name = c.source = "tiny";
  Node root;
  root.name = "root";
  Node arm;
  arm.name = "arm";
  arm.parent = 0;
  arm.translation = {0.0, 1.0, 0.0};
  c.skeleton.nodes = {root, arm};
  Joint j0;
  j0.node = 0;
  Joint j1;
  j1.node = 1;
  j1.inverse_bind[3] = glm::dvec4(0.0, -1.0, 0.0, 1.0);
  c.skeleton.joints = {j0, j1};
  c.skeleton.root_node = 0;
  c.mesh.positions = {{0, 0, 0}, {0, 2, 0}, {0, 2, 0.5F}};
  c.mesh.normals = {{1, 0, 0}, {1, 0, 0}, {1, 0, 0}};
  c.mesh.uvs.resize(3);
  c.mesh.joints = {{0, 0, 0, 0}, {1, 0, 0, 0}, {1, 0, 0, 0}};
  c.mesh.weights = {{1, 0, 0, 0}, {1, 0, 0, 0}, {1, 0, 0, 0}};
  c.mesh.indices = {0, 1, 2};
  Primitive primitive;
  primitive.index_count = 3;
  primitive.vertex_count = 3;
  c.mesh.primitives = {primitive};
  c.materials.resize(1);
  return c;
}

inline Clip one_channel(std::string name, Channel channel) {
  Clip clip;
  clip.name = std::move(name);
  clip.start = channel.times.front();
  clip.end = channel.times.back();
  clip.channels = {std::move(channel)};
  return clip;
}

inline constexpr double kHalf = 0.70710678118654752;  // sine and cosine of 45 degrees

}  // namespace crowdbench::scene
