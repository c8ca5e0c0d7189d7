#include "renderers/hybrid/hybrid.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>
#include <unordered_map>

#include "core/error.h"
#include "renderers/frame/frame_resources.h"

namespace crowdbench::renderers {

HybridRepresentation::HybridRepresentation(std::unique_ptr<Representation> near, std::unique_ptr<Representation> far,
                                           std::array<std::string, 2> names, const LodPolicy& policy,
                                           std::vector<LodCharacter> characters,
                                           std::vector<std::shared_ptr<const scene::PoseBank>> banks)
    : near_(std::move(near)),
      far_(std::move(far)),
      names_(std::move(names)),
      switch_(policy, std::move(characters)),
      banks_(std::move(banks)) {}

const scene::Frame& HybridRepresentation::pose_matched(const scene::Frame& frame, const LodSplit& split) {
  bool copied = false;
  for (size_t c = 0; c < split.matched.size(); ++c)
    for (const uint32_t i : split.matched[c]) {
      const scene::FrameAgent& agent = frame.agents[c][i];
      const double phase = far_->shown_phase(c, agent.bank_clip, static_cast<double>(agent.phase));
      if (static_cast<float>(phase) == agent.phase) continue;
      if (!copied) matched_ = frame;
      copied = true;
      matched_.agents[c][i].phase = static_cast<float>(phase);
      matched_.agents[c][i].pose = banks_[c]->sample(agent.bank_clip, phase);
    }
  return copied ? matched_ : frame;
}

void HybridRepresentation::draw(const scene::Frame& frame, const FrameResources& resources, const AgentLists& agents,
                                const Pass& pass) {
  std::optional<LodSwitch> aside;  // what is held leaves no trace in the sequence
  if (!held_.empty()) aside.emplace(switch_);
  const LodSplit& split = (aside ? *aside : switch_).split(frame, agents, held_);
  near_agents_ = split.count(split.near);
  far_agents_ = split.count(split.far);
  fading_agents_ = 0;
  const scene::Frame& shown = pose_matched(frame, split);
  if (&shown != &frame) resources.update_agents(shown);
  // Near ones first: they hide far ones.
  near_->draw(shown, resources, split.near, pass);
  // Within the range that is to be drawn at all, so that hybrids of hybrids share pixels too.
  const FrameResources::DitherRange whole = resources.dither();
  Pass dithered = pass;
  dithered.dithered = true;
  for (size_t m = 1; m < split.fading.size(); ++m) {
    const size_t count = split.count(split.fading[m]);
    if (count == 0) continue;
    fading_agents_ += count;
    const float share = static_cast<float>(m) / static_cast<float>(split.fading.size());
    const float border = whole.low + (whole.high - whole.low) * share;
    resources.set_dither({border, whole.high});
    near_->draw(shown, resources, split.fading[m], dithered);
    resources.set_dither({whole.low, border});
    far_->draw(shown, resources, split.fading[m], dithered);
  }
  if (fading_agents_ != 0) resources.set_dither(whole);
  far_->draw(shown, resources, split.far, pass);
}

bool HybridRepresentation::has_history() const {
  return switch_.policy().has_history() || near_->has_history() || far_->has_history();
}

void HybridRepresentation::advance(const scene::Frame& frame, const AgentLists& agents) {
  const LodSplit& split = switch_.split(frame, agents);
  for (const auto& [component, lists] : {std::pair(near_.get(), &split.near), std::pair(far_.get(), &split.far)}) {
    if (!component->has_history()) continue;
    component->advance(frame, *lists);
    for (size_t m = 1; m < split.fading.size(); ++m)
      if (split.count(split.fading[m]) != 0) component->advance(frame, split.fading[m]);
  }
}

std::vector<std::string> HybridRepresentation::components() const {
  std::vector<std::string> all;
  for (const auto& [component, name] : {std::pair(near_.get(), &names_[0]), std::pair(far_.get(), &names_[1])}) {
    const std::vector<std::string> inner = component->components();
    all.insert(all.end(), inner.begin(), inner.end());
    if (inner.empty()) all.push_back(*name);
  }
  return all;
}

std::vector<AgentShares> HybridRepresentation::shares(const scene::Frame& frame, const AgentLists& agents) {
  const LodSplit& split = switch_.split(frame, agents);
  const size_t near_count = std::max<size_t>(1, near_->components().size());
  const size_t count = near_count + std::max<size_t>(1, far_->components().size());
  std::unordered_map<uint32_t, std::vector<float>> by_id;
  const auto add = [&](Representation& component, size_t first, const AgentLists& lists, float share) {
    const std::vector<AgentShares> inner = component.shares(frame, lists);
    size_t at = 0;
    for (size_t c = 0; c < lists.size(); ++c)
      for (const uint32_t i : lists[c]) {
        std::vector<float>& sum = by_id[frame.agents[c][i].id];
        sum.resize(count);
        if (inner.empty()) sum[first] += share;
        for (size_t k = 0; !inner.empty() && k < inner[at].shares.size(); ++k)
          sum[first + k] += share * inner[at].shares[k];
        ++at;
      }
  };
  // In the order of draw, and with its lists: the components' histories depend on them.
  add(*near_, 0, split.near, 1);
  for (size_t m = 1; m < split.fading.size(); ++m) {
    if (split.count(split.fading[m]) == 0) continue;
    const float far_share = static_cast<float>(m) / static_cast<float>(split.fading.size());
    add(*near_, 0, split.fading[m], 1 - far_share);
    add(*far_, near_count, split.fading[m], far_share);
  }
  add(*far_, near_count, split.far, 1);
  std::vector<AgentShares> out;
  for (size_t c = 0; c < agents.size(); ++c)
    for (const uint32_t i : agents[c]) {
      const uint32_t id = frame.agents[c][i].id;
      out.push_back({id, by_id[id]});
    }
  return out;
}

void HybridRepresentation::hold(const std::vector<AgentShares>& held) {
  held_.clear();
  const size_t near_count = std::max<size_t>(1, near_->components().size());
  std::array<std::vector<AgentShares>, 2> inner;
  for (const AgentShares& agent : held) {
    const auto border = agent.shares.begin() + static_cast<std::ptrdiff_t>(near_count);
    const std::array<std::vector<float>, 2> sides = {std::vector<float>(agent.shares.begin(), border),
                                                     std::vector<float>(border, agent.shares.end())};
    const std::array<float, 2> sums = {std::accumulate(sides[0].begin(), sides[0].end(), 0.0F),
                                       std::accumulate(sides[1].begin(), sides[1].end(), 0.0F)};
    if (agent.id >= held_.size()) held_.resize(agent.id + 1, kNotHeld);
    held_[agent.id] = static_cast<uint8_t>(
        std::lround(sums[1] / (sums[0] + sums[1]) * static_cast<float>(switch_.policy().fade + 1)));
    for (size_t side = 0; side < 2; ++side)
      if (sums.at(side) > 0) inner.at(side).push_back({agent.id, sides.at(side)});
  }
  near_->hold(inner[0]);
  far_->hold(inner[1]);
}

double HybridRepresentation::shown_phase(size_t character, int bank_clip, double phase) const {
  return near_->shown_phase(character, bank_clip, phase);
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
  info.made_seconds = cold_seconds(a) + cold_seconds(b);
  const bool baked_a = !a.cache_key.empty();
  const bool baked_b = !b.cache_key.empty();
  info.cached = (baked_a || baked_b) && (!baked_a || a.cached) && (!baked_b || b.cached);
  info.cache_key = baked_a && baked_b ? a.cache_key + "+" + b.cache_key : a.cache_key + b.cache_key;
  for (const auto& [name, value] : a.facts) info.facts.emplace_back("near_" + name, value);
  for (const auto& [name, value] : b.facts) info.facts.emplace_back("far_" + name, value);
  for (const BakeInfo* component : {&a, &b}) {
    info.kept.insert(info.kept.end(), component->kept.begin(), component->kept.end());
    info.notes.insert(info.notes.end(), component->notes.begin(), component->notes.end());
    info.levels.insert(info.levels.end(), component->levels.begin(), component->levels.end());
  }
  return info;
}

uint64_t HybridRepresentation::triangles(size_t character) const { return near_->triangles(character); }
double HybridRepresentation::texel_metres(size_t character) const { return far_->texel_metres(character); }

const RepresentationType hybrid_type = {
    .name = "hybrid",
    .summary =
        "two representations: hybrid(NEAR,FAR,distance=METRES), the nearer agents by the first, the rest by the second",
    .options =
        {{"distance", "0..100000", "20", "metres from the eye to the agent's pivot at which the far one takes over"},
         {"ratio", "0..100", "0", "instead: below this many pixels a texel of the far one (needs one with texels)"},
         {"height", "0..16384", "0", "instead: below this many pixels of projected height"},
         {"nearest", "0..1000000", "0", "instead: all but this many agents nearest to the eye"},
         {"hysteresis", "0..1", "0",
          "far beyond 1 + this times the switch distance, near again within its inverse; nearest: by comparison"},
         {"fade", "0..60", "0", "ticks over which both share an agent's pixels after a switch, by ordered dither"},
         {"match", "0..1", "0.1",
          "within this share of the switch distance near agents show the far one's stored frame"}},
    .make = [](const MakeContext& context, const Spec& spec) -> std::unique_ptr<Representation> {
      const OptionReader reader(hybrid_type, spec);
      const auto given = [&](const char* key) {
        return std::any_of(spec.options.begin(), spec.options.end(), [&](const auto& o) { return o.first == key; });
      };
      using Rule = LodPolicy::Rule;
      LodPolicy policy;
      policy.value = reader.number("distance", 0, 100000);
      const double ratio = reader.number("ratio", 0, 100);
      const double height = reader.number("height", 0, 16384);
      const auto nearest = static_cast<double>(reader.integer("nearest", 0, 1000000));
      if (given("distance") + given("ratio") + given("height") + given("nearest") > 1)
        throw Error("representation 'hybrid'", "more than one of distance, ratio, height and nearest is given",
                    "give the one rule that decides");
      if (given("ratio")) policy = {Rule::ratio, ratio};
      if (given("height")) policy = {Rule::height, height};
      if (given("nearest")) policy = {Rule::nearest, nearest};
      if ((policy.rule == Rule::ratio || policy.rule == Rule::height) && !(policy.value > 0))
        throw Error("representation 'hybrid'", "a rule of 0 pixels would never change over", "give more than 0");
      policy.hysteresis = reader.number("hysteresis", 0, 1);
      policy.fade = static_cast<int>(reader.integer("fade", 0, 60));
      policy.match = reader.number("match", 0, 1);

      Spec near = spec.components[0];
      Spec far = spec.components[1];
      if (reader.flag("floor"))
        for (Spec* component : {&near, &far})
          if (std::none_of(component->options.begin(), component->options.end(),
                           [](const auto& o) { return o.first == "floor"; }))
            component->options.emplace_back("floor", "1");
      auto near_component = make_representation(context, near);
      auto far_component = make_representation(context, far);
      std::vector<LodCharacter> characters;
      for (size_t c = 0; c < context.cast.characters.size(); ++c) {
        const double texel = far_component->texel_metres(c);
        if (policy.rule == Rule::ratio && !(texel > 0))
          throw Error("representation 'hybrid'", fmt::format("'{}' has no texels to go by", far.name),
                      "switch by distance or height");
        const scene::PoseBank& bank = *context.cast.banks[c];
        const double own = context.cast.characters[c]->placement.height;
        characters.push_back({own > 0 ? own : static_cast<double>(bank.bounds_max().y - bank.bounds_min().y), texel});
      }
      return std::make_unique<HybridRepresentation>(std::move(near_component), std::move(far_component),
                                                    std::array{spec.components[0].text(), spec.components[1].text()},
                                                    policy, std::move(characters), context.cast.banks);
    },
    .components = 2,
    .floor = "the floors of both",
    .suits = {.new_clips = "where both components do",
              .close_by = "as the near component",
              .from_above = "where both components do",
              .shadows = "as the component that is drawn"},
    .example_options = "distance=9",
};

}  // namespace crowdbench::renderers
