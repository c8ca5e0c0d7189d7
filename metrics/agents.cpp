#include "metrics/agents.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <unordered_map>

#include "core/counted.h"
#include "metrics/sizes.h"

namespace crowdbench::metrics {
namespace {

struct Agent {
  AgentRow row;
  AgentPixels pixels;
};

// By ascending id.
std::vector<Agent> agents_of(const ImageU32& reference, const ImageU32& test) {
  std::vector<Agent> all;
  std::unordered_map<uint32_t, size_t> index;
  const auto agent_of = [&](uint32_t id) -> Agent& {
    const auto [found, added] = index.try_emplace(id, all.size());
    if (added) {
      all.emplace_back();
      all.back().row.id = all.back().pixels.id = id;
    }
    return all[found->second];
  };
  for (int y = 0; y < reference.height; ++y) {
    for (int x = 0; x < reference.width; ++x) {
      const uint32_t a = *reference.at(x, y);
      const uint32_t b = *test.at(x, y);
      if (a != 0) {
        Agent& agent = agent_of(a);
        agent.pixels.pixels.emplace_back(x, y);
        ++agent.row.pixels_ref;
        agent.row.pixels_test += a == b ? 1 : 0;
        agent.row.pixels_both += a == b ? 1 : 0;
      }
      if (b != 0 && b != a) {
        Agent& agent = agent_of(b);
        agent.pixels.pixels.emplace_back(x, y);
        ++agent.row.pixels_test;
      }
    }
  }
  std::sort(all.begin(), all.end(), [](const Agent& a, const Agent& b) { return a.row.id < b.row.id; });
  return all;
}

std::optional<double> depth_of_agent(const ScoreInput& input, Shared&, const AgentPixels& agent) {
  double sum = 0;
  size_t count = 0;
  for (const auto& [x, y] : agent.pixels) {
    if (*input.reference.ids->at(x, y) != *input.test.ids->at(x, y)) continue;
    const double u = *input.reference.depth->at(x, y);
    const double v = *input.test.depth->at(x, y);
    sum += u == v ? 0 : std::abs(u - v);
    ++count;
  }
  // Depths that are not a number, or infinite on one side, are no distance.
  if (count == 0 || !std::isfinite(sum)) return std::nullopt;
  return sum / static_cast<double>(count);
}

// Why depths of pixels that show one agent in both pictures have no difference; empty where all have one.
std::string no_difference(const ScoreInput& input, const AgentPixels& agent) {
  size_t count = 0;
  std::string first;
  for (const auto& [x, y] : agent.pixels) {
    if (*input.reference.ids->at(x, y) != *input.test.ids->at(x, y)) continue;
    const double u = *input.reference.depth->at(x, y);
    const double v = *input.test.depth->at(x, y);
    if (u == v || std::isfinite(u - v)) continue;
    if (count++ == 0) first = fmt::format("the first at ({}, {}): reference {}, test {}", x, y, u, v);
  }
  return count == 0 ? ""
                    : fmt::format("depths of {} are not finite numbers where both show one agent, {}",
                                  counted(count, "pixel", "pixels"), first);
}

constexpr std::string_view kNoneInBoth = "no pixel carries the same agent in both pictures";

ScoreResult depth_error(const ScoreInput& input, Shared& shared) {
  const ImageU32& reference = *input.reference.ids;
  const ImageU32& test = *input.test.ids;
  require_same_size(reference, test);
  require_same_size(reference, *input.reference.depth);
  require_same_size(reference, *input.test.depth);
  AgentPixels all;
  for (int y = 0; y < reference.height; ++y)
    for (int x = 0; x < reference.width; ++x)
      if (*reference.at(x, y) != 0) all.pixels.emplace_back(x, y);
  ScoreResult result;
  result.value = depth_of_agent(input, shared, all);
  if (result.value) return result;
  result.reason = no_difference(input, all);
  if (result.reason.empty()) result.reason = kNoneInBoth;
  return result;
}

}  // namespace

AgentScores score_agents(ScoreTable table, const ScoreInput& input, Shared& shared) {
  const Needs needs = given(input) | kNeedsRegion;
  const ImageU32& reference = *input.reference.ids;
  require_same_size(reference, *input.test.ids);
  for (const Buffers* side : {&input.reference, &input.test}) {
    if (side->codes) require_same_size(reference, *side->codes);
    if (side->codes16) require_same_size(reference, *side->codes16);
    if (side->linear) require_same_size(reference, *side->linear);
    if (side->depth) require_same_size(reference, *side->depth);
  }
  AgentScores out;
  for (const Score* score : table)
    if (score->by_agent && (score->needs & ~needs) == 0) out.scores.push_back(score);
  for (Agent& agent : agents_of(reference, *input.test.ids)) {
    for (const Score* score : out.scores) {
      std::optional<double> value = score->by_agent(input, shared, agent.pixels);
      if (value && std::isnan(*value)) value.reset();
      agent.row.values.push_back(value);
    }
    out.agents.push_back(std::move(agent.row));
  }
  return out;
}

extern const Score score_depth_mae = {
    .name = "depth_mae",
    .title = "depth error",
    .column = "depth",
    .unit = "m",
    .direction = Direction::lower_is_better,
    .digits = 4,
    .least = 0,
    .greatest = std::numeric_limits<double>::infinity(),
    .needs = kNeedsIds | kNeedsDepth,
    .computes = "mean of abs(depth - depth) over the pixels that carry the same agent in both",
    .source = "",
    .absence = kNoneInBoth,
    .compute = depth_error,
    .by_agent = depth_of_agent,
};

}  // namespace crowdbench::metrics
