// What one more agent of a stated height on the screen costs, by representation: the near half of a tuning.
//
// A frame holds agents of one character, all at the depth at which the character covers the height, spread over the
// picture, in every heading and phase. Each representation draws it with all of them and with a quarter of them, taking
// turns in random order; the difference, divided by the agents that it is of, is what one adds, without what a frame
// costs anyhow.
#pragma once
#include <cstdint>
#include <memory>
#include <vector>

#include "bench/timing/timing.h"
#include "renderers/gl/context.h"
#include "renderers/representation.h"
#include "scene/cast/cast.h"

namespace crowdbench::bench {

struct SwitchCostRequest {
  std::vector<renderers::Spec> representations;
  std::vector<double> heights_px;
  int width = 640, height = 480;
  double fov_y = 0.5;  // radians, vertical
  scene::Antialiasing antialiasing;
  int rounds = 20;  // at least two
  uint64_t order_seed = kOrderSeed;
  uint64_t bake_budget = uint64_t{512} << 20;
  bool use_cache = true;
};

struct AgentCost {
  // Nanoseconds that one more agent takes, by the headline clock: median over rounds with its 95 % interval. Where the
  // median is not above 0 the difference is within the noise: then the whole frame's time over its agents, which is
  // more.
  double ns = 0;
  Interval interval;
  bool resolved = true;
  std::vector<double> differences;  // by round
};

struct SwitchCosts {
  const char* clock = "";                     // "cpu", "gpu" or "wall"
  std::vector<size_t> agents;                 // in the full frame, by height
  std::vector<std::vector<AgentCost>> costs;  // by representation, then by height
  std::vector<std::vector<double>> frame_ns;  // the same: medians of the full frame, for what a frame costs anyhow
};

// cast: of one character. Throws Error (a bake over its budget) and Interrupted.
SwitchCosts measure_switch_costs(gl::Context& context, const scene::Cast& cast, const SwitchCostRequest& request);

// The cost at each height of `wanted` from those measured: straight in (log height, log cost), beyond the ends as at
// the ends. Heights fall.
std::vector<double> costs_at(const std::vector<double>& heights_px, const std::vector<AgentCost>& costs,
                             const std::vector<double>& wanted);

}  // namespace crowdbench::bench
