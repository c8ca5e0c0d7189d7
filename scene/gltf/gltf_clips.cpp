#include "scene/gltf/gltf_clips.h"

#include <tiny_gltf.h>

#include <algorithm>
#include <cmath>

#include "core/error.h"

namespace crowdbench::scene {
namespace {

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

// The specification wants translation, rotation and scale on an animated node; a matrix without shear is the same.
void make_animatable(GltfAsset& asset, Node& node, int file_index, const std::string& path) {
  if (!node.has_matrix) return;
  const std::string where = fmt::format("{}: animates node {}, which has a matrix", path, file_index);
  glm::dmat3 axes(node.matrix);
  glm::dvec3 scale(glm::length(axes[0]), glm::length(axes[1]), glm::length(axes[2]));
  if (glm::determinant(axes) < 0) scale.x = -scale.x;
  bool sound = true;
  for (int i = 0; i < 3; ++i) {
    if (std::abs(scale[i]) < 1e-12) sound = false;
    axes[i] /= scale[i];
  }
  for (int i = 0; sound && i < 3; ++i)
    if (std::abs(glm::dot(axes[i], axes[(i + 1) % 3])) > 1e-4) sound = false;
  if (!sound) asset.fail(path, fmt::format("animates node {}, whose matrix has shear or no volume", file_index));
  node.translation = glm::dvec3(node.matrix[3]);
  node.rotation = glm::normalize(glm::quat_cast(axes));
  node.scale = scale;
  node.has_matrix = false;
  node.matrix = glm::dmat4(1.0);
  asset.warn(where + "; it is taken apart");
}

Channel read_channel(GltfAsset& asset, const tinygltf::Animation& animation, const tinygltf::AnimationChannel& in,
                     const std::string& path, bool& warned) {
  const tinygltf::AnimationSampler& sampler = animation.samplers[index_of(in.sampler)];
  Channel out;
  out.node = asset.node_of[index_of(in.target_node)];
  out.target = in.target_path == "rotation" ? Target::rotation
               : in.target_path == "scale"  ? Target::scale
                                            : Target::translation;
  out.interpolation = sampler.interpolation == "STEP"          ? Interpolation::step
                      : sampler.interpolation == "CUBICSPLINE" ? Interpolation::cubic_spline
                                                               : Interpolation::linear;
  make_animatable(asset, asset.character.skeleton.nodes[index_of(out.node)], in.target_node, path);
  const AccessorView input = asset.view_of(sampler.input);
  out.times.reserve(input.count);
  for (size_t i = 0; i < input.count; ++i) {
    const double t = asset.finite(input, i, 0);
    if (t < 0) asset.fail(input.path, fmt::format("key {} is at {} s, before 0", i, t));
    if (t > asset.limits.clip_seconds)
      asset.fail(input.path, fmt::format("key {} is at {} s, the limit is {}", i, t, asset.limits.clip_seconds));
    if (i > 0 && t <= out.times.back())
      asset.fail(input.path, fmt::format("key {} at {} s is not after key {} at {} s", i, t, i - 1, out.times.back()));
    out.times.push_back(t);
  }
  const AccessorView output = asset.view_of(sampler.output);
  const bool cubic = out.interpolation == Interpolation::cubic_spline;
  out.values.reserve(output.count * static_cast<size_t>(output.components));
  for (size_t i = 0; i < output.count; ++i) {
    const size_t at = out.values.size();
    for (int c = 0; c < output.components; ++c) out.values.push_back(asset.finite(output, i, c));
    // The tangents of a spline are not rotations.
    if (out.target == Target::rotation && (!cubic || i % 3 == 1))
      normalise_rotation(asset, &out.values[at], output, i, warned);
  }
  return out;
}

}  // namespace

void read_clips(GltfAsset& asset) {
  if (asset.model->animations.size() * std::max<size_t>(asset.model->nodes.size(), 1) > asset.limits.clip_nodes)
    asset.fail("/animations",
               fmt::format("{} clips of {} nodes, the limit is a product of {}", asset.model->animations.size(),
                           asset.model->nodes.size(), asset.limits.clip_nodes));
  std::vector<std::string> still;
  bool warned = false;
  for (size_t a = 0; a < asset.model->animations.size(); ++a) {
    const tinygltf::Animation& in = asset.model->animations[a];
    Clip clip;
    clip.name = in.name;
    clip.start = asset.limits.magnitude;
    clip.end = 0;
    for (const tinygltf::AnimationChannel& channel : in.channels)
      clip.channels.push_back(read_channel(asset, in, channel, fmt::format("/animations/{}", a), warned));
    for (const Channel& channel : clip.channels) {
      clip.start = std::min(clip.start, channel.times.front());
      clip.end = std::max(clip.end, channel.times.back());
    }
    if (clip.channels.empty()) {
      clip.start = 0;
      asset.warn(fmt::format("/animations/{}: moves nothing", a));
    } else if (clip.end == clip.start) {
      still.push_back(clip.name.empty() ? fmt::format("{}", a) : printable(clip.name, 40));
    }
    asset.character.clips.push_back(std::move(clip));
  }
  if (still.empty()) return;
  const size_t listed = std::min<size_t>(still.size(), 8);
  asset.warn(fmt::format("{} clips have zero length: {}{}", still.size(),
                         fmt::join(still.begin(), still.begin() + static_cast<std::ptrdiff_t>(listed), ", "),
                         listed < still.size() ? ", ..." : ""));
}

}  // namespace crowdbench::scene
