#include "scene/gltf/gltf_clips.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include "core/error.h"
#include "scene/character/take_apart.h"

namespace crowdbench::scene {
namespace {

constexpr double kSameTime = 1e-4;  // seconds: keys are floats
constexpr double kJump = 1e-5;      // seconds, at most, that a curve takes to jump

// What the clips of a file are warned about once.
struct Warned {
  bool rotation = false;
  bool times = false;
};

// warned: that one had to be.
void normalise_rotation(GltfAsset& asset, double* q, const AccessorView& view, size_t i, bool& warned) {
  const double length = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
  if (length < 1e-6) asset.fail(view.path, fmt::format("rotation {} is a quaternion of length zero", i));
  if (std::abs(length - 1.0) > 1e-2 && !warned) {
    asset.warn(fmt::format("{}: rotation {} of length {:.3g} is normalised", view.path, i, length));
    warned = true;
  }
  for (int c = 0; c < 4; ++c) q[c] /= length;
}

// The keys that count, and their times. Of keys at one time the last counts from that time on, and the first just until
// then: the curve jumps.
std::vector<size_t> read_times(GltfAsset& asset, const AccessorView& input, std::vector<double>& times, bool& warned) {
  std::vector<size_t> keys;
  bool jumps = false;  // the last two kept are of one time
  for (size_t i = 0; i < input.count; ++i) {
    const double t = asset.finite(input, i, 0);
    if (t < -asset.limits.clip_seconds)
      asset.fail(input.path,
                 fmt::format("key {} is at {} s, the limit is {} before 0", i, t, asset.limits.clip_seconds),
                 "move the keys in the animation program");
    if (t > asset.limits.clip_seconds)
      asset.fail(input.path, fmt::format("key {} is at {} s, the limit is {}", i, t, asset.limits.clip_seconds),
                 "cut the clip in the animation program");
    if (!times.empty() && t < times.back())
      asset.fail(input.path, fmt::format("key {} at {} s is before key {} at {} s", i, t, i - 1, times.back()),
                 "sort the keys in the animation program");
    const bool again = !times.empty() && t == times.back();
    if (again && !warned)
      asset.warn(
          fmt::format("{}: keys {} and {} are both at {} s; the last counts from then on", input.path, i - 1, i, t));
    warned = warned || again;
    if (again && (jumps || times.size() == 1)) {
      keys.back() = i;
      continue;
    }
    jumps = again;
    if (again) times.back() = std::max(t - kJump, 0.5 * (times[times.size() - 2] + t));
    times.push_back(t);
    keys.push_back(i);
  }
  return keys;
}

// The specification wants translation, rotation and scale on an animated node; a matrix without shear is the same.
void make_animatable(GltfAsset& asset, Node& node, int file_index, const std::string& path) {
  if (!node.has_matrix) return;
  if (!take_apart(node))
    asset.fail(path, fmt::format("animates node {}, whose matrix has shear or no volume", file_index),
               "apply the node's transform in the modelling program");
  asset.warn(fmt::format("{}: animates node {}, which has a matrix; it is taken apart", path, file_index));
}

Channel read_channel(GltfAsset& asset, const GltfChannel& in, const std::string& path, Warned& warned) {
  Channel out;
  out.node = asset.node_of[index_of(in.node)];
  out.target = in.target;
  out.interpolation = in.curve.interpolation;
  make_animatable(asset, asset.character.skeleton.nodes[index_of(out.node)], in.node, path);
  const AccessorView& input = asset.view_of(in.curve.input);
  const std::vector<size_t> keys = read_times(asset, input, out.times, warned.times);
  const AccessorView& output = asset.view_of(in.curve.output);
  const bool cubic = out.interpolation == Interpolation::cubic_spline;
  const size_t each = cubic ? 3 : 1;
  out.values.reserve(keys.size() * each * static_cast<size_t>(output.components));
  for (size_t k = 0; k < keys.size() * each; ++k) {
    const size_t i = keys[k / each] * each + k % each;
    const size_t at = out.values.size();
    for (int c = 0; c < output.components; ++c) out.values.push_back(asset.finite(output, i, c));
    // The tangents of a spline are not rotations.
    if (out.target == Target::rotation && (!cubic || i % 3 == 1))
      normalise_rotation(asset, &out.values[at], output, i, warned.rotation);
  }
  return out;
}

// Some exporters count time from another moment than the clip's begin; the specification wants no key before 0.
void shift_to_zero(GltfAsset& asset, Clip& clip, size_t index) {
  if (clip.channels.empty() || clip.start >= 0) return;
  const double shift = -clip.start;
  for (Channel& channel : clip.channels)
    for (double& time : channel.times) time += shift;
  asset.warn(fmt::format("/animations/{}: begins at {:.6g} s, before 0; all its keys are {:.6g} s later", index,
                         clip.start, shift));
  clip.start = 0;
  clip.end += shift;
}

// The clips of that length, or none where two of them move the same.
std::vector<size_t> apart(const std::vector<Clip>& clips, double start, double end) {
  std::vector<size_t> found;
  std::set<std::pair<int, Target>> moved;
  for (size_t i = 0; i < clips.size(); ++i) {
    const Clip& clip = clips[i];
    if (clip.channels.empty() || std::abs(clip.start - start) > kSameTime || std::abs(clip.end - end) > kSameTime)
      continue;
    for (const Channel& channel : clip.channels)
      if (!moved.emplace(channel.node, channel.target).second) return {};
    found.push_back(i);
  }
  return found;
}

// Some exporters write one animation a channel. Clips of one length of which no two move the same play at once.
void offer_together(GltfAsset& asset) {
  auto& clips = asset.character.clips;
  const size_t own = clips.size();
  std::vector<bool> seen(own, false);
  for (size_t i = 0; i < own && clips.size() < asset.limits.clips; ++i) {
    if (seen[i] || clips[i].duration() <= 0) continue;
    const std::vector<size_t> together = apart(clips, clips[i].start, clips[i].end);
    for (size_t j = i; j < own; ++j)
      if (std::abs(clips[j].start - clips[i].start) <= kSameTime && std::abs(clips[j].end - clips[i].end) <= kSameTime)
        seen[j] = true;
    if (together.size() < 2) continue;
    Clip all;
    all.name = "together";
    all.together = true;
    all.start = clips[i].start;
    all.end = clips[i].end;
    std::string names;
    for (const size_t k : together) {
      all.channels.insert(all.channels.end(), clips[k].channels.begin(), clips[k].channels.end());
      all.end = std::max(all.end, clips[k].end);
      all.start = std::min(all.start, clips[k].start);
      if (names.size() < 200)
        names += fmt::format("{}{}", names.empty() ? "" : ", ",
                             clips[k].name.empty() ? fmt::format("{}", k) : printable(clips[k].name, 40));
      else if (!names.ends_with("..."))
        names += ", ...";
    }
    asset.warn(fmt::format("{} clips are equally long and move different things ({}); clip {} '{}' plays them at once",
                           together.size(), names, clips.size(), all.name));
    clips.push_back(std::move(all));
  }
}

}  // namespace

void read_clips(GltfAsset& asset) {
  const GltfModel& model = asset.plan.model;
  if (model.animations.size() * std::max<size_t>(model.nodes.size(), 1) > asset.limits.clip_nodes)
    asset.fail("/animations", fmt::format("{} clips of {} nodes, the limit is a product of {}", model.animations.size(),
                                          model.nodes.size(), asset.limits.clip_nodes));
  std::vector<std::string> still;
  Warned warned;
  for (size_t a = 0; a < model.animations.size(); ++a) {
    const GltfAnimation& in = model.animations[a];
    const std::string path = fmt::format("/animations/{}", a);
    Clip clip;
    clip.name = in.name;
    clip.start = asset.limits.magnitude;
    clip.end = -asset.limits.magnitude;
    for (const GltfChannel& channel : in.channels) clip.channels.push_back(read_channel(asset, channel, path, warned));
    for (const Channel& channel : clip.channels) {
      clip.start = std::min(clip.start, channel.times.front());
      clip.end = std::max(clip.end, channel.times.back());
    }
    shift_to_zero(asset, clip, a);
    if (clip.channels.empty()) {
      clip.start = clip.end = 0;
      asset.warn(fmt::format("/animations/{}: moves nothing", a));
    } else if (clip.end == clip.start) {
      still.push_back(clip.name.empty() ? fmt::format("{}", a) : printable(clip.name, 40));
    }
    asset.character.clips.push_back(std::move(clip));
  }
  offer_together(asset);
  if (still.empty()) return;
  const size_t listed = std::min<size_t>(still.size(), 8);
  asset.warn(fmt::format("{} clips have zero length: {}{}", still.size(),
                         fmt::join(still.begin(), still.begin() + static_cast<std::ptrdiff_t>(listed), ", "),
                         listed < still.size() ? ", ..." : ""));
}

}  // namespace crowdbench::scene
