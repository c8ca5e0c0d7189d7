// Based on: Khronos Group, "glTF 2.0 specification", sections 3.11 (animations) and appendix C (interpolation);
// K. Shoemake, "Animating rotation with quaternion curves" (1985), for spherical interpolation.
// Differs from the source: a spherical interpolation between nearly equal rotations is a normalised linear one, whose
// error is below rounding there; a loop is closed and its root motion stripped (see pose.h).
#include "scene/pose/pose.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>

#include "scene/pose/normalise.h"
#include "scene/pose/pose_some.h"

namespace crowdbench::scene {
namespace {

// The animatable part of every node, parallel to Skeleton::nodes.
struct LocalPose {
  std::vector<glm::dvec3> translation;
  std::vector<glm::dquat> rotation;
  std::vector<glm::dvec3> scale;
};

glm::dquat normalised(const glm::dquat& q) {
  const double length = std::sqrt(glm::dot(q, q));
  return length > 0.0 ? q * (1.0 / length) : glm::dquat{1.0, 0.0, 0.0, 0.0};
}

// Shortest arc: q and -q are the same rotation, so the nearer of the two is taken. After that the angle between the
// two is at most 90 degrees in quaternion space and its sine can only vanish where they are equal.
glm::dquat slerp(const glm::dquat& a, glm::dquat b, double t) {
  double cosine = glm::dot(a, b);
  if (cosine < 0.0) {
    b = -b;
    cosine = -cosine;
  }
  if (cosine > 1.0 - 1e-10) return normalised(a * (1.0 - t) + b * t);
  const double angle = std::acos(cosine);
  const double sine = std::sqrt(1.0 - cosine * cosine);
  return normalised(a * (std::sin((1.0 - t) * angle) / sine) + b * (std::sin(t * angle) / sine));
}

using Value = std::array<double, 4>;

// The channel's value at a time, clamped to its own keys. Rotations come out as x y z w, not normalised.
Value evaluate(const Channel& channel, double time) {
  const size_t width = channel.target == Target::rotation ? 4 : 3;
  const bool spline = channel.interpolation == Interpolation::cubic_spline;
  const size_t stride = spline ? 3 * width : width;
  const auto& times = channel.times;
  assert(!times.empty() && channel.values.size() == times.size() * stride);
  Value out{};
  const auto key = [&](size_t k, size_t part) { return channel.values.data() + k * stride + part * width; };
  const auto copy = [&](size_t k) {
    std::copy_n(key(k, spline ? 1 : 0), width, out.begin());
    return out;
  };
  if (time <= times.front()) return copy(0);
  if (time >= times.back()) return copy(times.size() - 1);
  const auto next = static_cast<size_t>(std::upper_bound(times.begin(), times.end(), time) - times.begin());
  const size_t last = next - 1;
  if (channel.interpolation == Interpolation::step) return copy(last);
  const double interval = times[next] - times[last];
  const double t = (time - times[last]) / interval;
  if (spline) {
    const double tt = t * t;
    const double ttt = tt * t;
    const double* p0 = key(last, 1);
    const double* m0 = key(last, 2);  // out-tangent, per second: scaled by the interval
    const double* p1 = key(next, 1);
    const double* m1 = key(next, 0);  // in-tangent
    for (size_t i = 0; i < width; ++i) {
      out[i] = (2.0 * ttt - 3.0 * tt + 1.0) * p0[i] + (ttt - 2.0 * tt + t) * interval * m0[i] +
               (-2.0 * ttt + 3.0 * tt) * p1[i] + (ttt - tt) * interval * m1[i];
    }
    return out;
  }
  const double* p0 = key(last, 0);
  const double* p1 = key(next, 0);
  if (channel.target == Target::rotation) {
    const glm::dquat q = slerp({p0[3], p0[0], p0[1], p0[2]}, {p1[3], p1[0], p1[1], p1[2]}, t);
    return {q.x, q.y, q.z, q.w};
  }
  for (size_t i = 0; i < width; ++i) out[i] = p0[i] + (p1[i] - p0[i]) * t;
  return out;
}

// wanted: by node; empty: all. The others stay as the file has them.
LocalPose local_pose(const Character& character, int clip, double time, const std::vector<bool>& wanted = {}) {
  const auto& nodes = character.skeleton.nodes;
  LocalPose pose;
  pose.translation.reserve(nodes.size());
  pose.rotation.reserve(nodes.size());
  pose.scale.reserve(nodes.size());
  for (const Node& node : nodes) {
    pose.translation.push_back(node.translation);
    pose.rotation.push_back(normalised(node.rotation));
    pose.scale.push_back(node.scale);
  }
  if (clip < 0) return pose;
  assert(static_cast<size_t>(clip) < character.clips.size());
  for (const Channel& channel : character.clips[static_cast<size_t>(clip)].channels) {
    const auto node = static_cast<size_t>(channel.node);
    if (!wanted.empty() && !wanted[node]) continue;
    const Value v = evaluate(channel, time);
    switch (channel.target) {
      case Target::translation: pose.translation[node] = {v[0], v[1], v[2]}; break;
      case Target::rotation: pose.rotation[node] = normalised({v[3], v[0], v[1], v[2]}); break;
      case Target::scale: pose.scale[node] = {v[0], v[1], v[2]}; break;
    }
  }
  return pose;
}

LocalPose blend(const LocalPose& a, const LocalPose& b, double t) {
  LocalPose out = a;
  for (size_t i = 0; i < a.translation.size(); ++i) {
    out.translation[i] = glm::mix(a.translation[i], b.translation[i], t);
    out.rotation[i] = slerp(a.rotation[i], b.rotation[i], t);
    out.scale[i] = glm::mix(a.scale[i], b.scale[i], t);
  }
  return out;
}

std::vector<glm::dmat4> world_matrices(const Skeleton& skeleton, const LocalPose& pose,
                                       const std::vector<bool>& wanted = {}) {
  std::vector<glm::dmat4> world(skeleton.nodes.size(), glm::dmat4(1.0));
  for (size_t i = 0; i < world.size(); ++i) {
    if (!wanted.empty() && !wanted[i]) continue;
    const Node& node = skeleton.nodes[i];
    glm::dmat4 local = node.matrix;
    if (!node.has_matrix) {
      const glm::dmat3 rotation = glm::mat3_cast(pose.rotation[i]);
      local = glm::dmat4(glm::dvec4(rotation[0] * pose.scale[i].x, 0.0), glm::dvec4(rotation[1] * pose.scale[i].y, 0.0),
                         glm::dvec4(rotation[2] * pose.scale[i].z, 0.0), glm::dvec4(pose.translation[i], 1.0));
    }
    assert(node.parent < static_cast<int>(i));
    world[i] = node.parent < 0 ? local : world[static_cast<size_t>(node.parent)] * local;
  }
  return world;
}

std::vector<glm::dmat4> palette_of(const Skeleton& skeleton, const std::vector<glm::dmat4>& world) {
  std::vector<glm::dmat4> palette;
  palette.reserve(skeleton.joints.size());
  for (const Joint& joint : skeleton.joints) {
    palette.push_back(world[static_cast<size_t>(joint.node)] * joint.inverse_bind);
  }
  return palette;
}

}  // namespace

std::vector<glm::dmat4> node_matrices(const Character& character, int clip, double time) {
  return world_matrices(character.skeleton, local_pose(character, clip, time));
}

std::vector<glm::dmat4> some_node_matrices(const Character& character, int clip, double time,
                                           const std::vector<bool>& wanted) {
  assert(wanted.size() == character.skeleton.nodes.size());
  return world_matrices(character.skeleton, local_pose(character, clip, time, wanted), wanted);
}

std::vector<glm::dmat4> joint_matrices(const Character& character, int clip, double time) {
  return palette_of(character.skeleton, node_matrices(character, clip, time));
}

glm::dmat4 travel_undone(const ClipMotion& motion, double progress) {
  glm::dmat4 out(1.0);
  if (motion.root_yaw == 0) {
    out[3] -= glm::dvec4(motion.root_displacement * progress, 0.0);
    return out;
  }
  const double sine = std::sin(-motion.root_yaw * progress);
  const double cosine = std::cos(-motion.root_yaw * progress);
  out[0] = {cosine, 0.0, -sine, 0.0};
  out[2] = {sine, 0.0, cosine, 0.0};
  const glm::dvec4 axis(motion.root_axis, 0.0);
  out[3] += axis - out * axis;
  return out;
}

std::vector<glm::dmat4> model_matrices(const Character& character, int clip, double phase) {
  std::vector<glm::dmat4> palette;
  glm::dmat4 place = character.placement.model_from_gltf;
  const double cycle = clip < 0 ? 0.0 : cycle_seconds(character, clip);
  if (cycle <= 0.0) {
    palette = joint_matrices(character, clip, clip < 0 ? 0.0 : character.clips[static_cast<size_t>(clip)].start);
  } else {
    const Clip& curves = character.clips[static_cast<size_t>(clip)];
    double progress = 0;
    const double seconds = std::clamp(phase, 0.0, 1.0) * cycle;
    if (seconds <= curves.duration()) {
      palette = joint_matrices(character, clip, curves.start + seconds);
      progress = seconds / curves.duration();
    } else {
      const double t = (seconds - curves.duration()) / (cycle - curves.duration());
      const LocalPose pose =
          blend(local_pose(character, clip, curves.end), local_pose(character, clip, curves.start), t);
      palette = palette_of(character.skeleton, world_matrices(character.skeleton, pose));
      progress = 1.0 - t;
    }
    place = travel_undone(character.motion[static_cast<size_t>(clip)], progress) * place;
  }
  for (glm::dmat4& matrix : palette) matrix = place * matrix;
  return palette;
}

double cycle_seconds(const Character& character, int clip) {
  assert(clip >= 0 && static_cast<size_t>(clip) < character.clips.size());
  assert(character.motion.size() == character.clips.size() && "normalise() comes first");
  const double duration = character.clips[static_cast<size_t>(clip)].duration();
  return duration > 0.0 ? duration + character.motion[static_cast<size_t>(clip)].closing_seconds : 0.0;
}

double phase_of_time(const Character& character, int clip, double time) {
  const double cycle = cycle_seconds(character, clip);
  if (cycle <= 0.0) return 0.0;
  const Clip& curves = character.clips[static_cast<size_t>(clip)];
  const double phase = (std::clamp(time, curves.start, curves.end) - curves.start) / cycle;
  if (phase < 1.0) return phase;
  return curves.loops ? 0.0 : std::nextafter(1.0, 0.0);
}

std::vector<glm::dvec3> skin_positions(const Mesh& mesh, const std::vector<glm::dmat4>& palette) {
  std::vector<glm::dvec3> out(mesh.positions.size());
  for (size_t v = 0; v < out.size(); ++v) {
    const glm::dvec4 position(mesh.positions[v], 1.0);
    glm::dvec4 sum(0.0);
    for (int i = 0; i < kInfluences; ++i) {
      const double weight = mesh.weights[v][i];
      if (weight != 0.0) sum += weight * (palette[mesh.joints[v][i]] * position);
    }
    out[v] = glm::dvec3(sum);
  }
  return out;
}

std::vector<glm::dvec3> skin_normals(const Mesh& mesh, const std::vector<glm::dmat4>& palette) {
  std::vector<glm::dvec3> out(mesh.normals.size());
  for (size_t v = 0; v < out.size(); ++v) {
    const glm::dvec3 normal(mesh.normals[v]);
    glm::dvec3 sum(0.0);
    for (int i = 0; i < kInfluences; ++i) {
      const double weight = mesh.weights[v][i];
      if (weight != 0.0) sum += weight * (glm::dmat3(palette[mesh.joints[v][i]]) * normal);
    }
    const double length = glm::length(sum);
    out[v] = length > 0.0 ? sum / length : normal;
  }
  return out;
}

}  // namespace crowdbench::scene
