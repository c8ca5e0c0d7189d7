// Solids of one joint whose pictures and depths are known by arithmetic.
#pragma once
#include <glm/glm.hpp>

#include "core/portable_math.h"
#include "scene/character/character.h"

namespace crowdbench::renderers::testing {

inline scene::Character one_joint_character() {
  scene::Character c;
  c.name = "solid";
  c.skeleton.nodes.push_back({.name = "root"});
  c.skeleton.joints.push_back({.name = "root", .node = 0});
  c.skeleton.root_node = 0;
  c.materials.push_back({.base_colour = {0.5F, 0.25F, 0.125F, 1.0F}, .slot = 3});
  return c;
}

inline void finish(scene::Character& c) {
  scene::Mesh& mesh = c.mesh;
  mesh.uvs.assign(mesh.positions.size(), glm::vec2(0));
  mesh.joints.assign(mesh.positions.size(), glm::u16vec4(0));
  mesh.weights.assign(mesh.positions.size(), glm::vec4(1, 0, 0, 0));
  mesh.primitives.push_back({.first_index = 0,
                             .index_count = static_cast<uint32_t>(mesh.indices.size()),
                             .first_vertex = 0,
                             .vertex_count = static_cast<uint32_t>(mesh.positions.size())});
}

inline scene::Character sphere(double radius, int rings) {
  scene::Character c = one_joint_character();
  const int sectors = 2 * rings;
  for (int i = 0; i <= rings; ++i) {
    for (int j = 0; j <= sectors; ++j) {
      const SinCos latitude = sincos_turns(0.5 * i / rings);
      const SinCos longitude = sincos_turns(static_cast<double>(j) / sectors);
      const glm::vec3 n(latitude.sin * longitude.cos, latitude.cos, latitude.sin * longitude.sin);
      c.mesh.positions.push_back(static_cast<float>(radius) * n);
      c.mesh.normals.push_back(n);
    }
  }
  const auto at = [&](int i, int j) { return static_cast<uint32_t>(i * (sectors + 1) + j); };
  for (int i = 0; i < rings; ++i)
    for (int j = 0; j < sectors; ++j)
      for (const uint32_t v : {at(i, j), at(i, j + 1), at(i + 1, j), at(i + 1, j), at(i, j + 1), at(i + 1, j + 1)})
        c.mesh.indices.push_back(v);
  finish(c);
  return c;
}

inline scene::Character box(glm::vec3 size) {
  scene::Character c = one_joint_character();
  for (int corner = 0; corner < 8; ++corner) {
    const glm::vec3 p = (glm::vec3(corner & 1, (corner >> 1) & 1, corner >> 2) - 0.5F) * size;
    c.mesh.positions.push_back(p);
    c.mesh.normals.push_back(glm::normalize(p));
  }
  c.mesh.indices = {0, 2, 1, 1, 2, 3, 4, 5, 6, 5, 7, 6, 0, 1, 4, 1, 5, 4,
                    2, 6, 3, 3, 6, 7, 0, 4, 2, 2, 4, 6, 1, 3, 5, 3, 7, 5};
  finish(c);
  return c;
}

// Moves another solid of one joint into `to`, translated; one primitive for all.
inline void append(scene::Character& to, const scene::Character& from, const glm::vec3& by) {
  scene::Mesh& mesh = to.mesh;
  const auto first = static_cast<uint32_t>(mesh.positions.size());
  for (const glm::vec3& p : from.mesh.positions) mesh.positions.push_back(p + by);
  mesh.normals.insert(mesh.normals.end(), from.mesh.normals.begin(), from.mesh.normals.end());
  for (const uint32_t i : from.mesh.indices) mesh.indices.push_back(first + i);
  mesh.primitives.clear();
  finish(to);
}

// Two upright prongs, 0.2 m wide and 0.4 m apart.
inline scene::Character fork() {
  scene::Character c = box({0.2F, 1.0F, 0.2F});
  for (glm::vec3& p : c.mesh.positions) p.x -= 0.3F;
  append(c, box({0.2F, 1.0F, 0.2F}), {0.3F, 0.0F, 0.0F});
  return c;
}

// A square rod between two points.
inline scene::Character rod(const glm::dvec3& from, const glm::dvec3& to, double width) {
  scene::Character c = box({1.0F, 1.0F, 1.0F});
  const glm::dvec3 along = to - from;
  const glm::dvec3 u = glm::normalize(glm::cross(along, glm::dvec3(0, 1, 0)));
  const glm::dvec3 v = glm::normalize(glm::cross(along, u));
  for (glm::vec3& p : c.mesh.positions) {
    const glm::dvec3 q(p);
    p = glm::vec3(from + (q.z + 0.5) * along + width * (q.x * u + q.y * v));
  }
  for (size_t i = 0; i < c.mesh.normals.size(); ++i) c.mesh.normals[i] = glm::normalize(c.mesh.positions[i]);
  return c;
}

// The side of a cone's frustum along Y, open at both ends: a wall without thickness.
inline scene::Character tube(double low_radius, double high_radius, double height, int sectors) {
  scene::Character c = one_joint_character();
  for (int i = 0; i <= sectors; ++i) {
    const SinCos turn = sincos_turns(static_cast<double>(i) / sectors);
    for (const bool high : {false, true}) {
      const double radius = high ? high_radius : low_radius;
      c.mesh.positions.push_back(glm::vec3(radius * turn.cos, (high ? 0.5 : -0.5) * height, radius * turn.sin));
      c.mesh.normals.push_back(glm::vec3(turn.cos, 0, turn.sin));
    }
  }
  for (int i = 0; i < sectors; ++i) {
    const auto at = static_cast<uint32_t>(2 * i);
    for (const uint32_t v : {at, at + 1, at + 2, at + 2, at + 1, at + 3}) c.mesh.indices.push_back(v);
  }
  finish(c);
  return c;
}

}  // namespace crowdbench::renderers::testing
