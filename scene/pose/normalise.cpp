// How a loaded or built character is finished: turned, loops closed, travel measured, default clip chosen, placed on
// the ground, hashed.
#include "scene/pose/normalise.h"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <cctype>
#include <cmath>
#include <limits>
#include <map>
#include <optional>

#include "core/error.h"
#include "core/hash.h"
#include "scene/character/character.h"
#include "scene/pose/body.h"
#include "scene/pose/facing.h"
#include "scene/pose/hidden.h"
#include "scene/pose/human_bones.h"
#include "scene/pose/pose.h"
#include "scene/pose/pose_some.h"
#include "scene/pose/stance.h"
#include "scene/pose/stand.h"

namespace crowdbench::scene {
namespace {

constexpr double kSameTranslation = 1e-3;  // of the height: a loop's ends that differ by less need no closing
constexpr double kSameRotation = 5e-3;     // radians, likewise
constexpr double kRootMotion = 0.1;        // of the height: a smaller net displacement is sway, not travel
constexpr double kRootTurn = 0.05;         // radians: likewise for a net turn
// Who travels takes the feet along, by a quarter of the way in the mean at least, as one foot of two that steps after
// the other does, and ends in about the pose in which it began: what remains is at most this share of the displacement.
// Who sits down, leans or falls moves as far over feet that stay, or ends in another pose. Of the clips of nine
// characters those that travel leave at most 0.59 and 0.41 (KayKitKnight's Dodge_Forward); those that sit down 0.89 and
// 0.36, that die 0.85 and 0.52, a Block 0.71 and 0.86.
constexpr double kFeetBehind = 0.75;
constexpr double kLeftOfTravel = 0.5;
// Of a turn: of the displacement, or of the height.
constexpr double kLeftOfTurn = 0.35;
constexpr double kLeftOfHeight = 0.1;
// Of the default clip's first pose: clips in use that are lower, or whose body has its centre of mass lower above its
// lowest point, do not stand upright. What a figure holds counts for its height alone: a sword that reaches below who
// sits on the floor makes it as tall as it stands.
constexpr double kUpright = 0.75;
constexpr double kUprightCentre = 0.8;
constexpr double kMovingFeet = 0.05;  // of the height: a clip that moves a sole by more moves the feet
constexpr size_t kMaxSoles = 48;
constexpr int kMotionSamples = 24;  // poses of each clip, for its ground speed
constexpr double kPi = 3.14159265358979323846;

// A word in lower case, in a name of any case.
bool holds(const std::string& name, const char* word) {
  std::string lower = name;
  std::ranges::transform(lower, lower.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return lower.find(word) != std::string::npos;
}
bool holds_walk(const std::string& name) { return holds(name, "walk"); }

// The last key interval of a clip: the shortest among the channels that reach its end.
double last_interval(const Clip& clip) {
  double interval = clip.duration();
  for (const Channel& channel : clip.channels) {
    const size_t n = channel.times.size();
    if (n >= 2 && channel.times[n - 1] >= clip.end) {
      interval = std::min(interval, channel.times[n - 1] - channel.times[n - 2]);
    }
  }
  return interval;
}

glm::dvec3 horizontal(const glm::dvec3& v) { return {v.x, 0.0, v.z}; }

// Whether two poses agree, the second one's travel undone (glTF space)? Joints that carry nothing that is seen have no
// say: a root may stand still while the body travels.
bool same_pose(const Skeleton& skeleton, const Body& body, const std::vector<glm::dmat4>& a,
               const std::vector<glm::dmat4>& b, const ClipMotion& motion, double height) {
  const glm::dmat4 undone = travel_undone(motion, 1.0);
  for (size_t j = 0; j < skeleton.joints.size(); ++j) {
    if (!body.shown_by(j)) continue;
    const auto n = static_cast<size_t>(skeleton.joints[j].node);
    const glm::dmat4 back = undone * b[n];
    if (glm::length(glm::dvec3(back[3] - a[n][3])) > kSameTranslation * height) return false;
    for (int axis = 0; axis < 3; ++axis) {
      const double length = std::max(glm::length(glm::dvec3(a[n][axis])), 1e-30);
      if (glm::length(glm::dvec3(a[n][axis] - back[axis])) > kSameRotation * length) return false;
    }
  }
  return true;
}

// Enough to measure every clip by.
std::vector<uint32_t> thinned(const std::vector<uint32_t>& soles) {
  std::vector<uint32_t> out;
  const size_t step = soles.size() / kMaxSoles + 1;
  for (size_t i = 0; i < soles.size(); i += step) out.push_back(soles[i]);
  return out;
}

struct Measured {
  ClipMotion motion;  // in glTF units
  bool moves_feet = false;
};

// What all clips of a character are measured with; lengths in glTF units.
struct Measures {
  const Character& character;
  const Body& body;
  const std::vector<uint32_t>& soles;
  double height;                  // of the bind pose
  std::vector<size_t> bearing{};  // joints that move soles
  std::vector<bool> below{};      // by node: these joints' and all above
};

Measures measures_of(const Character& character, const Body& body, const std::vector<uint32_t>& soles, double height) {
  const Skeleton& skeleton = character.skeleton;
  Measures out{character, body, soles, height};
  std::vector<bool> bears(skeleton.joints.size(), false);
  for (const uint32_t v : soles)
    for (int i = 0; i < kInfluences; ++i)
      if (character.mesh.weights[v][i] != 0) bears[character.mesh.joints[v][i]] = true;
  out.below.assign(skeleton.nodes.size(), false);
  for (size_t j = 0; j < bears.size(); ++j) {
    if (!bears[j]) continue;
    out.bearing.push_back(j);
    for (int n = skeleton.joints[j].node; n >= 0; n = skeleton.nodes[static_cast<size_t>(n)].parent)
      out.below[static_cast<size_t>(n)] = true;
  }
  return out;
}

// Of the poses that a clip is measured by, from its first key to its last.
double sample_time(const Clip& clip, int i) {
  return i == kMotionSamples ? clip.end : clip.start + clip.duration() * i / kMotionSamples;
}

// The axis of the turn that takes `centre` to centre + displacement.
glm::dvec3 turning_axis(const glm::dvec3& centre, const glm::dvec3& displacement, double yaw) {
  const double c = 1.0 - std::cos(yaw);
  const double s = std::sin(yaw);
  const double det = c * c + s * s;
  const glm::dvec3 offset{(c * displacement.x + s * displacement.z) / det, 0.0,
                          (c * displacement.z - s * displacement.x) / det};
  return horizontal(centre) + offset;
}

// The turn of the whole clip: a fit knows it only up to full turns. A clip that ends as it began has none to strip.
double whole_turn(const Measures& of, int index, double net) {
  const Clip& clip = of.character.clips[static_cast<size_t>(index)];
  double sum = 0;
  std::vector<glm::dmat4> from = joint_matrices(of.character, index, clip.start);
  for (int i = 1; i <= kMotionSamples; ++i) {
    std::vector<glm::dmat4> to = joint_matrices(of.character, index, sample_time(clip, i));
    sum += fit_on_ground(of.body, from, to).yaw;
    from = std::move(to);
  }
  return net + 2 * kPi * std::nearbyint((sum - net) / (2 * kPi));
}

// How far the soles are from having gone where the body has, in the mean over their points.
double feet_behind(const SoleTracks& tracks, const glm::dvec3& displacement) {
  glm::dvec3 sum(0.0);
  for (size_t v = 0; v < tracks.poses[0].size(); ++v) sum += tracks.poses.back()[v] - tracks.poses.front()[v];
  const auto points = static_cast<double>(std::max<size_t>(tracks.poses[0].size(), 1));
  return glm::length(horizontal(displacement - sum / points));
}

// The palettes of a clip's first key and of its last.
struct Ends {
  int clip;
  std::vector<glm::dmat4> first, last;
};

// How the body travels over the ground from the first pose to the last.
void measure_travel(const Measures& of, const Ends& ends, const SoleTracks& tracks, ClipMotion& motion) {
  const GroundFit fit = fit_on_ground(of.body, ends.first, ends.last);
  const double far = glm::length(horizontal(fit.displacement));
  const double rise = std::abs(fit.displacement.y);  // stairs; what rises more than it goes forwards jumps or drops
  const bool turns = std::abs(fit.yaw) > kRootTurn && fit.left < 0.5 * fit.left_unturned &&
                     fit.left <= std::max(kLeftOfTurn * far, kLeftOfHeight * of.height) &&
                     rise <= std::max(far, kRootMotion * of.height);
  const bool travels = far > kRootMotion * of.height && fit.left_unturned <= kLeftOfTravel * far && rise <= far &&
                       feet_behind(tracks, fit.displacement) <= kFeetBehind * far;
  if (!turns && !travels) return;
  for (int axis = 0; axis < 3; ++axis) motion.root_displacement[axis] = settled(fit.displacement[axis], of.height);
  if (turns || rise <= kRootMotion * of.height) motion.root_displacement.y = 0;
  glm::dvec3 velocity = horizontal(motion.root_displacement) / tracks.duration;
  if (turns) {
    motion.root_yaw = settled(whole_turn(of, ends.clip, fit.yaw), 1.0);
    motion.root_axis = turning_axis(of.body.centre(ends.first), motion.root_displacement, motion.root_yaw);
    for (int axis = 0; axis < 3; ++axis) motion.root_axis[axis] = settled(motion.root_axis[axis], of.height);
    motion.yaw_rate = motion.root_yaw / tracks.duration;
    velocity = motion.yaw_rate * glm::dvec3(-motion.root_axis.z, 0.0, motion.root_axis.x);
  }
  const double speed = glm::length(velocity);
  if (speed <= kStillFoot * of.height) return;
  motion.ground_speed = speed;
  motion.direction = {settled(velocity.x / speed, 1.0), settled(velocity.z / speed, 1.0)};
}

// Where its feet say that it goes, or, where the clip is borrowed, those of the figure that it was made for.
void take_velocity(const glm::dvec2& velocity, double height, ClipMotion& motion) {
  const double speed = glm::length(velocity);
  if (speed <= kStillFoot * height) return;
  motion.from_stance = true;
  motion.ground_speed = settled(speed, height);
  motion.direction = {settled(velocity.x / speed, 1.0), settled(velocity.y / speed, 1.0)};
}

std::vector<glm::dmat4> palette_from(const Skeleton& skeleton, const std::vector<glm::dmat4>& nodes) {
  std::vector<glm::dmat4> palette;
  palette.reserve(skeleton.joints.size());
  for (const Joint& joint : skeleton.joints)
    palette.push_back(nodes[static_cast<size_t>(joint.node)] * joint.inverse_bind);
  return palette;
}

// The palette of joints that move soles; the others keep what they have.
void pose_soles(const Measures& of, int clip, double time, std::vector<glm::dmat4>& palette) {
  const std::vector<glm::dmat4> nodes = some_node_matrices(of.character, clip, time, of.below);
  for (const size_t j : of.bearing) {
    const Joint& joint = of.character.skeleton.joints[j];
    palette[j] = nodes[static_cast<size_t>(joint.node)] * joint.inverse_bind;
  }
}

// Travel, loop closing and ground speed of one clip.
Measured measure(const Measures& of, int index) {
  Measured out;
  const Character& character = of.character;
  const Clip& clip = character.clips[static_cast<size_t>(index)];
  const double duration = clip.duration();
  if (duration <= 0.0) return out;
  const std::vector<glm::dmat4> first = node_matrices(character, index, clip.start);  // by node
  const std::vector<glm::dmat4> last = node_matrices(character, index, clip.end);
  const Ends ends{index, palette_from(character.skeleton, first), palette_from(character.skeleton, last)};
  SoleTracks tracks{{}, of.height, duration};
  std::vector<glm::dmat4> palette = ends.first;
  for (int i = 0; i <= kMotionSamples; ++i) {
    if (i > 0 && !of.bearing.empty()) pose_soles(of, index, sample_time(clip, i), palette);
    std::vector<glm::dvec3>& points = tracks.poses.emplace_back();
    for (const uint32_t v : of.soles) points.push_back(skin_one(character.mesh, v, palette));
  }
  measure_travel(of, ends, tracks, out.motion);
  if (clip.loops && !same_pose(character.skeleton, of.body, first, last, out.motion, of.height))
    out.motion.closing_seconds = last_interval(clip);
  for (size_t v = 0; v < of.soles.size(); ++v)
    for (const auto& points : tracks.poses)
      if (glm::length(points[v] - tracks.poses[0][v]) > kMovingFeet * of.height) out.moves_feet = true;
  if (out.motion.root_displacement != glm::dvec3(0.0) || out.motion.root_yaw != 0) return out;
  if (clip.ground_velocity) {
    take_velocity(*clip.ground_velocity, of.height, out.motion);
  } else if (const std::optional<glm::dvec2> velocity = stance_velocity(tracks)) {
    out.motion.from_stance = true;
    take_velocity(*velocity, of.height, out.motion);
  }
  return out;
}

// Does that clip play clips of which each moves one node?
bool in_one_piece(const Character& character, int together) {
  const Clip& all = character.clips[static_cast<size_t>(together)];
  return std::ranges::none_of(character.clips, [&](const Clip& clip) {
    return !clip.together && clip.duration() > 0 && std::abs(clip.duration() - all.duration()) < 1e-3 &&
           std::ranges::any_of(clip.channels, [&](const Channel& c) { return c.node != clip.channels.front().node; });
  });
}

int choose_default_clip(const Character& character, const std::vector<Measured>& measured) {
  // Whoever brings clips wants to see them.
  const auto of_zero_length = [](const Clip& clip) { return clip.duration() <= 0.0; };
  const bool only_borrowed =
      std::ranges::any_of(character.clips, [&](const Clip& clip) { return clip.borrowed && !of_zero_length(clip); });
  int chosen = -1;
  int moving = -1;
  int walking = -1;
  int together = -1;
  for (int i = static_cast<int>(character.clips.size()) - 1; i >= 0; --i) {
    const Clip& clip = character.clips[static_cast<size_t>(i)];
    if (of_zero_length(clip) || (only_borrowed && !clip.borrowed)) continue;
    chosen = i;
    if (clip.together) together = i;
    if (measured[static_cast<size_t>(i)].moves_feet) moving = i;
    if (holds_walk(clip.name)) walking = i;
  }
  // Each of the clips that it plays is a piece of a movement.
  if (together >= 0 && (walking < 0 || in_one_piece(character, together))) return together;
  return walking >= 0 ? walking : moving >= 0 ? moving : chosen;
}

double first_height(const Character& character, int clip) {
  DrawnExtent extent(character);
  return posed_height(extent, shown_positions(character.mesh, model_matrices(character, clip, 0.0)));
}

// What bears the body, for how it stands.
struct Bearing {
  const Body& body;
  const std::vector<bool>& held;        // by vertex
  const std::vector<uint32_t>& unseen;  // vertices
};

// How far above its lowest point a body has its centre of mass, in a clip's first pose.
double first_centre(const Character& character, const Bearing& of, int clip) {
  const std::vector<glm::dmat4> palette = model_matrices(character, clip, 0.0);
  std::vector<glm::dvec3> posed = skin_positions(character.mesh, palette);
  put_aside(posed, of.unseen);
  double low = std::numeric_limits<double>::max();
  for (size_t v = 0; v < posed.size(); ++v)
    if (!of.held[v]) low = std::min(low, posed[v].y);
  return of.body.centre(palette).y - low;
}

// Placement::upright_clip.
int choose_upright_clip(const Character& character, const Bearing& bearing, const std::vector<std::string>& in_use) {
  const int standard = character.placement.default_clip;
  int tallest = standard;
  double most = -1;
  for (const std::string& name : in_use) {
    const std::optional<int> found = find_clip(character, name);
    if (!found && name != "none") continue;
    const int clip = found.value_or(-1);
    const double height = first_height(character, clip);
    if (height <= most) continue;
    most = height;
    tallest = clip;
  }
  if (tallest == standard) return standard;
  const bool upright =
      most >= kUpright * first_height(character, standard) &&
      first_centre(character, bearing, tallest) >= kUprightCentre * first_centre(character, bearing, standard);
  return upright ? tallest : standard;
}

// Puts a node that turns everything on top of the hierarchy.
void add_turning_node(Character& character, const glm::dquat& rotation) {
  Skeleton& skeleton = character.skeleton;
  Node top;
  top.name = "turned";
  top.rotation = rotation;
  for (Node& node : skeleton.nodes) ++node.parent;  // -1, a root, becomes 0
  skeleton.nodes.insert(skeleton.nodes.begin(), top);
  for (Joint& joint : skeleton.joints) ++joint.node;
  if (skeleton.root_node >= 0) ++skeleton.root_node;
  for (HumanBone& bone : skeleton.human_bones) ++bone.node;
  for (Primitive& primitive : character.mesh.primitives) ++primitive.node;
  for (Mesh& level : character.levels)
    for (Primitive& primitive : level.primitives) ++primitive.node;
  for (Clip& clip : character.clips) {
    for (Channel& channel : clip.channels) ++channel.node;
    if (!clip.ground_velocity) continue;
    const glm::dvec3 turned = rotation * glm::dvec3(clip.ground_velocity->x, 0.0, clip.ground_velocity->y);
    clip.ground_velocity = glm::dvec2(turned.x, turned.z);
  }
}

void orient(Character& character, const NormaliseOptions& options) {
  glm::dquat rotation(1.0, 0.0, 0.0, 0.0);
  if (options.turn_deg) rotation = glm::angleAxis(*options.turn_deg * kPi / 180, glm::dvec3(0.0, 1.0, 0.0));
  if (options.up == UpAxis::z) rotation = rotation * glm::angleAxis(-kPi / 2, glm::dvec3(1.0, 0.0, 0.0));
  if (rotation != glm::dquat(1.0, 0.0, 0.0, 0.0)) add_turning_node(character, rotation);
}

// Says what to do where the rest pose lies as it does in a file whose Z axis points up: the head beside the feet, along
// +Z.
void hint_at_up_axis(Character& character) {
  const std::map<Bone, int> bones = find_human_bones(character.skeleton, bone_candidates(character.skeleton));
  const auto head = bones.find({BonePart::head});
  const auto left = bones.find({BonePart::foot, BoneSide::left});
  const auto right = bones.find({BonePart::foot, BoneSide::right});
  if (head == bones.end() || left == bones.end() || right == bones.end()) return;
  const std::vector<glm::dmat4> nodes = node_matrices(character, -1, 0.0);
  const auto at = [&](const auto& bone) { return glm::dvec3(nodes[static_cast<size_t>(bone->second)][3]); };
  const glm::dvec3 rise = at(head) - 0.5 * (at(left) + at(right));
  if (rise.z <= 2 * std::max(std::abs(rise.x), std::abs(rise.y))) return;
  character.warnings.push_back(
      "the head lies beside the feet, along +Z; if Z points up in the file, up = \"z\" (--up-axis z) makes the "
      "character stand");
}

// The clip by which the character may be seen to face -Z: the default one where it goes that way, else, unless that one
// goes along +Z, the first that is called a walk or a run and does; -1: none. What is called backward goes backward.
int clip_along_minus_z(const Character& character) {
  const auto along = [&](int clip) {
    const ClipMotion& motion = character.motion[static_cast<size_t>(clip)];
    return motion.ground_speed > 0 ? motion.direction.y : 0.0;
  };
  const auto goes = [&](int clip) {
    const std::string& name = character.clips[static_cast<size_t>(clip)].name;
    return along(clip) <= -0.7 && !holds(name, "back") && !holds(name, "bwd");
  };
  const int standard = character.placement.default_clip;
  if (standard < 0 || along(standard) >= 0.7) return -1;
  if (goes(standard)) return standard;
  for (int clip = 0; clip < static_cast<int>(character.clips.size()); ++clip) {
    const std::string& name = character.clips[static_cast<size_t>(clip)].name;
    if ((holds_walk(name) || holds(name, "run")) && goes(clip)) return clip;
  }
  return -1;
}

// A VRM file, which says which node is which bone, that goes nowhere: only what it looks like tells version 0.x, which
// faces -Z, from 1.0.
bool is_still_and_named(const Character& character) {
  return !character.skeleton.human_bones.empty() &&
         std::ranges::none_of(character.motion, [](const ClipMotion& motion) { return motion.ground_speed > 0; });
}

// Does the character walk along -Z, or stand that way? What it looks like decides whether that is forwards: VRM 0.x
// files face -Z.
bool turn_was_guessed(Character& character, std::span<const glm::dvec3> bind, const std::vector<uint32_t>& soles) {
  const int clip = clip_along_minus_z(character);
  if (clip < 0 && !is_still_and_named(character)) return false;
  const std::string name = clip < 0 ? "" : printable(character.clips[static_cast<size_t>(clip)].name, 60);
  const std::string what =
      clip < 0 ? "no clip goes anywhere" : fmt::format("clip {} '{}' travels along -Z", clip, name);
  switch (compute_facing(character, bind, soles)) {
    case Facing::minus_z:
      add_turning_node(character, glm::dquat(0.0, 0.0, 1.0, 0.0));
      character.warnings.push_back(
          fmt::format("{}{} (as in VRM 0.x): turned by 180 degrees to face +Z; turn_deg = 0 leaves it as it is", what,
                      clip < 0 ? ", and feet and face point to -Z" : ", where feet and face point too"));
      return true;
    case Facing::unclear:
      if (clip >= 0)
        character.warnings.push_back(what + "; if that is forwards, turn_deg = 180 makes the character face +Z");
      break;
    case Facing::plus_z: break;
  }
  return false;
}

}  // namespace

int require_clip_or_none(const Character& character, const std::string& name_or_index) {
  return name_or_index == "none" && !find_clip(character, name_or_index) ? -1 : require_clip(character, name_or_index);
}

void normalise(Character& character, const NormaliseOptions& options) {
  assert(!character.mesh.positions.empty());
  if (options.up == UpAxis::y) hint_at_up_axis(character);
  orient(character, options);
  const std::vector<uint32_t> unseen = never_shown(character);
  auto bind = skin_positions(character.mesh, joint_matrices(character, -1, 0.0));
  put_aside(bind, unseen);
  DrawnExtent extent(character);
  const double bind_height = std::max(posed_height(extent, bind), 1e-30);
  const Body body(character, unseen);
  const std::vector<bool> held = find_held(character, bind);
  const std::vector<uint32_t> all_soles = find_soles(character, bind, held, unseen);
  const std::vector<uint32_t> soles = thinned(all_soles);

  // Posed in glTF space first: placement and motion are found there, then scaled.
  std::vector<Measured> measured;
  measured.reserve(character.clips.size());
  const Measures measures = measures_of(character, body, soles, bind_height);
  for (size_t i = 0; i < character.clips.size(); ++i) measured.push_back(measure(measures, static_cast<int>(i)));
  character.placement = {};
  character.placement.default_clip = choose_default_clip(character, measured);
  character.motion.clear();
  for (const Measured& m : measured) character.motion.push_back(m.motion);
  if (!options.turn_deg && turn_was_guessed(character, bind, soles)) {
    NormaliseOptions decided = options;
    decided.turn_deg = 0.0;
    decided.up = UpAxis::y;  // turned already
    normalise(character, decided);
    return;
  }

  Placement placement = character.placement;
  placement.upright_clip = choose_upright_clip(character, {body, held, unseen}, options.clips);
  character.placement.upright_clip = placement.upright_clip;
  const Stand stand = measure_stand(character, body, held, all_soles, bind_height);
  for (ClipMotion& motion : character.motion) motion.ground_speed = settled(motion.ground_speed, bind_height);
  placement.height = stand.height;
  if (options.height) {
    placement.scale = stand.height > 0.0 ? *options.height / stand.height : 1.0;
    placement.height = stand.height * placement.scale;
    placement.model_from_gltf = glm::dmat4(placement.scale);
    placement.model_from_gltf[3] = glm::dvec4(-stand.pivot.x * placement.scale, -stand.ground * placement.scale,
                                              -stand.pivot.z * placement.scale, 1.0);
  }
  character.placement = placement;
  for (ClipMotion& motion : character.motion) {
    motion.root_displacement *= placement.scale;
    motion.root_axis = glm::dvec3(placement.model_from_gltf * glm::dvec4(motion.root_axis, 1.0));
    motion.ground_speed *= placement.scale;
  }
  character.content_hash = compute_content_hash(character);
}

namespace {

void hash_matrix(Sha256& hash, const glm::dmat4& matrix) { hash.bytes(&matrix, sizeof matrix); }

void hash_skeleton(Sha256& hash, const Skeleton& skeleton) {
  hash.value(skeleton.root_node).value(skeleton.nodes.size());
  for (const Node& node : skeleton.nodes) {
    hash.text(node.name).value(node.parent).value(node.has_matrix);
    hash_matrix(hash, node.matrix);
    for (int i = 0; i < 3; ++i) hash.value(node.translation[i]).value(node.scale[i]);
    hash.value(node.rotation.x).value(node.rotation.y).value(node.rotation.z).value(node.rotation.w);
  }
  hash.value(skeleton.joints.size());
  for (const Joint& joint : skeleton.joints) {
    hash.value(joint.node).value(joint.rigid);
    hash_matrix(hash, joint.inverse_bind);
  }
}

void hash_mesh(Sha256& hash, const Mesh& mesh) {
  // glm's vectors are plain floats without padding, though their constructors keep them from counting as trivial.
  const auto vectors = [&](const auto& v) { hash.value(v.size()).bytes(v.data(), v.size() * sizeof(v[0])); };
  vectors(mesh.positions);
  vectors(mesh.normals);
  vectors(mesh.uvs);
  vectors(mesh.emissive_uvs);
  vectors(mesh.colours);
  vectors(mesh.joints);
  vectors(mesh.weights);
  hash.values(mesh.indices).value(mesh.primitives.size());
  for (const Primitive& p : mesh.primitives) {
    hash.value(p.first_index).value(p.index_count).value(p.first_vertex).value(p.vertex_count);
    hash.value(p.material).value(p.node).value(static_cast<uint8_t>((p.mirrored ? 1 : 0) | (p.flat ? 2 : 0)));
  }
}

void hash_surfaces(Sha256& hash, const std::vector<Material>& materials, const std::vector<Texture>& images) {
  hash.value(materials.size());
  for (const Material& m : materials) {
    hash.bytes(&m.base_colour, sizeof m.base_colour).value(m.base_colour_image);
    hash.bytes(&m.emissive, sizeof m.emissive).value(m.emissive_image);
    hash.value(m.unlit).value(m.double_sided).value(m.slot);
    // Only where there is one, so that the hashes of most characters are those of earlier versions.
    if (m.alpha_cutoff > 0) hash.value(m.alpha_cutoff).text("levels hold what masks leave");
  }
  hash.value(images.size());
  for (const Texture& t : images) {
    hash.value(t.image.width).value(t.image.height).value(t.image.channels).values(t.image.data);
    hash.value(t.repeat_u).value(t.repeat_v).value(t.mirrored_u).value(t.mirrored_v).value(t.nearest);
    // Only where it is not the usual one, so that the hashes of most characters are those of earlier versions.
    if (t.min_filter != MinFilter::linear_mipmap_linear) hash.value(t.min_filter);
  }
}

void hash_clips(Sha256& hash, const std::vector<Clip>& clips) {
  hash.value(clips.size());
  for (const Clip& clip : clips) {
    hash.text(clip.name).value(clip.start).value(clip.end).value(clip.loops).value(clip.channels.size());
    for (const Channel& c : clip.channels)
      hash.value(c.node).value(c.target).value(c.interpolation).values(c.times).values(c.values);
  }
}

void hash_motion(Sha256& hash, const std::vector<ClipMotion>& motions) {
  for (const ClipMotion& motion : motions) {
    for (int i = 0; i < 3; ++i) hash.value(motion.root_displacement[i]);
    hash.value(motion.ground_speed).value(motion.closing_seconds);
    // Only where they are not the usual ones, so that the hashes of most characters are those of earlier versions.
    if (motion.direction != glm::dvec2(0.0, 1.0)) hash.value(motion.direction.x).value(motion.direction.y);
    if (motion.root_yaw != 0) hash.value(motion.root_yaw).value(motion.root_axis.x).value(motion.root_axis.z);
  }
}

}  // namespace

std::string compute_content_hash(const Character& character) {
  Sha256 hash;
  hash.text("crowdbench character 1");
  hash_skeleton(hash, character.skeleton);
  hash_mesh(hash, character.mesh);
  hash_surfaces(hash, character.materials, character.images);
  hash_clips(hash, character.clips);
  hash_matrix(hash, character.placement.model_from_gltf);
  hash.value(character.placement.default_clip);
  hash_motion(hash, character.motion);
  return hash.hex();
}

}  // namespace crowdbench::scene
