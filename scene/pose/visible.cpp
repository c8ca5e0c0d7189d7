#include "scene/pose/visible.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "scene/character/alpha_coverage.h"
#include "scene/character/drawn.h"
#include "scene/pose/hidden.h"
#include "scene/pose/pose.h"
#include "scene/pose/stand.h"

namespace crowdbench::scene {
namespace {

constexpr size_t kMostTimes = 240;           // of a clip: baked ones have a key a frame
constexpr size_t kMostMatrices = 3'000'000;  // of all clips' poses together: 384 MB

// Nothing of a masked surface passes its test, whatever its vertex colours: they only take away.
bool transparent(const Character& character, const Material& material) {
  const float threshold = alpha_threshold(material);
  if (threshold <= 0) return false;
  if (threshold > 1) return true;
  if (material.base_colour_image < 0) return false;
  const Image8& image = character.images[static_cast<size_t>(material.base_colour_image)].image;
  return image.channels == 4 && alpha_coverage(image.data, threshold) == 0;
}

// Nothing of the triangle passes its material's test: its vertices' alpha and every texel of the box around its texture
// coordinates, and a texel beyond, taken together. The box is more than the triangle: what is cut to shape within one
// counts as there.
bool cut_away(const Character& character, const Material& material, const uint32_t* corners) {
  const Mesh& mesh = character.mesh;
  float threshold = alpha_threshold(material);
  if (threshold <= 0) return false;
  if (!mesh.colours.empty()) {
    float most = 0;
    for (int i = 0; i < 3; ++i) most = std::max(most, mesh.colours[corners[i]].a);
    if (most < threshold) return true;  // a texture only takes away
    threshold /= most;
  }
  if (material.base_colour_image < 0) return false;
  const Image8& image = character.images[static_cast<size_t>(material.base_colour_image)].image;
  if (image.channels != 4) return false;
  glm::vec2 low = mesh.uvs[corners[0]];
  glm::vec2 high = low;
  for (int i = 1; i < 3; ++i) {
    low = glm::min(low, mesh.uvs[corners[i]]);
    high = glm::max(high, mesh.uvs[corners[i]]);
  }
  // Beyond the picture it depends on how it is wrapped.
  if (!(low.x >= 0 && low.y >= 0 && high.x <= 1 && high.y <= 1)) return false;
  const glm::ivec2 size(image.width, image.height);
  const glm::ivec2 from = glm::max(glm::ivec2(low * glm::vec2(size)) - 1, glm::ivec2(0));
  const glm::ivec2 to = glm::min(glm::ivec2(high * glm::vec2(size)) + 1, size - 1);
  for (int y = from.y; y <= to.y; ++y)
    for (int x = from.x; x <= to.x; ++x)
      if (static_cast<float>(image.at(x, y)[3]) / 255.0F >= threshold) return false;
  return true;
}

double size_of(const std::vector<glm::dvec3>& points) {
  glm::dvec3 low = points.front();
  glm::dvec3 high = points.front();
  for (const glm::dvec3& p : points) {
    low = glm::min(low, p);
    high = glm::max(high, p);
  }
  return glm::length(high - low);
}

// Does the channel scale its node from or to nothing? Of cubic keys the values alone are asked, not the tangents.
bool shows_or_hides(const Character& character, const Channel& channel) {
  if (channel.target != Target::scale) return false;
  const glm::dvec3 rest = glm::abs(character.skeleton.nodes[static_cast<size_t>(channel.node)].scale);
  double least = std::min({rest.x, rest.y, rest.z});
  double most = std::max({rest.x, rest.y, rest.z});
  const bool cubic = channel.interpolation == Interpolation::cubic_spline;
  for (size_t i = 0; i < channel.values.size(); ++i) {
    if (cubic && i / 3 % 3 != 1) continue;
    least = std::min(least, std::abs(channel.values[i]));
    most = std::max(most, std::abs(channel.values[i]));
  }
  return least < 0.01 * most;
}

// Of a clip: keys by which it shows and hides, evenly thinned, its ends and its middle; `most` in all, 3 or more.
std::vector<double> telling_times(const Character& character, const Clip& clip, size_t most) {
  std::vector<double> keys;
  for (const Channel& channel : clip.channels)
    if (shows_or_hides(character, channel)) keys.insert(keys.end(), channel.times.begin(), channel.times.end());
  std::ranges::sort(keys);
  keys.erase(std::unique(keys.begin(), keys.end()), keys.end());
  std::vector<double> times;
  const size_t step = most > 3 ? keys.size() / (most - 3) + 1 : keys.size() + 1;
  for (size_t i = step / 2; i < keys.size(); i += step) times.push_back(keys[i]);
  for (const double share : {0.0, 0.5, 1.0}) times.push_back(clip.start + share * clip.duration());
  return times;
}

}  // namespace

Invisible drop_invisible(Character& character) {
  const Mesh& mesh = character.mesh;
  std::vector<bool> clear;
  for (const Material& m : character.materials) clear.push_back(transparent(character, m));
  const auto bind = skin_positions(mesh, joint_matrices(character, -1, 0.0));
  const double bind_size = size_of(bind);
  // Few triangles ask for more than the bind pose; the clips' poses are worked out for the first of them.
  std::vector<std::vector<glm::dmat4>> poses;
  const auto pose_clips = [&] {
    const size_t a_pose = std::max<size_t>(character.clips.size() * character.skeleton.joints.size(), 1);
    const size_t most = std::clamp<size_t>(kMostMatrices / a_pose, 3, kMostTimes);
    for (size_t clip = 0; clip < character.clips.size(); ++clip)
      for (const double time : telling_times(character, character.clips[clip], most))
        poses.push_back(joint_matrices(character, static_cast<int>(clip), time));
  };
  const auto has_area_in_a_clip = [&](const uint32_t* t) {
    if (poses.empty()) pose_clips();
    return std::ranges::any_of(poses, [&](const auto& palette) {
      return has_area(skin_one(mesh, t[0], palette), skin_one(mesh, t[1], palette), skin_one(mesh, t[2], palette),
                      bind_size);
    });
  };
  const auto seen = [&](const uint32_t* t, const Primitive& primitive) {
    const auto material = static_cast<size_t>(primitive.material);
    if (clear[material] || cut_away(character, character.materials[material], t)) return false;
    if (has_area(bind[t[0]], bind[t[1]], bind[t[2]], bind_size)) return true;
    return t[0] != t[1] && t[1] != t[2] && t[2] != t[0] && has_area_in_a_clip(t);
  };
  bool any = false;
  const size_t removed = keep_drawn(character.mesh, [&](const uint32_t* t, const Primitive& primitive) {
    const bool is_seen = seen(t, primitive);
    any = any || is_seen;
    return is_seen;
  });
  return {removed, !any};
}

}  // namespace crowdbench::scene
