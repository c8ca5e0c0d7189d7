// What `popping` prints and writes.
#pragma once
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "bench/experiments/popping.h"
#include "core/json.h"
#include "metrics/discontinuity.h"
#include "metrics/display.h"

namespace crowdbench::bench {

// One setting of a sweep; the only one where nothing is swept.
struct PoppingRun {
  renderers::Spec representation;
  std::vector<std::pair<std::string, std::string>> setting;  // swept options and their values
  PoppingResult result;
};

struct PoppingReport {
  scene::Scenario scenario;  // as staged
  std::string cast;          // for people
  std::string renderer;
  PoppingRequest request;  // of all runs but for the representation
  std::vector<PoppingRun> runs;
  metrics::ChosenDisplay display;
  size_t rows = 20;                   // switches that are printed
  std::vector<std::string> pictures;  // that were written
};

// {"scenario", "cast", "seed", "width", "height", "renderer", "ticks": [first, last], "fps", "display",
//  "scores": [{"name", "title", "unit", "equal", "computes"}] (pop_scores()), the first sorts,
//  "runs": [{"representation", "setting": {option: value}, "components": [spec], "agents_in_view": summed over frames,
//            "drawings", "switches": count, "seen": count,
//            "quantiles": {score: {"median", "p95" or "p05", "worst"} or null},
//            "list": [{"agent", "character", "tick", "frames", "complete", "from": component, "to": component,
//                      "distance_m", "pixels", "worst_tick", "scores": {score: value}}] the most visible first}],
//  "pictures": [file]}
Json popping_json(const PoppingReport& report);
// A list of switches; of a sweep a table of its settings.
void print_popping(const PoppingReport& report);
// NUMBER_tickT_agentA_before.png, _with.png and _without.png, of each run's switches that have pictures, the most
// visible first; in a sweep behind runR_. Throws Error.
std::vector<std::string> write_pop_pictures(const std::filesystem::path& folder, const PoppingReport& report);

// Of a sequence of which only the pictures are known.
struct JumpReport {
  std::string sequence;
  size_t frames = 0;
  std::vector<metrics::Jump> jumps;
};
// {"sequence", "frames", "found": [frame], "least_jump", "times_median",
//  "jumps": [{"frame", "change", "left", "jump", "found"}]}
Json jumps_json(const JumpReport& report);
void print_jumps(const JumpReport& report);

}  // namespace crowdbench::bench
