#include "bench/experiments/tune.h"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>

#include "bench/experiments/tune_measure.h"
#include "bench/experiments/tune_others.h"
#include "core/error.h"

namespace crowdbench::bench {
namespace {

// One table for several characters: costs and losses are means over the agents of the bin, of which each character has
// its share; where none is expected all count alike.
SwitchTable table_for_all(const std::vector<SwitchTable>& tables) {
  if (tables.size() == 1) return tables[0];
  SwitchTable out = tables[0];
  for (size_t b = 0; b < out.bins(); ++b) {
    double sum = 0;
    for (const SwitchTable& table : tables) sum += table.agents[b];
    out.agents[b] = sum;
    for (size_t c = 0; c < out.candidates(); ++c) {
      double cost = 0;
      double error = 0;
      char allowed = 1;
      for (const SwitchTable& table : tables) {
        const double share = sum > 0 ? table.agents[b] / sum : 1.0 / static_cast<double>(tables.size());
        cost += share * table.cost[c][b];
        error += share * table.error[c][b];
        allowed = allowed && table.allowed[c][b];
      }
      out.cost[c][b] = cost;
      out.error[c][b] = error;
      out.allowed[c][b] = allowed;
    }
  }
  return out;
}

// What is sought of the measurements of some characters: one plan.
class Answering {
 public:
  Answering(const TuneRequest& request, std::vector<TuneMeasurement*> measured)
      : request_(request), measured_(std::move(measured)) {}

  TuneAnswer run() {
    std::vector<SwitchTable> tables;
    for (const TuneMeasurement* one : measured_) tables.push_back(one->measured().table);
    answer_.table = table_for_all(tables);
    for (const TuneMeasurement* one : measured_) answer_.base_ns = std::max(answer_.base_ns, one->measured().base_ns);
    answer_.plan = plan_of(answer_.table);
    if (request_.budget_ns > 0) describe_budget();
    // The scenario's crowd is of all characters: of one alone it says nothing.
    if (request_.budget_ns > 0 && request_.frame_ns && measured_.size() == request_.subjects.size())
      keep_budget_in_scenario();
    resample();
    if (answer_.plan) describe_switches();
    return std::move(answer_);
  }

 private:
  // The character of which the switch shows most says whether it is allowed.
  TunePop pop(size_t from, size_t to, size_t bin) const {
    std::vector<TunePop> pops;
    for (TuneMeasurement* one : measured_) pops.push_back(one->pop(from, to, bin));
    return *std::min_element(pops.begin(), pops.end(), [&](const TunePop& a, const TunePop& b) {
      return std::pair(a.allowed, -badness_of(*request_.pop.score, a.tail)) <
             std::pair(b.allowed, -badness_of(*request_.pop.score, b.tail));
    });
  }

  bool change_allowed(size_t from, size_t to, size_t bin) const { return pop(from, to, bin).allowed; }
  double budget_of_agents() const { return request_.budget_ns / factor_ - answer_.base_ns; }

  std::optional<SwitchPlan> plan_of(const SwitchTable& table) {
    const auto changes = [&](size_t from, size_t to, size_t bin) { return change_allowed(from, to, bin); };
    if (request_.budget_ns <= 0) return cheapest_plan(table, changes);
    const std::optional<BudgetPlan> within = plan_within_budget(table, budget_of_agents(), changes);
    bound_ = within ? within->bound : 0;
    return within ? std::optional(within->plan) : std::nullopt;
  }

  void describe_budget() {
    TuneBudgetAnswer budget{answer_.base_ns, std::numeric_limits<double>::infinity(), bound_, std::nullopt, 1};
    SwitchTable any = answer_.table;
    for (auto& row : any.allowed) std::fill(row.begin(), row.end(), 1);
    const auto changes = [&](size_t from, size_t to, size_t bin) { return change_allowed(from, to, bin); };
    cheapest_ = cheapest_plan(any, changes);
    if (cheapest_) budget.cheapest_ns = answer_.base_ns + cheapest_->cost;
    answer_.budget = budget;
  }

  // The table's costs are corrected by what the plan itself takes, until it fits. The cheapest chain has the last word:
  // where it does not fit either, nothing does.
  void keep_budget_in_scenario() {
    if (!answer_.plan) return;
    constexpr int kTries = 4;
    for (int i = 1; i < kTries && answer_.plan; ++i) {
      if (fits_in_scenario()) return;
      answer_.plan = plan_of(answer_.table);
      answer_.budget->bound = bound_;
    }
    answer_.plan = cheapest_;
    if (!fits_in_scenario()) answer_.plan = std::nullopt;
  }

  bool fits_in_scenario() {
    describe_switches();
    const double measured = request_.frame_ns(tuned_representation(request_, answer_));
    answer_.budget->measured_ns = measured;
    if (measured <= request_.budget_ns) return true;
    factor_ = measured / (answer_.base_ns + answer_.plan->cost);
    answer_.budget->factor = factor_;
    return false;
  }

