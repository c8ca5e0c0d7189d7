// Tune: which representation to draw from which distance on, so that nobody is shown more error, nor more of a pop at a
// switch, than a threshold allows, for the least time. Measures one character; switch_plan.h chooses.
//
// Everything is against the character's height in pixels: one rule then holds at every resolution and every lens. At
// each of the heights every candidate is drawn from the same directions at the same moments of the clip (blocks) and
// scored against the reference at the exact time; what is judged is the bad end's 5 % over the blocks, at the
// unfavourable end of its bootstrap interval.
#pragma once
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <tuple>
#include <vector>

#include "bench/experiments/quality.h"
#include "bench/experiments/switch_cost.h"
#include "bench/experiments/switch_distance.h"
#include "bench/experiments/switch_plan.h"

namespace crowdbench::bench {

struct TuneThreshold {
  const metrics::Score* score = nullptr;  // of two pictures of a figure
  double value = 0;
};

struct TuneRequest {
  std::shared_ptr<const scene::Character> character;
  std::vector<renderers::Spec>
      candidates;                  // the reference among them: it is what is left where nothing else is allowed
  std::vector<double> heights_px;  // falling, at least two
  std::vector<double> agents;      // expected at each height
  std::vector<double> azimuths_deg{0, 60, 120, 180, 240, 300};
  std::vector<double> elevations_deg{0, 20};
  size_t moments = 2;  // of the clip, evenly
  int clip = -1;       // into Character::clips; -1: the bind pose
  TuneThreshold error;
  TuneThreshold pop;
  int fade = 0;  // ticks of the cross-fade whose worst step is judged as the pop; 0: a cut
  metrics::ChosenDisplay display;
  SwitchCostRequest cost;  // representations and heights_px are filled in
  size_t cost_heights = 4;
  uint64_t seed = 1;  // of the bootstrap
};
inline constexpr size_t kTuneResamples = 400;

// One candidate at one height.
struct TuneError {
  std::vector<double> values;  // of the error's score, by block; empty where it was refused or has none
  double mean = 0;
  double tail = 0;    // the bad end's 5 %
  Interval interval;  // of the tail, 95 %, by blocks drawn anew
  bool allowed = false;
};

struct TunePop {
  double tail = 0;  // the bad end's 5 % over the blocks
  bool allowed = false;
};

struct TuneSwitch {
  PlannedSwitch change;
  double height_px = 0;  // the tallest that `to` may draw: what is at least so small is far
  SwitchCertainty certainty;
  TunePop pop;
  double hysteresis = 0;  // for hybrid: half of the interval of a decided switch, as a factor above 1
};

struct TuneResult {
  std::vector<std::string> refused;              // by candidate: why it was not measured; empty where it was
  std::vector<std::vector<TuneError>> errors;    // by candidate, then by height
  std::vector<double> cost_heights_px;           // falling
  SwitchCosts costs;                             // by candidate, then by cost height
  SwitchTable table;                             // of what was measured
  std::optional<SwitchPlan> plan;                // nothing: no candidate, or no change, is allowed somewhere
  std::vector<std::optional<SwitchPlan>> again;  // by resample
  std::vector<TuneSwitch> switches;              // of the plan, from near to far
  double reference_cost = 0;                     // nanoseconds that the expected agents take as the reference
  Interval saving;  // reference over plan, 95 %, by resampled rounds; no width without rounds
};

// Throws Error and Interrupted.
TuneResult tune(gl::Context& context, const TuneRequest& request);

// The representation that draws as the plan says: switches by height, nested where there are several.
renderers::Spec tuned_representation(const TuneRequest& request, const TuneResult& result);

// Metres along the view axis at which a character of `height` metres covers height_px of `rows`.
double depth_of_height(double height, double height_px, int rows, double fov_y);

}  // namespace crowdbench::bench
