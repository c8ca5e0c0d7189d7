// All that a tuning found, and what follows from it: what `tune` prints, shows on its page and stores is of this.
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "bench/experiments/engine_settings.h"
#include "bench/experiments/switch_distance.h"
#include "bench/experiments/tune.h"
#include "bench/experiments/tune_others.h"
#include "bench/experiments/tune_pictures.h"
#include "bench/experiments/tune_predict.h"
#include "bench/experiments/tune_proof.h"
#include "bench/experiments/tune_views.h"
#include "core/error.h"
#include "store/rows.h"

namespace crowdbench::bench {

// Of the tuned characters, or of one that was not tuned.
struct TuneProof {
  SpeedProof speed;
  ScoreProof score;
  std::vector<ErrorProof> errors;
  std::optional<OtherProof> other;  // then the others are empty
  bool holds() const;
};

struct TuneReport {
  TuneRequest request;
  TuneResult result;
  RunRow run;                      // the program, the driver, the machine
  uint32_t crowd = 0;              // agents of the scenario, in view or not
  std::vector<glm::dvec3> bounds;  // by subject, metres: the box around the clip's poses, which engines measure by
  std::vector<std::vector<TunePrediction>> predicted;  // by subject, then by candidate; empty where there is no plan
  std::vector<TuneSwitchPictures> pictures;            // by switch of the plan for all; empty where nobody asked
  std::optional<SpeedPromise> promise;
  std::optional<ScorePromise> score_promise;  // where there is one of speed
  std::optional<OthersPromise> others;        // of characters that were not tuned; else why_no_others
  std::optional<std::vector<TuneLensCheck>> lenses;
  std::optional<TuneProof> proof;
  std::optional<Error> failed;  // of what comes after the tuning: predictions, promise, lenses or proof
};

// Why `others` is absent.
std::string why_no_others(const TuneReport& report);
std::string candidate_name(const TuneReport& report, size_t candidate);
double depth_in_report(const TuneReport& report, size_t subject, double height_px);
EngineSizes engines_in_report(const TuneReport& report, size_t subject, double height_px);
double agents_in_view(const TuneAnswer& answer);
// Why an answer has no plan.
std::string no_plan_text(const TuneReport& report, const TuneAnswer& answer);
// Whose times these are: "cpu time of llvmpipe (a software rasteriser: nothing here says what a graphics card takes),
// on AMD EPYC".
std::string times_text(const TuneReport& report);

// ---- a switch in the settings of engines that choose levels of a mesh by themselves
// The switches of an answer, from the nearest, that go from one mesh of the character to a coarser one.
size_t mesh_switches(const TuneReport& report, const TuneAnswer& answer);
std::optional<MeshLodCurve> mesh_lod_in_report(const TuneReport& report, size_t subject, const TuneAnswer& answer);
// Nothing where the switch is to no coarser mesh.
std::optional<double> godot_pixels_in_report(const TuneReport& report, size_t subject, const TuneSwitch& one);

// ---- what a rule of thumb would do
struct PredictedSwitch {
  const char* rule = "";   // "one texel a pixel", "an error of one pixel"
  const char* unit = "";   // what `pixels` are of: "a texel", "of error"
  double pixels = 0;       // that a texel, or the error, spans at the measured switch
  double height_px = 0;    // at which it spans one
  double depth_m = 0;      // the same place
  const TuneError* error;  // of the bin that draws figures of that height; what would be shown there
  double cost_ns = 0;      // of an agent there
  bool beyond = false;     // that height is taller or smaller than all measured ones
};
// Of the switch's farther candidate, for one subject.
std::vector<PredictedSwitch> predicted_switches(const TuneReport& report, size_t subject, size_t candidate,
                                                double switch_px);

// A candidate that the answer changes to nowhere, by itself: what rules of thumb say of it beside what was measured.
struct UnchosenCandidate {
  size_t candidate = 0;
  std::vector<PredictedSwitch> rules;  // at least one; `pixels` are of kept_px, 0 without it
  // The tallest height from which on, for every smaller one too, its errors keep the threshold: where it might be
  // changed to if it were the cheapest. Nothing where it does not at the smallest.
  std::optional<double> kept_px;
};
std::vector<UnchosenCandidate> unchosen_candidates(const TuneReport& report, size_t subject, const TuneAnswer& answer);

// ---- one rule for every picture and lens
// All conditions (rows and lenses) of one bin of the plan.
struct LensSpread {
  size_t subject = 0, bin = 0, candidate = 0;
  size_t conditions = 0, skipped = 0;
  double tuned = 0;          // the bad end's 5 % of the same views through the tuning's own lens
  double low = 0, high = 0;  // of the bad end's 5 % over the conditions
  bool kept = false;         // every condition keeps the promise (TuneLensCheck::holds)
  bool within = false;       // all of them lie in the 95 % interval of the tuning's
  // The heights at which the tuning itself would show as much: how far the rule is off, in its own unit. Nothing where
  // the error hardly depends on the height there, or beyond the neighbouring heights.
  std::optional<Interval> height_px;
};
std::vector<LensSpread> lens_spreads(const TuneReport& report);

}  // namespace crowdbench::bench