  // Errors by blocks drawn anew, costs by rounds drawn anew; changes as they were measured.
  void resample() {
    std::vector<double> savings;
    for (size_t i = 0; i < kTuneResamples; ++i) {
      std::vector<SwitchTable> tables;
      for (const TuneMeasurement* one : measured_) tables.push_back(one->resampled(i));
      const SwitchTable table = table_for_all(tables);
      answer_.again.push_back(plan_of(table));
      if (answer_.plan) savings.push_back(cost_of_reference(table) / cost_of(table, answer_.plan->candidate));
    }
    answer_.reference_cost = cost_of_reference(answer_.table);
    if (!savings.empty()) answer_.saving = {quantile(savings, 0.025), quantile(savings, 0.975)};
  }
  static double cost_of(const SwitchTable& table, const std::vector<size_t>& path) {
    double sum = 0;
    for (size_t b = 0; b < path.size(); ++b) sum += std::max(table.agents[b], 1e-9) * table.cost[path[b]][b];
    return sum;
  }
  double cost_of_reference(const SwitchTable& table) const {
    const std::string name = renderers::reference_spec().text();
    for (size_t c = 0; c < request_.candidates.size(); ++c)
      if (request_.candidates[c].text() == name) return cost_of(table, std::vector<size_t>(table.bins(), c));
    assert(false);
    return 0;
  }

  // The certainty is known once the resamples are.
  void describe_switches() {
    answer_.switches.clear();
    for (const PlannedSwitch& change : switches_of(*answer_.plan)) {
      TuneSwitch one;
      one.change = change;
      one.height_px = request_.heights_px[change.bin];
      one.certainty = certainty_of(change, answer_.again, request_.heights_px);
      one.pop = pop(change.from, change.to, change.bin);
      if (one.certainty.decided()) one.hysteresis = hysteresis_of(*one.certainty.height_px);
      answer_.switches.push_back(one);
    }
  }

  const TuneRequest& request_;
  std::vector<TuneMeasurement*> measured_;
  double factor_ = 1;                   // of the table's costs
  double bound_ = 0;                    // of the latest plan within the budget
  std::optional<SwitchPlan> cheapest_;  // with a budget: of all chains, whatever they show
  TuneAnswer answer_;
};

// The representation made of two, switched by height.
const renderers::RepresentationType& switching_type() {
  for (const renderers::RepresentationType& type : renderers::representation_types())
    for (const renderers::OptionDoc& option : type.options)
      if (type.components == 2 && option.key == "height") return type;
  throw Error("tune", "no representation switches by height", "");
}

}  // namespace

TuneResult tune(gl::Context& context, const TuneRequest& request) {
  std::vector<std::unique_ptr<TuneMeasurement>> measured;
  std::vector<TuneMeasurement*> all;
  for (size_t i = 0; i < request.subjects.size(); ++i) {
    measured.push_back(std::make_unique<TuneMeasurement>(context, request, i));
    all.push_back(measured.back().get());
  }
  TuneResult result;
  result.together = Answering(request, all).run();
  if (all.size() > 1)
    for (TuneMeasurement* one : all) result.alone.push_back(Answering(request, {one}).run());
  const bool of_others = result.together.plan && no_promise_of_others(request).empty();
  for (size_t i = 0; of_others && i < all.size(); ++i) {
    std::vector<TuneMeasurement*> others = all;
    others.erase(others.begin() + static_cast<std::ptrdiff_t>(i));
    result.left_out.push_back(Answering(request, others).run());
  }
  for (const TuneMeasurement* one : all) result.subjects.push_back(one->measured());
  return result;
}

renderers::Spec tuned_representation(const TuneRequest& request, const TuneAnswer& answer) {
  assert(answer.plan);
  renderers::Spec spec = request.candidates[answer.plan->candidate.back()];
  for (size_t i = answer.switches.size(); i-- > 0;) {
    const TuneSwitch& change = answer.switches[i];
    renderers::Spec outer;
    outer.name = switching_type().name;
    outer.components = {request.candidates[change.change.from], spec};
    outer.options = {{"height", fmt::format("{:.4g}", change.height_px)}};
    if (change.hysteresis > 0) outer.options.emplace_back("hysteresis", fmt::format("{:.3g}", change.hysteresis));
    if (request.fade > 0) outer.options.emplace_back("fade", std::to_string(request.fade));
    spec = outer;
  }
  return spec;
}

size_t bin_of_height(const std::vector<double>& heights_px, double height_px) {
  size_t bin = 0;
  while (bin + 1 < heights_px.size() && heights_px[bin + 1] >= height_px) ++bin;
  return bin;
}

double hysteresis_of(const Interval& height_px) { return std::min(1.0, std::sqrt(height_px.high / height_px.low) - 1); }

double loss_of(const metrics::Score& score, double value) {
  return std::max(0.0, badness_of(score, value) - badness_of(score, metrics::best_value(score)));
}

double depth_of_height(double height, double height_px, int rows, double fov_y) {
  return height * rows / (height_px * 2 * std::tan(fov_y / 2));
}

}  // namespace crowdbench::bench
