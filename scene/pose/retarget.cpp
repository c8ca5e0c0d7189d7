#include "scene/pose/retarget.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <utility>

#include "core/error.h"
#include "scene/character/take_apart.h"
#include "scene/pose/counterparts.h"
#include "scene/pose/human_bones.h"
#include "scene/pose/pose.h"
#include "scene/pose/skeleton_rest.h"

namespace crowdbench::scene {
namespace {

constexpr double kSameRest = 0.01;         // radians: rests that differ by less are the same
constexpr double kSameLength = 1e-3;       // of the skeleton's size: likewise for translations
constexpr double kSameScale = 1e-3;        // likewise
constexpr double kKeyInterval = 1.0 / 60;  // seconds: the largest between two keys of a retargeted curve

// The shortest turn that takes one direction to the other.
glm::dquat arc(const glm::dvec3& from, const glm::dvec3& to) {
  const double lengths = glm::length(from) * glm::length(to);
  if (!(lengths > 1e-12)) return {1, 0, 0, 0};
  const double cosine = std::clamp(glm::dot(from, to) / lengths, -1.0, 1.0);
  glm::dvec3 axis = glm::cross(from, to);
  if (glm::length(axis) < 1e-9 * lengths) {
    if (cosine > 0) return {1, 0, 0, 0};
    axis = std::abs(from.x) < 0.5 * glm::length(from) ? glm::cross(from, {1, 0, 0}) : glm::cross(from, {0, 1, 0});
  }
  return glm::angleAxis(std::acos(cosine), glm::normalize(axis));
}

bool same_rest(Node a, Node b, double size) {
  if (!take_apart(a) || !take_apart(b)) return false;
  const double cosine = std::min(std::abs(glm::dot(a.rotation, b.rotation)), 1.0);
  return 2 * std::acos(cosine) <= kSameRest && glm::length(a.translation - b.translation) <= kSameLength * size &&
         glm::length(a.scale - b.scale) <= kSameScale * glm::length(a.scale);
}

// Whether curves of the source's local transforms are right for the target as they are: the bones that are moved, and
// what they hang on as far up as names agree, are at rest alike.
bool same_skeleton(const SkeletonRest& target, const SkeletonRest& source, const Counterparts& pairs) {
  if (!pairs.all_by_name()) return false;
  const double size = std::max(target.size, source.size);
  for (size_t i = 0; i < target.skeleton.nodes.size(); ++i) {
    auto t = static_cast<int>(i);
    for (int s = pairs.of(t); s >= 0 && t >= 0; s = source.skeleton.nodes[at(s)].parent) {
      const Node& mine = target.skeleton.nodes[at(t)];
      const Node& theirs = source.skeleton.nodes[at(s)];
      const bool is_pair = pairs.of(t) == s;
      if (!is_pair && mine.name != theirs.name) {
        if (pairs.of(t) >= 0) return false;  // it hangs on another moved bone
        break;
      }
      if (is_pair && !same_rest(mine, theirs, size)) return false;
      t = mine.parent;
    }
  }
  return true;
}

void refuse_mirrored(const SkeletonRest& rest) {
  for (const Node& node : rest.skeleton.nodes)
    if (node.has_matrix ? glm::determinant(glm::dmat3(node.matrix)) <= 0
                        : !(node.scale.x > 0 && node.scale.y > 0 && node.scale.z > 0))
      throw Error(
          rest.where,
          fmt::format("node {} is mirrored or has no size, so its clips cannot be carried from one skeleton to another",
                      printable(node.name, 60)),
          "apply the scale in the modelling program");
}

// All key times of a clip, none farther apart than kKeyInterval.
std::vector<double> key_times(const Clip& clip) {
  std::vector<double> times;
  for (const Channel& channel : clip.channels) times.insert(times.end(), channel.times.begin(), channel.times.end());
  std::ranges::sort(times);
  times.erase(std::unique(times.begin(), times.end(), [](double a, double b) { return b - a < 1e-6; }), times.end());
  std::vector<double> out;
  for (const double time : times) {
    if (!out.empty()) {
      const double from = out.back();
      const int steps = static_cast<int>(std::ceil((time - from) / kKeyInterval - 1e-9));
      for (int i = 1; i < steps; ++i) out.push_back(from + (time - from) * i / steps);
    }
    out.push_back(time);
  }
  return out;
}

class Retargeter {
 public:
  Retargeter(const Character& source, const SkeletonRest& source_rest, const SkeletonRest& target_rest,
             const Counterparts& pairs)
      : source_(source), from_(source_rest), to_(target_rest), pairs_(pairs), hips_(pairs.hips()) {
    find_bones_above();
    align();
    const auto mine = to_.leg_length();
    const auto theirs = from_.leg_length();
    ratio_ = mine && theirs && *theirs > 0 ? *mine / *theirs
                                           : height_of_hips(to_, hips_) / height_of_hips(from_, pairs_.of(hips_));
    if (!std::isfinite(ratio_) || ratio_ <= 0) ratio_ = from_.size > 0 ? to_.size / from_.size : 1.0;
  }

