// Based on: Dobbyn, Hamill, O'Conor and O'Sullivan 2005, "Geopostors" (mesh near, impostor far, switched by the
// pixel-to-texel ratio).
// Differs from the source: its printed equations take an inverse tangent where the geometry needs a tangent, and the
// last is inverted; here r = s rows / (2 d tan(fov / 2)) with s the metres a texel covers and d the eye-space depth.
#include "renderers/hybrid/hybrid.h"

#include <algorithm>
#include <cmath>

#include "core/error.h"

namespace crowdbench::renderers {

double switch_distance(const LodPolicy& policy, const LodCharacter& character, const scene::Camera& camera, int rows) {
  const double metres = policy.rule == LodPolicy::Rule::height ? character.height : character.texel;
  if (policy.rule == LodPolicy::Rule::distance) return policy.value;
  return metres * rows / (2 * policy.value * std::tan(camera.fov_y / 2));
}

void split_agents(const LodPolicy& policy, const std::vector<LodCharacter>& characters, const scene::Frame& frame,
                  const AgentLists& agents, AgentLists& near, AgentLists& far) {
  near.resize(agents.size());
  far.resize(agents.size());
  const glm::vec3 forward(-glm::transpose(scene::view_rotation(frame.camera))[2]);
  for (size_t c = 0; c < agents.size(); ++c) {
    near[c].clear();
    far[c].clear();
    const double limit = switch_distance(policy, characters[c], frame.camera, frame.height);
    const auto middle = static_cast<float>(characters[c].height / 2);
    for (const uint32_t i : agents[c]) {
      const scene::FrameAgent& a = frame.agents[c][i];
      double distance = 0;
      if (policy.rule == LodPolicy::Rule::distance)
        distance = glm::length(a.position);
      else  // a larger agent's texels and height are larger: it changes over farther away
        distance = glm::dot(a.position + glm::vec3(0.0F, middle * a.scale, 0.0F), forward) / a.scale;
      (distance > limit ? far : near)[c].push_back(i);
    }
  }
}

HybridRepresentation::HybridRepresentation(std::unique_ptr<Representation> near, std::unique_ptr<Representation> far,
                                           LodPolicy policy, std::vector<LodCharacter> characters)
    : near_(std::move(near)), far_(std::move(far)), policy_(policy), characters_(std::move(characters)) {}

void HybridRepresentation::draw(const scene::Frame& frame, const FrameResources& resources, const AgentLists& agents,
                                const Pass& pass) {
  split_agents(policy_, characters_, frame, agents, near_list_, far_list_);
  const auto count = [](const AgentLists& lists) {
    size_t n = 0;
    for (const auto& list : lists) n += list.size();
    return n;
  };
  near_agents_ = count(near_list_);
  far_agents_ = count(far_list_);
  // Near ones first: they hide far ones.
  near_->draw(frame, resources, near_list_, pass);
  far_->draw(frame, resources, far_list_, pass);
}

Footprint HybridRepresentation::footprint() const {
  const Footprint a = near_->footprint();
  const Footprint b = far_->footprint();
  return {a.texture_bytes + b.texture_bytes, a.buffer_bytes + b.buffer_bytes,
          a.upload_bytes_per_frame + b.upload_bytes_per_frame, a.disk_bytes + b.disk_bytes};
}

BakeInfo HybridRepresentation::bake_info() const {
  const BakeInfo a = near_->bake_info();
  const BakeInfo b = far_->bake_info();
  BakeInfo info;
  info.seconds = a.seconds + b.seconds;
  const bool baked_a = !a.cache_key.empty();
  const bool baked_b = !b.cache_key.empty();
  info.cached = (baked_a || baked_b) && (!baked_a || a.cached) && (!baked_b || b.cached);
  info.cache_key = baked_a && baked_b ? a.cache_key + "+" + b.cache_key : a.cache_key + b.cache_key;
  for (const auto& [name, value] : a.facts) info.facts.emplace_back("near_" + name, value);
  for (const auto& [name, value] : b.facts) info.facts.emplace_back("far_" + name, value);
  return info;
}

uint64_t HybridRepresentation::triangles(size_t character) const { return near_->triangles(character); }
double HybridRepresentation::texel_metres(size_t character) const { return far_->texel_metres(character); }

const RepresentationType hybrid_type = {
    "hybrid",
    "two representations: hybrid(NEAR,FAR,distance=METRES), the nearer agents by the first, the rest by the second",
    {{"distance", "0..100000", "20", "metres from the eye to the agent's pivot at which the far one takes over"},
     {"ratio", "0..100", "0", "instead: below this many pixels a texel of the far one (needs one with texels)"},
     {"height", "0..16384", "0", "instead: below this many pixels of projected height"}},
    [](const MakeContext& context, const Spec& spec) -> std::unique_ptr<Representation> {
      const OptionReader reader(hybrid_type, spec);
      LodPolicy policy;
      policy.value = reader.number("distance", 0, 100000);
      const double ratio = reader.number("ratio", 0, 100);
      const double height = reader.number("height", 0, 16384);
      const auto given = [&](const char* key) {
        return std::any_of(spec.options.begin(), spec.options.end(), [&](const auto& o) { return o.first == key; });
      };
      if (given("distance") + given("ratio") + given("height") > 1)
        throw Error("representation 'hybrid'", "more than one of distance, ratio and height is given",
                    "give the one rule that decides");
      if (given("ratio")) policy = {LodPolicy::Rule::ratio, ratio};
      if (given("height")) policy = {LodPolicy::Rule::height, height};
      if (policy.rule != LodPolicy::Rule::distance && !(policy.value > 0))
        throw Error("representation 'hybrid'", "a rule of 0 pixels would never change over", "give more than 0");

      Spec near = spec.parts[0];
      Spec far = spec.parts[1];
      if (reader.flag("floor"))
        for (Spec* part : {&near, &far})
          if (std::none_of(part->options.begin(), part->options.end(),
                           [](const auto& o) { return o.first == "floor"; }))
            part->options.emplace_back("floor", "1");
      auto near_part = make_representation(context, near);
      auto far_part = make_representation(context, far);
      std::vector<LodCharacter> characters;
      for (size_t c = 0; c < context.cast.characters.size(); ++c) {
        const double texel = far_part->texel_metres(c);
        if (policy.rule == LodPolicy::Rule::ratio && !(texel > 0))
          throw Error("representation 'hybrid'", fmt::format("'{}' has no texels to go by", far.name),
                      "switch by distance or height");
        const scene::PoseBank& bank = *context.cast.banks[c];
        const double own = context.cast.characters[c]->placement.height;
        characters.push_back({own > 0 ? own : bank.bounds_max().y - bank.bounds_min().y, texel});
      }
      return std::make_unique<HybridRepresentation>(std::move(near_part), std::move(far_part), policy,
                                                    std::move(characters));
    },
    2};

}  // namespace crowdbench::renderers
