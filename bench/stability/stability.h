// Stability: what holds at the extremes, as a table of measured values beside their bounds.
//
// A case is one row of the table in stability.cpp: what is asked, a bound with where it comes from, and a function from
// a Fixture to what was found. Most are asked of every representation; those about numbers, clips and statistics are
// asked once. A group of cases is one file of this folder.
#pragma once
#include <cstdint>
#include <functional>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

#include "core/image.h"
#include "renderers/representation.h"

namespace crowdbench::gl {
class Context;
}

namespace crowdbench::bench {

class Fixture;

// What one case came to. It holds where `measured` <= `bound`; a value that is not a number does not.
struct Found {
  double measured = std::numeric_limits<double>::quiet_NaN();
  double bound = 0;
  std::string place;          // of the worst: "pixel (120, 44)", "crowd.agents = nan"; empty where nothing is off
  std::string expected, got;  // both values there, for people
  std::string note;           // what a reader must know besides: what was left out, how much was looked at
  Image8 before, after;       // RGB, the worst pixel's surroundings enlarged, in both pictures; may be empty
};
inline bool holds(const Found& found) { return found.measured <= found.bound; }

struct StabilityCase {
  std::string_view name;   // [a-z0-9_], for ever
  std::string_view group;  // "world"
  std::string_view asked;
  std::string_view unit;
  std::string_view bound_from;  // how the bound is derived
  bool bound_seen = false;      // it was set after seeing what is reached, which bound_from says too
  bool once = false;            // asks nothing of a representation
  bool full = false;            // only with FixtureOptions::full
  bool small = true;            // also in the form that sanitizers run
  Found (*measure)(Fixture& fixture) = nullptr;
};
// Every case, in the order in which they are run.
std::vector<StabilityCase> stability_cases();

// One case of one representation, done.
struct StabilityRow {
  StabilityCase asked;
  std::string representation;  // canonical text; empty for a case that is asked once
  Found found;
  std::string error;  // it could not be measured, because; such a row does not pass
  double seconds = 0;
  bool pass() const { return error.empty() && holds(found); }
};

struct StabilityRequest {
  std::vector<renderers::Spec> representations;  // none: example_spec of every type
  std::vector<std::string> cases;                // names, or groups; none: all
  bool small = false;                            // fewer and smaller pictures
  bool full = false;                             // also what takes minutes
  bool use_cache = true;
};
// Throws Error: a name that is neither a case nor a group.
std::vector<StabilityCase> chosen_cases(const StabilityRequest& request);
// Runs them; says progress, notices Ctrl-C. cases: chosen_cases of the request, or others (tests).
std::vector<StabilityRow> run_stability(gl::Context& context, const StabilityRequest& request,
                                        const std::vector<StabilityCase>& cases);

// The groups; each adds its cases.
void add_world_cases(std::vector<StabilityCase>& cases);
void add_time_cases(std::vector<StabilityCase>& cases);
void add_eye_cases(std::vector<StabilityCase>& cases);
void add_path_cases(std::vector<StabilityCase>& cases);
void add_size_cases(std::vector<StabilityCase>& cases);
void add_character_cases(std::vector<StabilityCase>& cases);
void add_number_cases(std::vector<StabilityCase>& cases);
void add_statistics_cases(std::vector<StabilityCase>& cases);
void add_truth_cases(std::vector<StabilityCase>& cases);
void add_depth_cases(std::vector<StabilityCase>& cases);

}  // namespace crowdbench::bench
