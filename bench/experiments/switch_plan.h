// Switch plan: which representation draws an agent of which height on the screen, for the least time at an error that
// is allowed, or with the least error in a time that is allowed. Pure functions of tables: nothing here draws or
// measures.
//
// The axis is the height in pixels, in bins from near (tall) to far (small). A plan is a path through the bins: a node
// is a candidate in a bin, and going on with another candidate in the next bin is a switch, which shows. The path is a
// shortest one (dynamic programming), so no other plan of these tables is cheaper.
//
// Based on: T. A. Funkhouser and C. H. Sequin, "Adaptive display algorithm for interactive frame rates during
// visualization of complex virtual environments", SIGGRAPH 1993 (benefit within a budget of time); H. Everett,
// "Generalized Lagrange multiplier method for solving problems of optimum allocation of resources", Operations Research
// 11 (1963).
#pragma once
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "core/statistics.h"

namespace crowdbench::bench {

// [candidate][bin]; bins from near to far. All rows have one length, all values are finite.
struct SwitchTable {
  std::vector<std::vector<double>> cost;   // what one agent there adds, above 0, in one unit of time
  std::vector<std::vector<double>> error;  // at least 0; only for the budget
  std::vector<std::vector<char>> allowed;  // whether its error is allowed there
  std::vector<double> agents;              // expected in the bin, at least 0
  size_t candidates() const { return cost.size(); }
  size_t bins() const { return agents.size(); }
};

// Whether an agent may change from one candidate to the other between bin - 1 and bin. Asked only of changes that a
// cheapest path would make, each once: the answer may be an experiment.
using ChangeAllowed = std::function<bool(size_t from, size_t to, size_t bin)>;

struct SwitchPlan {
  std::vector<size_t> candidate;  // by bin
  double cost = 0;                // of the agents expected
  double error = 0;               // summed over the agents expected
};

// Nothing where no path is allowed. Of equal plans that with the fewest changes, then that of the earlier candidates. A
// bin in which no agent is expected is decided by what one would cost.
std::optional<SwitchPlan> cheapest_plan(const SwitchTable& table, const ChangeAllowed& change_allowed);
// The first bin in which no candidate is allowed: why there is no plan; nothing where there is none such.
std::optional<size_t> first_forbidden_bin(const SwitchTable& table);

// The least error summed over agents at a cost of at most `budget`, whatever `allowed` says: by bisection on the
// multiplier of the cost, so of the plans on the lower convex hull of the trade.
struct BudgetPlan {
  SwitchPlan plan;
  double bound = 0;  // no plan within the budget has less error than this
};
// Nothing where the cheapest plan of all costs more than the budget.
std::optional<BudgetPlan> plan_within_budget(const SwitchTable& table, double budget,
                                             const ChangeAllowed& change_allowed);

// A change in a plan: bin is the first one that the farther candidate draws.
struct PlannedSwitch {
  size_t from = 0, to = 0;
  size_t bin = 0;
};
std::vector<PlannedSwitch> switches_of(const SwitchPlan& plan);

// How sure a change is, over plans of resampled measurements.
struct SwitchCertainty {
  double share = 0;  // of the resamples whose plan changes between these two
  // 95 % percentile interval of the height at which they do, pixels; of those that do. Nothing where none does.
  std::optional<Interval> height_px;
  bool decided() const { return share >= 0.95; }
};
// heights_px: of the bins, falling. resampled: plans by resample; a resample without a plan is nullopt.
SwitchCertainty certainty_of(const PlannedSwitch& change, const std::vector<std::optional<SwitchPlan>>& resampled,
                             const std::vector<double>& heights_px);

}  // namespace crowdbench::bench
