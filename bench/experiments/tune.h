// Tune: which representation to draw from which distance on, so that nobody is shown more error, nor more of a pop at a
// switch, than a threshold allows, for the least time; or with the least error in a stated time. Measures one character
// or several; switch_plan.h chooses.
//
// Everything is against the character's height in pixels: one rule then holds at every resolution and every lens
// (tune_views.h checks it). At each of the heights every candidate is drawn from the same directions at the same
// moments of the clip (blocks) and scored against the reference at the exact time; what is judged is the bad end's 5 %
// over the blocks, at the unfavourable end of its interval. Several characters are judged each by itself and all
// together: what holds for all is allowed where it is allowed for each, and costs the mean over their agents.
#pragma once
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "bench/experiments/switch_cost.h"
#include "bench/experiments/switch_plan.h"
#include "metrics/display.h"
#include "metrics/registry.h"

namespace crowdbench::bench {

struct TuneThreshold {
  const metrics::Score* score = nullptr;  // of two pictures of a figure
  double value = 0;
};

// One character, and what is seen of it.
struct TuneSubject {
  std::shared_ptr<const scene::Character> character;
  int clip = -1;                  // into Character::clips; -1: the bind pose
  std::vector<double> agents_px;  // heights of the agents expected in view, any order
};

// The directions and moments in which a figure is judged. With both lists every one of them is taken at every moment;
// without them `views` directions are spread over the whole turn and the range of elevations.
struct TuneBlocks {
  std::vector<double> azimuths_deg, elevations_deg;  // both or neither
  double lowest_deg = 0, highest_deg = 20;           // elevations, without the lists
  size_t views = 72;                                 // at least 72 bound a tail of 5 % with 97.5 % confidence
  size_t moments = 12;                               // of the clip; of a shorter one all its samples
};

struct TuneRequest {
  std::vector<TuneSubject> subjects;        // at least one
  std::vector<renderers::Spec> candidates;  // the reference among them: what is left where nothing else is allowed
  std::vector<double> heights_px;           // falling, at least two
  TuneBlocks blocks;
  TuneThreshold error;
  TuneThreshold pop;
  // Nanoseconds that a frame may take: then the least error within it, whatever the threshold; 0: the least time.
  double budget_ns = 0;
  // With a budget: what a frame of a representation takes in the scenario itself, where agents hide each other and the
  // picture's edges cut them. Plans of all characters are sought until one keeps the budget there; without it, and of
  // one character among several, the table's costs decide.
  std::function<double(const renderers::Spec&)> frame_ns;
  int fade = 0;  // ticks of the cross-fade whose worst step is judged as the pop; 0: a cut
  metrics::ChosenDisplay display;
  SwitchCostRequest cost;  // representations and heights_px are filled in
  size_t cost_heights = 4;
  uint64_t seed = 1;  // of directions and of the bootstrap
};
inline constexpr size_t kTuneResamples = 400;

// One candidate at one height.
struct TuneError {
  std::vector<double> values;  // of the error's score, by block; empty where it was refused or has none
  double mean = 0;
  double tail = 0;      // the bad end's 5 %
  Interval interval;    // of the tail, 95 %, from the ranks of the values: no shape is assumed
  double promised = 0;  // the interval's unfavourable end: no more than 5 % of what is seen is worse
  bool allowed = false;
};

struct TunePop {
  double tail = 0;  // the bad end's 5 % over the blocks
  bool allowed = false;
  size_t subject = 0;  // of which character
  size_t block = 0;    // in which it shows most, into tune_views
  double worst = 0;    // what it shows there
};

// What was measured of one character.
struct TuneMeasured {
  size_t views = 0;                            // directions and moments, each drawn at every height
  std::vector<std::string> refused;            // by candidate: why it was not measured; empty where it was
  std::vector<std::vector<TuneError>> errors;  // by candidate, then by height
  std::vector<double> cost_heights_px;         // falling
  SwitchCosts costs;                           // by candidate, then by cost height
  double base_ns = 0;                          // what a frame takes beside its agents: median over what was timed
  SwitchTable table;
};

struct TuneSwitch {
  PlannedSwitch change;
  double height_px = 0;  // the tallest that `to` may draw: what is at least so small is far
  SwitchCertainty certainty;
  TunePop pop;            // of the character of which it shows most
  double hysteresis = 0;  // for hybrid: half of the interval of a decided switch, as a factor above 1
};

// With a budget: whether a plan fits.
struct TuneBudgetAnswer {
  double base_ns = 0;
  double cheapest_ns = 0;  // a frame of the cheapest chain, whatever it shows; infinite where pops forbid every chain
  double bound = 0;        // no plan within the budget has a smaller sum of losses
  std::optional<double> measured_ns;  // a frame of the last plan sought, where the request can tell
  double factor = 1;                  // measured over the table's, where the table's costs had to be corrected by it
};

// A plan, and how sure it is.
struct TuneAnswer {
  SwitchTable table;
  std::optional<SwitchPlan> plan;                // nothing: no candidate, no change or no time is allowed somewhere
  std::vector<std::optional<SwitchPlan>> again;  // by resample
  std::vector<TuneSwitch> switches;              // of the plan, from near to far
  double base_ns = 0;
  double reference_cost = 0;  // nanoseconds that the expected agents take as the reference
  Interval saving;            // reference over plan, 95 %, by resampled rounds; no width without rounds
  std::optional<TuneBudgetAnswer> budget;
};

struct TuneResult {
  std::vector<TuneMeasured> subjects;
  TuneAnswer together;            // one plan for all
  std::vector<TuneAnswer> alone;  // by subject; empty where there is one
  // By subject: of all the others, for what is promised of a character that was not tuned. Empty of fewer than three,
  // and within a budget.
  std::vector<TuneAnswer> left_out;
};

// Throws Error and Interrupted.
TuneResult tune(gl::Context& context, const TuneRequest& request);

// The representation that draws as the answer's plan says: switches by height, nested where there are several.
renderers::Spec tuned_representation(const TuneRequest& request, const TuneAnswer& answer);

// The bin that a figure of that height is drawn by: the smallest height that is not below it; the tallest for taller
// ones.
size_t bin_of_height(const std::vector<double>& heights_px, double height_px);

// Of a switch that lies within these heights: half of that, as a factor above 1; what draws takes no more than 1, and
// an interval so wide is of candidates that hardly differ.
double hysteresis_of(const Interval& height_px);

// How far a score's value is from its best, so that more is worse; at least 0. The best one is finite.
double loss_of(const metrics::Score& score, double value);

// Metres along the view axis at which a character of `height` metres covers height_px of `rows`.
double depth_of_height(double height, double height_px, int rows, double fov_y);

}  // namespace crowdbench::bench