  Clip retarget(int index) const {
    const Clip& clip = source_.clips[at(index)];
    Clip out;
    out.name = clip.name;
    out.start = clip.start;
    out.end = clip.end;
    out.loops = clip.loops;
    const std::vector<double> times = key_times(clip);
    std::map<int, Channel> rotations;
    std::map<int, Channel> translations;
    for (const double time : times) add_keys(index, time, rotations, translations);
    for (auto* channels : {&translations, &rotations})
      for (auto& [node, channel] : *channels) out.channels.push_back(std::move(channel));
    return out;
  }

  // Where the source's feet say that its clip goes, in the target file's axes.
  std::optional<glm::dvec2> ground_velocity(int clip) const {
    if (source_.motion.size() != source_.clips.size()) return std::nullopt;
    const ClipMotion& motion = source_.motion[at(clip)];
    if (!motion.from_stance || !(source_.placement.scale > 0)) return std::nullopt;
    const glm::dvec3 theirs(motion.direction.x, 0.0, motion.direction.y);
    const glm::dvec3 direction = glm::conjugate(to_.upright) * (from_.upright * theirs);
    return motion.ground_speed / source_.placement.scale * ratio_ * glm::dvec2(direction.x, direction.z);
  }

  // Keys that one moment of a clip becomes.
  size_t values_a_key() const {
    size_t values = 0;
    for (size_t t = 0; t < to_.skeleton.nodes.size(); ++t)
      if (pairs_.of(static_cast<int>(t)) >= 0) values += 4 + (is_placed(static_cast<int>(t)) ? 3 : 0);
    return values;
  }

 private:
  static double height_of_hips(const SkeletonRest& rest, int hips) {
    double lowest = std::numeric_limits<double>::max();
    for (size_t i = 0; i < rest.world.size(); ++i) lowest = std::min(lowest, rest.position(static_cast<int>(i)).y);
    return rest.position(hips).y - lowest;
  }

  // Rigs that were driven by inverse kinematics hang the feet on the root. In a body they follow the lower legs.
  void find_bones_above() {
    for (const auto& [bone, node] : to_.bones) {
      if (pairs_.of(node) < 0 || node == hips_) continue;
      for (auto above = bone_above(bone); above; above = bone_above(*above)) {
        const auto found = to_.bones.find(*above);
        if (found == to_.bones.end() || pairs_.of(found->second) < 0) continue;
        if (!is_above(to_.skeleton, found->second, node)) hangs_on_[node] = found->second;
        break;
      }
    }
  }

  bool is_placed(int node) const { return node == hips_ || hangs_on_.contains(node); }

  std::optional<glm::dvec3> direction(const SkeletonRest& rest, const Bone& bone, const Bone& next) const {
    const auto a = rest.bones.find(bone);
    const auto b = rest.bones.find(next);
    if (a == rest.bones.end() || b == rest.bones.end()) return std::nullopt;
    return rest.position(b->second) - rest.position(a->second);
  }

  // Arms and legs at rest to where the source's point.
  void align() {
    aligned_.assign(to_.skeleton.nodes.size(), glm::dquat(1, 0, 0, 0));
    for (const BoneSide side : {BoneSide::left, BoneSide::right}) {
      const std::array<std::array<BonePart, 3>, 2> limbs = {
          {{BonePart::upper_arm, BonePart::lower_arm, BonePart::hand},
           {BonePart::upper_leg, BonePart::lower_leg, BonePart::foot}}};
      for (const auto& limb : limbs) {
        glm::dquat turn(1, 0, 0, 0);
        for (size_t i = 0; i < 2; ++i) {
          const Bone bone{limb[i], side, 0};
          const auto mine = direction(to_, bone, {limb[i + 1], side, 0});
          const auto theirs = direction(from_, bone, {limb[i + 1], side, 0});
          if (mine && theirs) turn = arc(turn * *mine, *theirs) * turn;
          set_aligned(bone, turn);
        }
        if (limb[2] != BonePart::hand) continue;
        for (const auto& [bone, node] : to_.bones)
          if (bone.side == side && (bone.part == BonePart::hand || bone.part >= BonePart::thumb))
            aligned_[at(node)] = turn;
      }
    }
  }

