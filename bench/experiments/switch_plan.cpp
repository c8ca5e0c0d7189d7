#include "bench/experiments/switch_plan.h"

#include <algorithm>
#include <cassert>
#include <limits>
#include <map>
#include <tuple>

namespace crowdbench::bench {
namespace {

constexpr double kNever = std::numeric_limits<double>::infinity();

// Agents that a bin counts for. An empty one counts a millionth of the crowd, so that it is decided by its costs and
// weighs nothing against a bin with agents.
std::vector<double> weights_of(const SwitchTable& table) {
  double sum = 0;
  for (const double agents : table.agents) sum += agents;
  std::vector<double> out;
  for (const double agents : table.agents) out.push_back(std::max(agents, 1e-6 * std::max(sum, 1.0)));
  return out;
}

// What is known of changes; the rest is taken to be allowed until a path uses it.
using Changes = std::map<std::tuple<size_t, size_t, size_t>, bool>;

// node: [candidate][bin], infinite where forbidden. The cheapest path over what is known.
std::optional<std::vector<size_t>> shortest_path(const std::vector<std::vector<double>>& node, const Changes& known) {
  const size_t candidates = node.size();
  const size_t bins = candidates ? node[0].size() : 0;
  if (bins == 0) return std::nullopt;
  struct State {
    double cost = kNever;
    size_t changes = 0;
    size_t before = 0;
    bool better_than(const State& other) const {
      return std::tuple(cost, changes, before) < std::tuple(other.cost, other.changes, other.before);
    }
  };
  std::vector<std::vector<State>> states(bins, std::vector<State>(candidates));
  for (size_t c = 0; c < candidates; ++c) states[0][c] = {node[c][0], 0, c};
  for (size_t b = 1; b < bins; ++b) {
    for (size_t to = 0; to < candidates; ++to) {
      for (size_t from = 0; from < candidates; ++from) {
        const auto found = known.find({from, to, b});
        if (found != known.end() && !found->second) continue;
        const State& last = states[b - 1][from];
        const State next{last.cost + node[to][b], last.changes + (from != to ? 1 : 0), from};
        if (next.better_than(states[b][to])) states[b][to] = next;
      }
    }
  }
  size_t at = 0;
  for (size_t c = 1; c < candidates; ++c) {
    const auto& [cost, changes, before] = states[bins - 1][c];
    if (std::tuple(cost, changes) < std::tuple(states[bins - 1][at].cost, states[bins - 1][at].changes)) at = c;
  }
  if (states[bins - 1][at].cost == kNever) return std::nullopt;
  std::vector<size_t> path(bins);
  for (size_t b = bins; b-- > 0;) {
    path[b] = at;
    at = states[b][at].before;
  }
  return path;
}

// The cheapest path whose changes are all allowed: asks of those that a path uses, and looks again.
std::optional<std::vector<size_t>> allowed_path(const std::vector<std::vector<double>>& node, Changes& known,
                                                const ChangeAllowed& change_allowed) {
  while (true) {
    const auto path = shortest_path(node, known);
    if (!path) return std::nullopt;
    bool all = true;
    for (size_t b = 1; b < path->size(); ++b) {
      const size_t from = (*path)[b - 1];
      const size_t to = (*path)[b];
      if (from == to) continue;
      const auto [entry, fresh] = known.try_emplace({from, to, b}, true);
      if (fresh) entry->second = change_allowed(from, to, b);
      all = all && entry->second;
    }
    if (all) return path;
  }
}

SwitchPlan plan_of(const SwitchTable& table, std::vector<size_t> path) {
  SwitchPlan plan;
  plan.candidate = std::move(path);
  for (size_t b = 0; b < table.bins(); ++b) {
    const size_t c = plan.candidate[b];
    plan.cost += table.agents[b] * table.cost[c][b];
    if (!table.error.empty()) plan.error += table.agents[b] * table.error[c][b];
  }
  return plan;
}

}  // namespace

std::optional<SwitchPlan> cheapest_plan(const SwitchTable& table, const ChangeAllowed& change_allowed) {
  const std::vector<double> weights = weights_of(table);
  std::vector<std::vector<double>> node = table.cost;
  for (size_t c = 0; c < node.size(); ++c)
    for (size_t b = 0; b < weights.size(); ++b) node[c][b] = table.allowed[c][b] ? weights[b] * node[c][b] : kNever;
  Changes known;
  auto path = allowed_path(node, known, change_allowed);
  if (!path) return std::nullopt;
  return plan_of(table, std::move(*path));
}

std::optional<size_t> first_forbidden_bin(const SwitchTable& table) {
  for (size_t b = 0; b < table.bins(); ++b)
    if (std::none_of(table.allowed.begin(), table.allowed.end(), [&](const auto& row) { return row[b] != 0; }))
      return b;
  return std::nullopt;
}

std::optional<BudgetPlan> plan_within_budget(const SwitchTable& table, double budget,
                                             const ChangeAllowed& change_allowed) {
  assert(table.error.size() == table.cost.size());
  const std::vector<double> weights = weights_of(table);
  Changes known;
  // error + multiplier * cost; at multiplier infinity the cost alone, at 0 the error with the cost as tie-break.
  const auto at = [&](double by_error, double by_cost) {
    std::vector<std::vector<double>> node = table.cost;
    for (size_t c = 0; c < node.size(); ++c)
      for (size_t b = 0; b < weights.size(); ++b)
        node[c][b] = weights[b] * (by_error * table.error[c][b] + by_cost * table.cost[c][b]);
    auto path = allowed_path(node, known, change_allowed);
    return path ? std::optional(plan_of(table, std::move(*path))) : std::nullopt;
  };
  const std::optional<SwitchPlan> cheapest = at(0, 1);
  if (!cheapest || cheapest->cost > budget) return std::nullopt;
  BudgetPlan best{*cheapest, 0};
  const auto consider = [&](const SwitchPlan& plan, double multiplier) {
    best.bound = std::max(best.bound, plan.error + multiplier * (plan.cost - budget));  // weak duality
    if (plan.cost <= budget && plan.error < best.plan.error) best.plan = plan;
  };
  double low = 0;
  double high = 1;
  // From where on the multiplier keeps the budget.
  while (true) {
    const std::optional<SwitchPlan> plan = at(1, high);
    consider(*plan, high);
    if (plan->cost <= budget || high > 1e30) break;
    low = high;
    high *= 16;
  }
  for (int i = 0; i < 100 && high - low > 1e-12 * high; ++i) {
    const double middle = 0.5 * (low + high);
    const std::optional<SwitchPlan> plan = at(1, middle);
    consider(*plan, middle);
    (plan->cost <= budget ? high : low) = middle;
  }
  return best;
}

std::vector<PlannedSwitch> switches_of(const SwitchPlan& plan) {
  std::vector<PlannedSwitch> out;
  for (size_t b = 1; b < plan.candidate.size(); ++b)
    if (plan.candidate[b] != plan.candidate[b - 1]) out.push_back({plan.candidate[b - 1], plan.candidate[b], b});
  return out;
}

SwitchCertainty certainty_of(const PlannedSwitch& change, const std::vector<std::optional<SwitchPlan>>& resampled,
                             const std::vector<double>& heights_px) {
  std::vector<double> heights;
  for (const auto& plan : resampled) {
    if (!plan) continue;
    for (const PlannedSwitch& other : switches_of(*plan)) {
      if (other.from != change.from || other.to != change.to) continue;
      heights.push_back(heights_px[other.bin]);
      break;  // the nearest, where a plan goes back and forth
    }
  }
  SwitchCertainty out;
  if (resampled.empty() || heights.empty()) return out;
  out.share = static_cast<double>(heights.size()) / static_cast<double>(resampled.size());
  out.height_px = Interval{quantile(heights, 0.025), quantile(heights, 0.975)};
  return out;
}

}  // namespace crowdbench::bench
