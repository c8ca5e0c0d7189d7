// How a loaded or built character is finished: loops closed, root motion measured, default clip chosen, placed on the
// ground, hashed.
#include "scene/pose/normalise.h"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <cctype>
#include <cmath>
#include <limits>
#include <optional>

#include "core/error.h"
#include "core/hash.h"
#include "scene/character/character.h"
#include "scene/pose/pose.h"

namespace crowdbench::scene {
namespace {

constexpr double kSameTranslation = 1e-3;  // of the height: a loop's ends that differ by less need no closing
constexpr double kSameRotation = 5e-3;     // radians, likewise
constexpr double kRootMotion = 0.1;        // of the height: a smaller net displacement is sway, not travel
constexpr double kSoleBand = 0.05;         // of the height above the lowest point: these vertices can touch the ground
constexpr double kContact = 0.04;          // of the height above the clip's lowest sole point: in contact
constexpr double kStillFoot = 0.02;        // of the height a second: a foot that moves more slowly stands still
constexpr double kMovingFeet = 0.05;       // of the height: a clip that moves a sole by more moves the feet
constexpr size_t kMaxSoles = 48;
constexpr int kMotionSamples = 24;  // poses of each clip, for its ground speed
constexpr double kBoundsRate = 30.0;

bool holds_walk(const std::string& name) {
  std::string lower = name;
  std::ranges::transform(lower, lower.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return lower.find("walk") != std::string::npos;
}

// The node whose travel is the character's: the skin's root, or without a skin the first joint's topmost ancestor.
int travelling_node(const Skeleton& skeleton) {
  if (skeleton.root_node >= 0) return skeleton.root_node;
  if (skeleton.joints.empty()) return -1;
  int node = skeleton.joints.front().node;
  while (skeleton.nodes[static_cast<size_t>(node)].parent >= 0) node = skeleton.nodes[static_cast<size_t>(node)].parent;
  return node;
}

glm::dvec3 skin_one(const Mesh& mesh, uint32_t v, const std::vector<glm::dmat4>& palette) {
  const glm::dvec4 position(mesh.positions[v], 1.0);
  glm::dvec4 sum(0.0);
  for (int i = 0; i < kInfluences; ++i) {
    const double weight = mesh.weights[v][i];
    if (weight != 0.0) sum += weight * (palette[mesh.joints[v][i]] * position);
  }
  return glm::dvec3(sum);
}

struct Range {
  double low = std::numeric_limits<double>::max();
  double high = std::numeric_limits<double>::lowest();
  double size() const { return high > low ? high - low : 0.0; }
};

// Only the y row is worked out: this runs over every vertex of every pose of the default clip.
Range posed_heights(const Mesh& mesh, const std::vector<glm::dmat4>& palette) {
  Range range;
  std::vector<glm::dvec4> rows;
  rows.reserve(palette.size());
  for (const glm::dmat4& m : palette) rows.emplace_back(m[0][1], m[1][1], m[2][1], m[3][1]);
  for (size_t v = 0; v < mesh.positions.size(); ++v) {
    const glm::dvec4 position(mesh.positions[v], 1.0);
    double y = 0.0;
    for (int i = 0; i < kInfluences; ++i) {
      const double weight = mesh.weights[v][i];
      if (weight != 0.0) y += weight * glm::dot(rows[mesh.joints[v][i]], position);
    }
    range.low = std::min(range.low, y);
    range.high = std::max(range.high, y);
  }
  return range;
}

// Vertices that can touch the ground: the lowest of the bind pose. Held things (rigid meshes) count only where nothing
// else exists.
std::vector<uint32_t> find_soles(const Character& character, const std::vector<glm::dmat4>& bind) {
  const Mesh& mesh = character.mesh;
  const bool skinned = character.skeleton.root_node >= 0;
  std::vector<std::pair<double, uint32_t>> heights;
  heights.reserve(mesh.positions.size());
  double low = std::numeric_limits<double>::max();
  double high = std::numeric_limits<double>::lowest();
  for (uint32_t v = 0; v < mesh.positions.size(); ++v) {
    if (skinned && character.skeleton.joints[mesh.joints[v][0]].rigid) continue;
    const double y = skin_one(mesh, v, bind).y;
    heights.emplace_back(y, v);
    low = std::min(low, y);
    high = std::max(high, y);
  }
  std::vector<uint32_t> band;
  for (const auto& [y, v] : heights) {
    if (y <= low + kSoleBand * (high - low)) band.push_back(v);
  }
  std::vector<uint32_t> soles;
  const size_t step = band.size() / kMaxSoles + 1;
  for (size_t i = 0; i < band.size(); i += step) soles.push_back(band[i]);
  return soles;
}

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

// Whether two poses agree, the second moved back by `displacement` (glTF space)?
bool same_pose(const Skeleton& skeleton, const std::vector<glm::dmat4>& a, const std::vector<glm::dmat4>& b,
               const glm::dvec3& displacement, double height) {
  for (const Joint& joint : skeleton.joints) {
    const auto n = static_cast<size_t>(joint.node);
    if (glm::length(glm::dvec3(b[n][3] - a[n][3]) - displacement) > kSameTranslation * height) return false;
    for (int axis = 0; axis < 3; ++axis) {
      const double length = std::max(glm::length(glm::dvec3(a[n][axis])), 1e-30);
      if (glm::length(glm::dvec3(a[n][axis] - b[n][axis])) > kSameRotation * length) return false;
    }
  }
  return true;
}

// Rounded to a billionth of the character's size: poses between keys use libm, whose last bit differs by version, and
// what is kept here goes into every bake's key.
double settled(double value, double height) {
  int exponent = 0;
  std::frexp(height, &exponent);
  return std::ldexp(std::nearbyint(std::ldexp(value, 30 - exponent)), exponent - 30);
}

double median(std::vector<double>& values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

struct Measured {
  ClipMotion motion;  // in glTF units
  bool moves_feet = false;
};

// Root travel, loop closing and stance speed of one clip, in glTF units; `height` is the bind pose's, same units.
Measured measure(const Character& character, int index, int root, const std::vector<uint32_t>& soles, double height) {
  Measured out;
  const Clip& clip = character.clips[static_cast<size_t>(index)];
  const double duration = clip.duration();
  if (duration <= 0.0) return out;
  const auto first = node_matrices(character, index, clip.start);
  const auto last = node_matrices(character, index, clip.end);
  if (root >= 0) {
    const glm::dvec3 travel =
        horizontal(glm::dvec3(last[static_cast<size_t>(root)][3] - first[static_cast<size_t>(root)][3]));
    if (glm::length(travel) > kRootMotion * height) out.motion.root_displacement = travel;
  }
  if (clip.loops && !same_pose(character.skeleton, first, last, out.motion.root_displacement, height)) {
    out.motion.closing_seconds = last_interval(clip);
  }
  // Sole vertices over the clip: does any move, and how fast do those on the ground go backwards?
  std::vector<std::vector<glm::dvec3>> tracks;
  tracks.reserve(kMotionSamples + 1);
  double lowest = std::numeric_limits<double>::max();
  for (int i = 0; i <= kMotionSamples; ++i) {
    const auto palette = joint_matrices(character, index, clip.start + duration * i / kMotionSamples);
    std::vector<glm::dvec3> points;
    points.reserve(soles.size());
    for (const uint32_t v : soles) {
      points.push_back(skin_one(character.mesh, v, palette));
      lowest = std::min(lowest, points.back().y);
    }
    tracks.push_back(std::move(points));
  }
  for (size_t v = 0; v < soles.size(); ++v) {
    for (const auto& points : tracks) {
      if (glm::length(points[v] - tracks[0][v]) > kMovingFeet * height) out.moves_feet = true;
    }
  }
  // The point that stays lowest over an interval bears the weight; it counts while it is near the ground.
  std::vector<double> backward;
  for (size_t i = 0; i < kMotionSamples; ++i) {
    double best = lowest + kContact * height;
    std::optional<double> speed;
    for (size_t v = 0; v < soles.size(); ++v) {
      const glm::dvec3& a = tracks[i][v];
      const glm::dvec3& b = tracks[i + 1][v];
      if (std::max(a.y, b.y) > best) continue;
      best = std::max(a.y, b.y);
      speed = (a.z - b.z) * kMotionSamples / duration;
    }
    if (speed) backward.push_back(*speed);
  }
  if (out.motion.root_displacement != glm::dvec3(0.0)) {
    out.motion.ground_speed = glm::length(out.motion.root_displacement) / duration;
  } else if (!backward.empty()) {
    const double speed = median(backward);
    out.motion.from_stance = true;
    out.motion.ground_speed = speed > kStillFoot * height ? speed : 0.0;
  }
  return out;
}

}  // namespace

void normalise(Character& character, const NormaliseOptions& options) {
  assert(!character.mesh.positions.empty());
  const Mesh& mesh = character.mesh;
  const auto bind = joint_matrices(character, -1, 0.0);
  const double bind_height = std::max(posed_heights(mesh, bind).size(), 1e-30);
  const int root = travelling_node(character.skeleton);
  const auto soles = find_soles(character, bind);

  std::vector<Measured> measured;
  measured.reserve(character.clips.size());
  for (size_t i = 0; i < character.clips.size(); ++i) {
    measured.push_back(measure(character, static_cast<int>(i), root, soles, bind_height));
  }
  int chosen = -1;
  int moving = -1;
  int walking = -1;
  for (int i = static_cast<int>(character.clips.size()) - 1; i >= 0; --i) {
    const Clip& clip = character.clips[static_cast<size_t>(i)];
    if (clip.duration() <= 0.0) continue;
    chosen = i;
    if (measured[static_cast<size_t>(i)].moves_feet) moving = i;
    if (holds_walk(clip.name)) walking = i;
  }
  if (moving >= 0) chosen = moving;
  if (walking >= 0) chosen = walking;

  // Posed in glTF space first: placement and motion are found there, then scaled.
  Placement placement;
  placement.default_clip = chosen;
  character.placement = {};
  character.placement.default_clip = chosen;
  character.motion.clear();
  for (const Measured& m : measured) character.motion.push_back(m.motion);

  const double cycle = chosen < 0 ? 0.0 : cycle_seconds(character, chosen);
  const int samples = cycle > 0.0 ? std::clamp(static_cast<int>(std::ceil(cycle * kBoundsRate)), 2, 150) : 1;
  double lowest = std::numeric_limits<double>::max();
  double height = 0.0;
  glm::dvec3 pivot{0.0};
  for (int i = 0; i < samples; ++i) {
    const double phase = static_cast<double>(i) / samples;
    const Range range = posed_heights(mesh, model_matrices(character, chosen, phase));
    if (i == 0) height = range.size();
    lowest = std::min(lowest, range.low);
    if (root >= 0) {
      glm::dvec3 at{0.0};
      if (chosen < 0) {
        at = glm::dvec3(node_matrices(character, -1, 0.0)[static_cast<size_t>(root)][3]);
      } else {
        const Clip& clip = character.clips[static_cast<size_t>(chosen)];
        const double progress = std::min(phase * cycle / clip.duration(), 1.0);
        at = glm::dvec3(node_matrices(character, chosen,
                                      clip.start + progress * clip.duration())[static_cast<size_t>(root)][3]) -
             character.motion[static_cast<size_t>(chosen)].root_displacement * progress;
      }
      pivot += at / static_cast<double>(samples);
    }
  }
  lowest = settled(lowest, bind_height);
  for (int axis = 0; axis < 3; ++axis) pivot[axis] = settled(pivot[axis], bind_height);
  height = settled(height, bind_height);
  for (ClipMotion& motion : character.motion) motion.ground_speed = settled(motion.ground_speed, bind_height);
  placement.height = height;
  if (options.height) {
    placement.scale = height > 0.0 ? *options.height / height : 1.0;
    placement.height = height * placement.scale;
    placement.model_from_gltf = glm::dmat4(placement.scale);
    placement.model_from_gltf[3] =
        glm::dvec4(-pivot.x * placement.scale, -lowest * placement.scale, -pivot.z * placement.scale, 1.0);
  }
  character.placement = placement;
  for (ClipMotion& motion : character.motion) {
    motion.root_displacement *= placement.scale;
    motion.ground_speed *= placement.scale;
  }
  character.content_hash = compute_content_hash(character);
}

std::string compute_content_hash(const Character& character) {
  Sha256 hash;
  hash.text("crowdbench character 1");
  const Skeleton& skeleton = character.skeleton;
  const auto matrix = [&](const glm::dmat4& m) { hash.bytes(&m, sizeof m); };
  hash.value(skeleton.root_node).value(skeleton.nodes.size());
  for (const Node& node : skeleton.nodes) {
    hash.text(node.name).value(node.parent).value(node.has_matrix);
    matrix(node.matrix);
    for (int i = 0; i < 3; ++i) hash.value(node.translation[i]).value(node.scale[i]);
    hash.value(node.rotation.x).value(node.rotation.y).value(node.rotation.z).value(node.rotation.w);
  }
  hash.value(skeleton.joints.size());
  for (const Joint& joint : skeleton.joints) {
    hash.value(joint.node).value(joint.rigid);
    matrix(joint.inverse_bind);
  }
  const Mesh& mesh = character.mesh;
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
  hash.value(character.materials.size());
  for (const Material& m : character.materials) {
    hash.bytes(&m.base_colour, sizeof m.base_colour).value(m.base_colour_image);
    hash.bytes(&m.emissive, sizeof m.emissive).value(m.emissive_image);
    hash.value(m.unlit).value(m.double_sided).value(m.slot);
    // Only where there is one, so that the hashes of most characters are those of earlier versions.
    if (m.alpha_cutoff > 0) hash.value(m.alpha_cutoff);
  }
  hash.value(character.images.size());
  for (const Texture& t : character.images) {
    hash.value(t.image.width).value(t.image.height).value(t.image.channels).values(t.image.data);
    hash.value(t.repeat_u).value(t.repeat_v).value(t.mirrored_u).value(t.mirrored_v).value(t.nearest);
    // Only where it is not the usual one, so that the hashes of most characters are those of earlier versions.
    if (t.min_filter != MinFilter::linear_mipmap_linear) hash.value(t.min_filter);
  }
  hash.value(character.clips.size());
  for (const Clip& clip : character.clips) {
    hash.text(clip.name).value(clip.start).value(clip.end).value(clip.loops).value(clip.channels.size());
    for (const Channel& c : clip.channels) {
      hash.value(c.node).value(c.target).value(c.interpolation).values(c.times).values(c.values);
    }
  }
  matrix(character.placement.model_from_gltf);
  hash.value(character.placement.default_clip);
  for (const ClipMotion& motion : character.motion) {
    for (int i = 0; i < 3; ++i) hash.value(motion.root_displacement[i]);
    hash.value(motion.ground_speed).value(motion.closing_seconds);
  }
  return hash.hex();
}

}  // namespace crowdbench::scene
