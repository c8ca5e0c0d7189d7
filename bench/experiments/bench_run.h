// `bench`: frame times of several representations against the number of agents, written to a result store.
#pragma once
#include <functional>
#include <string>
#include <vector>

#include "bench/stage/stage_facts.h"
#include "bench/timing/timing_method.h"
#include "metrics/registry.h"
#include "renderers/frame/capture.h"
#include "scene/cast/cast.h"
#include "scene/scenario/scenario.h"
#include "store/store.h"

namespace crowdbench::bench {

struct BenchRequest {
  scene::Scenario scenario;  // agents and occupancy are replaced by the axes below
  // Drawn beside the reference, which is always the mesh and need not be named. Canonical texts are unique.
  std::vector<renderers::Spec> representations;
  std::vector<uint32_t> agents{1, 10, 100, 1000};  // ascending, each at least 1
  std::vector<double> occupancies{0.15, 0.9};      // 0: the scenario's own camera
  double budget_ms = 1000;                         // wall time a frame: a curve ends with the first point beyond it
  int rounds = 24;  // timed rounds a point, fewer when they take longer than time_limit_s, never below least_rounds
  int least_rounds = 10;
  double time_limit_s = 10;
  // For all points together (see TimeBudget), 0: as long as it takes. When it is over, the point at hand ends: it keeps
  // its rounds, be they fewer than least_rounds, from six on; with fewer it is left for another run.
  double total_time_s = 0;
  // Called after each point with how many are through, and what is left of total_time_s.
  std::function<void(size_t done, double seconds_left)> after_point;
  bool floors = true;                // also time each representation's floor
  uint64_t order_seed = kOrderSeed;  // of the order within a round (TimingPlan)
  uint32_t picture_agents = 250;     // pictures are kept of the largest measured crowd up to this, at each occupancy
  uint64_t bake_budget = uint64_t{512} << 20;
  metrics::ScoreTable table = metrics::scores();  // of the pictures
  metrics::ChosenDisplay display;                 // that they are looked at on
};

// The stage of a point, as it was solved for.
struct StagedPoint {
  uint32_t agents = 0;
  double requested_occupancy = 0;  // 0: the scenario's own camera
  StageFacts facts;
};

// The numbers of agents of a thorough run: 1 to 10,000.
std::vector<uint32_t> full_agents();

// The levels of detail that a representation draws.
struct DrawnLevels {
  std::string representation;
  std::vector<renderers::LevelInfo> levels;
};

struct BenchSummary {
  size_t measured = 0;               // points timed now
  size_t held = 0;                   // points that the file already had, be it as over the budget
  size_t invalid = 0;                // of those timed now: the image check failed
  std::vector<StagedPoint> stages;   // of the points solved for now, unreachable ones too
  std::vector<DrawnLevels> levels;   // of the representations that draw such
  std::vector<std::string> remarks;  // where and why a curve stopped, what was skipped: one line each
};

// Measures point by point: at each occupancy the numbers of agents ascend; all representations whose curve still goes
// on share its rounds; each point is one transaction. Points that the store holds for the same scenario, revision and
// renderer are not measured again. run: its id is that of the row that the caller wrote. Throws Error and Interrupted;
// what was finished before is kept. progress: called with what is going on now.
BenchSummary run_bench(gl::Context& context, const scene::Cast& cast, const TimingMethod& method, const RunRow& run,
                       const BenchRequest& request, StoreWriter& store,
                       const std::function<void(const std::string&)>& progress);

// Whole-frame scores of a representation's picture against the reference's (same view): each of the table's that
// colours, ids and depths have.
std::vector<ScoreRow> score_crowd(metrics::ScoreTable table, const metrics::ChosenDisplay& display,
                                  const renderers::Capture& reference, const renderers::Capture& test);
// The pictures of one comparison: reference, test, pseudocolour difference, with its colour bar where `bar`; of no run.
std::vector<PictureRow> comparison_pictures(const Image8& reference, const Image8& test,
                                            const std::string& reference_name, const std::string& test_name,
                                            bool bar = true);
// The colour bar of those "difference" pictures of a run that have none of their own, as role "legend".
void write_legend(StoreWriter& store, int64_t run);
// comparison_pictures, written.
void write_pictures(StoreWriter& store, int64_t run, int64_t comparison, const Image8& reference, const Image8& test,
                    const std::string& reference_name, const std::string& test_name, bool bar = true);

}  // namespace crowdbench::bench
