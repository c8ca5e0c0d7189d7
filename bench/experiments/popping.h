// Popping: every switch of an agent in a sequence of frames, and how visible it is.
//
// The representation says of each frame who draws which agent (Representation::shares). Where that differs from the
// frame before, the same frame is drawn again with this agent held as it was (Representation::hold): the frame without
// the switch, and otherwise the same bytes. metrics/popping.h scores the two at the agent's own pixels. Agents far
// enough from each other on the screen are held in one drawing.
//
// A switch is a cut, which takes one frame, or a cross-fade, which takes a frame a step; a fade that turns back is one
// switch. One that began before the first frame is left out, and an agent that comes into view does not switch. What a
// representation does within itself (another view, stored frame or tier) is not a switch: with and without it are drawn
// alike.
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "bench/stage/stage_scenario.h"
#include "metrics/popping.h"
#include "renderers/gl/context.h"
#include "renderers/representation.h"
#include "scene/cast/cast.h"

namespace crowdbench::bench {

struct PoppingRequest {
  renderers::Spec representation;
  uint64_t tick = 0;     // of the first frame; ticks before it are played where they matter
  uint64_t frames = 60;  // one a tick, at least two
  metrics::PopView view;
  size_t pictures = 0;  // keep those of so many switches, the most visible
  uint64_t bake_budget = uint64_t{512} << 20;
  bool use_cache = true;
};

// The box around the agent (metrics::Pop::box): RGB. Empty where they are not kept.
struct SwitchPictures {
  metrics::Box box;
  Image8 before;   // the frame before the step
  Image8 with;     // the frame of the step as it is drawn
  Image8 without;  // the same had the agent not switched
  bool kept() const { return !with.empty(); }
};

struct Switch {
  uint32_t id = 0;  // agent index + 1
  size_t character = 0;
  uint64_t tick = 0;        // the first frame that shows it
  uint64_t steps = 1;       // frames over which it goes
  bool complete = true;     // it ended within the sequence
  size_t from = 0, to = 0;  // into PoppingResult::components
  double distance = 0;      // metres from the eye to the agent's pivot, in its first frame
  uint64_t pixels = 0;      // of the most visible step; 0: no pixel of the agent is seen in any, and no values
  uint64_t worst_tick = 0;  // of the most visible step
  std::vector<std::optional<double>> values;  // by metrics::pop_scores(): the worst of all steps
  SwitchPictures pictures;                    // of the most visible step
};

struct PoppingResult {
  std::vector<std::string> components;  // Representation::components()
  std::vector<Switch> switches;         // the most visible first; unseen ones last
  uint64_t agents_in_view = 0;          // summed over frames
  uint64_t drawings = 0;                // frames drawn, those without switches included
};

// Throws Error: a representation whose agents never switch.
PoppingResult measure_popping(gl::Context& context, const scene::Cast& cast, const Staged& staged,
                              const PoppingRequest& request);

// Of the switches that are seen, one score.
struct PopQuantiles {
  double median = 0;
  double tail = 0;  // the bad end's 5 %
  double worst = 0;
};
// place: in metrics::pop_scores(). Nothing where no switch has it.
std::optional<PopQuantiles> pop_quantiles(const std::vector<Switch>& switches, size_t place);
size_t seen_switches(const std::vector<Switch>& switches);

}  // namespace crowdbench::bench