  void set_aligned(const Bone& bone, const glm::dquat& turn) {
    if (const auto found = to_.bones.find(bone); found != to_.bones.end()) aligned_[at(found->second)] = turn;
  }

  static void add(std::map<int, Channel>& channels, int node, Target target, double time, const glm::dvec3& v) {
    Channel& channel = channels[node];
    channel.node = node;
    channel.target = target;
    channel.times.push_back(time);
    channel.values.insert(channel.values.end(), {v.x, v.y, v.z});
  }

  static void add(std::map<int, Channel>& channels, int node, double time, glm::dquat q) {
    Channel& channel = channels[node];
    channel.node = node;
    channel.target = Target::rotation;
    if (const size_t n = channel.values.size(); n >= 4) {  // the shorter turn from the key before
      const double* before = &channel.values[n - 4];
      if (before[0] * q.x + before[1] * q.y + before[2] * q.z + before[3] * q.w < 0) q = -q;
    }
    channel.times.push_back(time);
    channel.values.insert(channel.values.end(), {q.x, q.y, q.z, q.w});
  }

  glm::dquat target_rotation(int node, const glm::dmat4& source_world) const {
    const glm::dquat turned = from_.upright * rotation_of(source_world);
    const glm::dquat since_rest = turned * glm::conjugate(from_.rotation(pairs_.of(node)));
    return glm::normalize(glm::conjugate(to_.upright) * since_rest * aligned_[at(node)] * to_.rotation(node));
  }

  glm::dvec3 hips_place(const glm::dmat4& source_world) const {
    const glm::dvec3 moved = from_.upright * place_of(source_world) - from_.position(pairs_.of(hips_));
    return glm::conjugate(to_.upright) * (to_.position(hips_) + ratio_ * moved);
  }

  // Where a bone lies that its own parents do not carry: as at rest, seen from the bone that does.
  glm::dvec3 carried_place(int node, const std::vector<glm::dmat4>& world) const {
    const int carrier = hangs_on_.at(node);
    return place_of(world[at(carrier)] * glm::inverse(to_.world[at(carrier)]) * to_.world[at(node)]);
  }

  void add_keys(int clip, double time, std::map<int, Channel>& rotations, std::map<int, Channel>& translations) const {
    const std::vector<glm::dmat4> source = node_matrices(source_, clip, time);
    std::vector<glm::dmat4> world(to_.skeleton.nodes.size());
    std::vector<bool> done(world.size(), false);
    const auto pose = [&](size_t t) {
      const auto node = static_cast<int>(t);
      Node local = to_.skeleton.nodes[t];
      const glm::dmat4 above = local.parent < 0 ? glm::dmat4(1.0) : world[at(local.parent)];
      if (pairs_.of(node) >= 0) {
        const glm::dmat4& theirs = source[at(pairs_.of(node))];
        local.rotation = glm::normalize(glm::conjugate(rotation_of(above)) * target_rotation(node, theirs));
        add(rotations, node, time, local.rotation);
        if (is_placed(node)) {
          const glm::dvec3 place = node == hips_ ? hips_place(theirs) : carried_place(node, world);
          local.translation = glm::dvec3(glm::inverse(above) * glm::dvec4(place, 1.0));
          add(translations, node, Target::translation, time, local.translation);
        }
      }
      world[t] = above * local_matrix(local);
      done[t] = true;
    };
    // Parents come first; a bone that hangs on another one waits for it, and its children for it.
    size_t posed = 0;
    for (size_t before = world.size() + 1; posed < world.size() && posed != before;) {
      before = posed;
      for (size_t t = 0; t < world.size(); ++t) {
        if (done[t]) continue;
        const int parent = to_.skeleton.nodes[t].parent;
        const auto carrier = hangs_on_.find(static_cast<int>(t));
        if ((parent >= 0 && !done[at(parent)]) || (carrier != hangs_on_.end() && !done[at(carrier->second)])) continue;
        pose(t);
        ++posed;
      }
    }
  }

  static glm::dmat4 local_matrix(const Node& node) {
    if (node.has_matrix) return node.matrix;
    glm::dmat4 m = glm::mat4_cast(node.rotation);
    for (int i = 0; i < 3; ++i) m[i] *= node.scale[i];
    m[3] = glm::dvec4(node.translation, 1.0);
    return m;
  }

