// Based on: Khronos Group, "glTF 2.0 Specification" (skinned mesh attributes 3.7.3.3). Differs from the source: more
// than four influences are reduced to the four largest; weights are renormalised.
#include "scene/gltf/gltf_weights.h"

#include <algorithm>
#include <cmath>

#include "core/error.h"

namespace crowdbench::scene {

double GltfWeights::gather(const AccessorView& joints, const AccessorView& weights, size_t v, int c, int palette_size,
                           std::vector<Influence>& all) const {
  const double weight = weights.at(v, c);
  const uint32_t joint = joints.unsigned_at(v, c);
  if (!std::isfinite(weight) || weight > asset_.limits.magnitude)
    asset_.fail(weights.path, fmt::format("the weight of vertex {} is {}", v, weight));
  if (weight < -1e-4) asset_.fail(weights.path, fmt::format("the weight of vertex {} is {}, negative", v, weight));
  if (weight <= 0.0) return 0.0;
  if (joint >= static_cast<uint32_t>(palette_size))
    asset_.fail(joints.path, fmt::format("vertex {} names joint {}, its skin has {}", v, joint, palette_size));
  const auto same =
      std::find_if(all.begin(), all.end(), [&](const Influence& i) { return i.joint == static_cast<int>(joint); });
  if (same != all.end())
    same->weight += weight;
  else
    all.push_back({static_cast<int>(joint), weight});
  return weight;
}

void GltfWeights::read(const GltfPrimitive& in, const std::vector<uint32_t>& vertices, int first_joint,
                       int palette_size) {
  std::vector<AccessorView> joints;
  std::vector<AccessorView> weights;
  for (int set = 0; set < asset_.limits.influence_sets; ++set) {
    const auto j = in.attributes.find(fmt::format("JOINTS_{}", set));
    const auto w = in.attributes.find(fmt::format("WEIGHTS_{}", set));
    if (j == in.attributes.end() || w == in.attributes.end()) break;
    joints.push_back(asset_.view_of(j->second));
    weights.push_back(asset_.view_of(w->second));
    // Integers are fractions of their type's range, whether the file says so or not.
    if (weights.back().type != kF32) weights.back().normalized = true;
  }
  std::vector<Influence> all;
  for (const uint32_t v : vertices) {
    all.clear();
    double sum = 0;
    for (size_t set = 0; set < joints.size(); ++set)
      for (int c = 0; c < 4; ++c) sum += gather(joints[set], weights[set], v, c, palette_size, all);
    if (sum < 1e-9) {
      ++without_;
      const uint32_t first = joints[0].unsigned_at(v, 0);
      all.assign(1, {static_cast<int>(first) < palette_size ? static_cast<int>(first) : 0, 1.0});
      sum = 1.0;
    } else if (std::abs(sum - 1.0) > 0.05) {
      ++scaled_;
    }
    asset_.character.file_max_influences = std::max(asset_.character.file_max_influences, static_cast<int>(all.size()));
    // The order among equals is the file's, so that the choice is the same everywhere.
    std::stable_sort(all.begin(), all.end(), [](const auto& a, const auto& b) { return a.weight > b.weight; });
    double kept = 0;
    const size_t n = std::min<size_t>(all.size(), kInfluences);
    for (size_t i = 0; i < n; ++i) kept += all[i].weight;
    if (all.size() > n) {
      ++reduced_;
      worst_lost_ = std::max(worst_lost_, 1.0 - kept / sum);
      lost_ += 1.0 - kept / sum;
    }
    glm::u16vec4 out_joints(0);
    glm::vec4 out_weights(0.0F);
    for (size_t i = 0; i < n; ++i) {
      out_joints[static_cast<int>(i)] = static_cast<uint16_t>(first_joint + all[i].joint);
      out_weights[static_cast<int>(i)] = static_cast<float>(all[i].weight / kept);
    }
    asset_.character.mesh.joints.push_back(out_joints);
    asset_.character.mesh.weights.push_back(out_weights);
  }
}

void GltfWeights::report() {
  if (without_ > 0) asset_.warn(fmt::format("{} vertices without any weight follow their first joint", without_));
  if (scaled_ > 0) asset_.warn(fmt::format("{} vertices with weights that do not sum to 1 were rescaled", scaled_));
  if (reduced_ > 0)
    asset_.warn(
        fmt::format("{} vertices have up to {} influences; the {} largest are kept, which loses {:.2f} % of their "
                    "weight on average, {:.2f} % at most",
                    reduced_, asset_.character.file_max_influences, kInfluences,
                    100.0 * lost_ / static_cast<double>(reduced_), 100.0 * worst_lost_));
}

}  // namespace crowdbench::scene
