// Based on: Dobbyn, Hamill, O'Conor and O'Sullivan 2005, "Geopostors" (mesh near, impostor far, switched by the
// pixel-to-texel ratio).
// Differs from the source: its printed equations take an inverse tangent where the geometry needs a tangent, and the
// last is inverted; here r = s rows / (2 d tan(fov / 2)) with s the metres a texel covers and d the eye-space depth.
// Hysteresis and the dithered cross-fade are additions.
#include "renderers/hybrid/lod_switch.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>

namespace crowdbench::renderers {

double switch_distance(const LodPolicy& policy, const LodCharacter& character, const scene::Camera& camera, int rows) {
  assert(policy.rule != LodPolicy::Rule::nearest);
  const double metres = policy.rule == LodPolicy::Rule::height ? character.height : character.texel;
  if (policy.rule == LodPolicy::Rule::distance) return policy.value;
  return metres * rows / (2 * policy.value * std::tan(camera.fov_y / 2));
}

size_t LodSplit::count(const AgentLists& lists) const {
  size_t n = 0;
  for (const auto& list : lists) n += list.size();
  return n;
}

LodSwitch::LodSwitch(const LodPolicy& policy, std::vector<LodCharacter> characters)
    : policy_(policy), characters_(std::move(characters)) {
  split_.fading.resize(static_cast<size_t>(policy_.fade) + 1);
}

void LodSwitch::measure(const scene::Frame& frame, const AgentLists& agents) {
  const glm::vec3 forward(-glm::transpose(scene::view_rotation(frame.camera))[2]);
  relative_.resize(agents.size());
  beyond_.resize(agents.size());
  double nearest_limit = std::numeric_limits<double>::infinity();
  std::pair<float, uint32_t> last_near(std::numeric_limits<float>::infinity(), 0);
  const auto by_hysteresis = static_cast<float>(1 + policy_.hysteresis);
  const auto rank = [&](const scene::FrameAgent& a) {
    const AgentState* last = last_state(a.id);
    const float distance = glm::length(a.position);
    return std::pair(last == nullptr ? distance
                     : last->far     ? distance * by_hysteresis
                                     : distance / by_hysteresis,
                     a.id);
  };
  if (policy_.rule == LodPolicy::Rule::nearest) {
    order_.clear();
    for (size_t c = 0; c < agents.size(); ++c)
      for (const uint32_t i : agents[c]) order_.push_back(rank(frame.agents[c][i]));
    const auto count = static_cast<size_t>(policy_.value);
    if (count == 0) {
      last_near = {-1.0F, 0};
      nearest_limit = 0;
    } else if (count < order_.size()) {
      const auto middle = order_.begin() + static_cast<std::ptrdiff_t>(count - 1);
      std::nth_element(order_.begin(), middle, order_.end());
      last_near = *middle;
      nearest_limit = static_cast<double>(last_near.first);
    }
  }
  for (size_t c = 0; c < agents.size(); ++c) {
    relative_[c].resize(agents[c].size());
    beyond_[c].resize(agents[c].size());
    const bool by_count = policy_.rule == LodPolicy::Rule::nearest;
    const double limit =
        by_count ? nearest_limit : switch_distance(policy_, characters_[c], frame.camera, frame.height);
    const auto middle = static_cast<float>(characters_[c].height / 2);
    for (size_t n = 0; n < agents[c].size(); ++n) {
      const scene::FrameAgent& a = frame.agents[c][agents[c][n]];
      double distance = 0;
      if (by_count)
        distance = static_cast<double>(rank(a).first);
      else if (policy_.rule == LodPolicy::Rule::distance)
        distance = static_cast<double>(glm::length(a.position));
      else  // a larger agent's texels and height are larger: it changes over farther away
        distance =
            static_cast<double>(glm::dot(a.position + glm::vec3(0.0F, middle * a.scale, 0.0F), forward) / a.scale);
      relative_[c][n] = limit > 0 ? distance / limit : std::numeric_limits<double>::infinity();
      beyond_[c][n] = by_count ? rank(a) > last_near : distance > limit;
    }
  }
}

void LodSwitch::begin(const scene::Frame& frame) {
  const bool same = now_stamp_ != 0 && frame.tick == tick_;
  if (same) return;
  const bool follows = now_stamp_ != 0 && frame.tick > tick_ && frame.tick - tick_ <= kMostTicks;
  elapsed_ = follows ? frame.tick - tick_ : 0;
  std::swap(before_, now_);
  before_stamp_ = follows ? now_stamp_ : 0;
  now_stamp_ = ++stamps_;
  tick_ = frame.tick;
}

const LodSwitch::AgentState* LodSwitch::last_state(uint32_t id) const {
  if (before_stamp_ == 0 || id >= before_.size() || before_[id].stamp != before_stamp_) return nullptr;
  return &before_[id];
}

const LodSplit& LodSwitch::split(const scene::Frame& frame, const AgentLists& agents, const HeldShares& held) {
  const bool history = policy_.has_history();
  if (history) begin(frame);
  measure(frame, agents);
  const auto clear = [&](AgentLists& lists) {
    lists.resize(agents.size());
    for (auto& list : lists) list.clear();
  };
  clear(split_.near);
  clear(split_.far);
  clear(split_.matched);
  for (AgentLists& lists : split_.fading) clear(lists);
  const auto whole = static_cast<uint64_t>(policy_.fade) + 1;
  for (size_t c = 0; c < agents.size(); ++c)
    for (size_t n = 0; n < agents[c].size(); ++n) {
      const uint32_t i = agents[c][n];
      const uint32_t id = frame.agents[c][i].id;
      const double relative = relative_[c][n];
      AgentState state;
      state.far = beyond_[c][n];
      if (history) {
        if (id >= now_.size()) now_.resize(id + 1);
        if (const AgentState* known = last_state(id)) {
          const AgentState& last = *known;
          state.step = last.step;
          if (policy_.hysteresis > 0 && policy_.rule != LodPolicy::Rule::nearest)
            state.far = last.far ? relative >= 1 / (1 + policy_.hysteresis) : relative > 1 + policy_.hysteresis;
          uint64_t step = 0;
          if (state.far == last.far)
            step = last.step == 0 ? 0 : last.step + elapsed_;
          else if (policy_.fade > 0)  // one that turns back while it fades goes on from where it is
            step = last.step == 0 ? 1 : whole - last.step + elapsed_;
          state.step = static_cast<uint8_t>(step >= whole ? 0 : step);
        }
        state.stamp = now_stamp_;
        now_[id] = state;
      }
      uint64_t share = state.far ? whole : 0;  // of the far representation
      if (state.step != 0) share = state.far ? state.step : whole - state.step;
      if (id < held.size() && held[id] != kNotHeld) share = held[id];
      const bool fades = share != 0 && share != whole;
      (fades ? split_.fading[share] : share == 0 ? split_.near : split_.far)[c].push_back(i);
      if (policy_.match > 0 && (fades || (share == 0 && relative > 1 - policy_.match))) split_.matched[c].push_back(i);
    }
  return split_;
}

}  // namespace crowdbench::renderers