  const Character& source_;
  const SkeletonRest& from_;
  const SkeletonRest& to_;
  const Counterparts& pairs_;
  int hips_;
  double ratio_ = 1;
  std::map<int, int> hangs_on_;      // target nodes
  std::vector<glm::dquat> aligned_;  // by target node, in the upright frame
};

Clip copied(const Clip& clip, const std::vector<int>& target_of) {
  Clip out = clip;
  out.channels.clear();
  for (Channel channel : clip.channels) {
    channel.node = target_of[at(channel.node)];
    if (channel.node >= 0) out.channels.push_back(std::move(channel));
  }
  return out;
}

void name_apart(const Character& target, const Character& source, Clip& clip) {
  const auto taken = [&](const std::string& name) {
    return std::ranges::any_of(target.clips, [&](const Clip& c) { return c.name == name; });
  };
  if (!clip.name.empty() && !taken(clip.name)) return;
  const std::string stem = clip.name.empty() ? source.name : fmt::format("{} ({})", clip.name, source.name);
  clip.name = stem;
  for (int n = 2; taken(clip.name); ++n) clip.name = fmt::format("{} {}", stem, n);
}

void warn_of_left_over(const SkeletonRest& source, const Counterparts& pairs, Character& target) {
  const std::vector<std::string> names = pairs.left_over();
  if (names.empty()) return;
  const size_t listed = std::min(names.size(), kNodesListed);
  target.warnings.push_back(fmt::format(
      "{}: {} nodes play its clips ({}); {} that it moves have no counterpart here: {}{}", source.where, pairs.count(),
      pairs.text(), names.size(), fmt::join(names.begin(), names.begin() + static_cast<std::ptrdiff_t>(listed), ", "),
      listed < names.size() ? ", ..." : ""));
}

}  // namespace

void add_clips_of(const Character& source, Character& target, const RetargetOptions& options) {
  SkeletonRest from(source);
  if (source.clips.empty()) throw Error(from.where, "has no clip to play", "name a file that holds animations");
  if (source.clips.size() + target.clips.size() > options.clips)
    throw Error(from.where,
                fmt::format("brings the clips to {}, the limit is {}", source.clips.size() + target.clips.size(),
                            options.clips),
                "split the file");
  std::vector<bool> animated(source.skeleton.nodes.size(), false);
  for (const Clip& clip : source.clips)
    for (const Channel& channel : clip.channels) animated[at(channel.node)] = true;

  SkeletonRest to(target);
  Counterparts pairs(to, from, animated);
  pairs.find(options.bones);
  const bool same = same_skeleton(to, from, pairs);
  if (!same) {
    refuse_mirrored(from);
    refuse_mirrored(to);
    pairs.leave_out_above(pairs.hips());
  }
  for (size_t t = 0; t < target.skeleton.nodes.size(); ++t)
    if (pairs.of(static_cast<int>(t)) >= 0 && !take_apart(target.skeleton.nodes[t]))
      throw Error(to.where,
                  fmt::format("node {} has a matrix with shear, which cannot be animated",
                              printable(target.skeleton.nodes[t].name, 60)),
                  "apply the node's transform in the modelling program");

  std::vector<int> target_of(source.skeleton.nodes.size(), -1);
  for (size_t t = 0; t < target.skeleton.nodes.size(); ++t)
    if (const int s = pairs.of(static_cast<int>(t)); s >= 0) target_of[at(s)] = static_cast<int>(t);
  const Retargeter retargeter(source, from, to, pairs);
  size_t keys = 0;
  for (size_t i = 0; i < source.clips.size(); ++i) {
    if (!same) keys += key_times(source.clips[i]).size() * retargeter.values_a_key();
    if (keys > options.keys)
      throw Error(from.where, fmt::format("gives over {} numbers of animation", options.keys),
                  "use fewer clips or keys");
    Clip clip = same ? copied(source.clips[i], target_of) : retargeter.retarget(static_cast<int>(i));
    if (clip.channels.empty()) clip.start = clip.end = 0;
    clip.borrowed = true;
    if (!same) clip.ground_velocity = retargeter.ground_velocity(static_cast<int>(i));
    name_apart(target, source, clip);
    target.clips.push_back(std::move(clip));
  }
  warn_of_left_over(from, pairs, target);
}

}  // namespace crowdbench::scene
