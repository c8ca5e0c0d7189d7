#include "bench/commands/tune_output.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "bench/experiments/tune_measure.h"
#include "core/counted.h"
#include "core/error.h"

namespace crowdbench::bench {
namespace {

void print_heights(const TuneReport& report, size_t subject) {
  const TuneMeasured& measured = report.result.subjects[subject];
  const metrics::Score& score = *report.request.error.score;
  const auto& plan = report.result.together.plan;
  fmt::print("{:>8} {:>8} {:>8}", "height", "depth", "agents");
  for (size_t c = 0; c < report.request.candidates.size(); ++c) fmt::print("  {:>24.24}", candidate_name(report, c));
  fmt::print("\n{:>8} {:>8} {:>8}", "pixels", "m", "");
  for (size_t c = 0; c < report.request.candidates.size(); ++c)
    fmt::print("  {:>24}", fmt::format("{:.9} us an agent", score.column));
  fmt::print("\n");
  for (size_t b = 0; b < report.request.heights_px.size(); ++b) {
    const double height = report.request.heights_px[b];
    fmt::print("{:>8.1f} {:>8.1f} {:>8.0f}", height, depth_in_report(report, subject, height),
               measured.table.agents[b]);
    for (size_t c = 0; c < report.request.candidates.size(); ++c) {
      const TuneError& error = measured.errors[c][b];
      const std::string cell = error.values.empty()
                                   ? std::string("n/a")
                                   : fmt::format("{}{:.{}f} {:>8.2f}", plan && plan->candidate[b] == c ? "> " : "",
                                                 error.tail, score.digits, 1e-3 * measured.table.cost[c][b]);
      fmt::print("  {:>24}", cell);
    }
    fmt::print("\n");
  }
}

std::string switch_text(const TuneReport& report, size_t subject, const TuneSwitch& one) {
  const metrics::Score& pop = *report.request.pop.score;
  const EngineSizes engines = engines_in_report(report, subject, one.height_px);
  const std::string sure =
      one.certainty.decided()
          ? fmt::format("in resamples {:.1f} to {:.1f} pixels", one.certainty.height_px->low,
                        one.certainty.height_px->high)
          : fmt::format("undecided: {:.1f} % of the resamples switch between these two", 100 * one.certainty.share);
  return fmt::format(
      "from {:.1f} pixels ({:.1f} m) on {} instead of {}; {}\n  the switch shows {} {:.{}f}; Unity {:.4f} of the "
      "screen's "
      "height at lodBias 1, Unreal screen size {:.4f}, Godot visibility range {:.2f} m",
      one.height_px, depth_in_report(report, subject, one.height_px), candidate_name(report, one.change.to),
      candidate_name(report, one.change.from), sure, pop.title, one.pop.tail, pop.digits, engines.unity_height,
      engines.unreal_size, engines.godot_metres);
}

std::string budget_text(const TuneReport& report, const TuneAnswer& answer) {
  const TuneBudgetAnswer& budget = *answer.budget;
  double agents = 0;
  for (const double in_bin : answer.table.agents) agents += in_bin;
  const double each = std::max(agents, 1.0);
  std::string text = fmt::format(
      "{:g} ms for {}, {:.0f} of them in view: the least visible set takes {:.2f} ms by its agents' costs, "
      "{:.2f} of "
      "them without any agent",
      1e-6 * report.request.budget_ns, counted(report.crowd, "agent", "agents"), agents,
      1e-6 * (budget.base_ns + answer.plan->cost), 1e-6 * budget.base_ns);
  if (budget.measured_ns) text += fmt::format("; as a crowd {:.2f} ms", 1e-6 * *budget.measured_ns);
  if (budget.factor > 1)
    text += fmt::format(" (costs corrected by {:.2f}: what was sought first took longer than its agents' costs said)",
                        budget.factor);
  return text + fmt::format("\n  an agent loses {:.3f} of {} on average; no set within the budget less than {:.3f}",
                            answer.plan->error / each, report.request.error.score->title,
                            std::max(0.0, budget.bound) / each);
}

void print_answer(const TuneReport& report, size_t subject, const TuneAnswer& answer) {
  if (!answer.plan) {
    fmt::print("{}\n", no_plan_text(report, answer));
    return;
  }
  if (answer.budget) fmt::print("{}\n", budget_text(report, answer));
  if (answer.switches.empty())
    fmt::print("{} at every height{}\n", candidate_name(report, answer.plan->candidate[0]),
               answer.budget ? "" : ": nothing cheaper is allowed");
  for (const TuneSwitch& one : answer.switches) fmt::print("{}\n", switch_text(report, subject, one));
  fmt::print("draws as: {}\n", tuned_representation(report.request, answer).text());
}

void print_noise(const TuneReport& report, size_t subject) {
  const TuneMeasured& measured = report.result.subjects[subject];
  for (size_t c = 0; c < report.request.candidates.size(); ++c)
    if (!measured.refused[c].empty())
      fmt::print("{} is left out: {}\n", candidate_name(report, c), measured.refused[c]);
  for (size_t c = 0; c < report.request.candidates.size(); ++c)
    for (size_t h = 0; h < measured.costs.costs[c].size(); ++h)
      if (!measured.costs.costs[c][h].resolved)
        fmt::print("{} at {:.1f} pixels: one more agent is within the noise; the whole frame's time over its agents\n",
                   candidate_name(report, c), measured.cost_heights_px[h]);
}

void print_lenses(const TuneReport& report) {
  const metrics::Score& score = *report.request.error.score;
  size_t broken = 0;
  size_t skipped = 0;
  for (const TuneLensCheck& one : *report.lenses) {
    skipped += one.skipped;
    if (one.holds || one.skipped) continue;
    ++broken;
    fmt::print("NOT through {:g} degrees on {} rows: {} at {:.1f} pixels, {} of {} {} worse than promised\n",
               one.lens.fov_y_deg, one.lens.rows, candidate_name(report, one.candidate),
               report.request.heights_px[one.bin], one.worse, counted(one.views, "view", "views"),
               one.worse == 1 ? "is" : "are");
  }
  double largest = 0;  // of skipped ones 0
  for (const TuneLensCheck& one : *report.lenses) largest = std::max(largest, std::abs(one.mean_difference));
  fmt::print(
      "the rule in pixels holds in {} of {} (rows and lenses, at the same pixels per degree); {} differs by "
      "{:.{}f} "
      "on average at most\n",
      report.lenses->size() - skipped - broken, counted(report.lenses->size() - skipped, "check", "checks"),
      score.title, largest, score.digits);
  if (skipped > 0)
    fmt::print("  skipped: {} of figures taller than so many rows show whole\n",
               counted(skipped, "further check", "further checks"));
}

void print_proof(const TuneReport& report) {
  const TuneProof& proof = *report.proof;
  const metrics::Score& score = *report.request.error.score;
  fmt::print("proof{}: {}\n", proof.character.empty() ? "" : " on " + printable(proof.character),
             proof.holds() ? "the promise holds" : "the promise does NOT hold");
  fmt::print("{:>20} {:>12} {:>22} {:>12} {:>12}\n", "unseen seed", "times fast", "promised", "reference ms",
             "plan ms");
  for (const SeedTimes& one : proof.speed.seeds)
    fmt::print(
        "{:>20} {:>12.3f} {:>22} {:>12.2f} {:>12.2f}\n", one.seed, one.ratio,
        fmt::format("{:.3f} to {:.3f}", report.promise->on_another_seed.low, report.promise->on_another_seed.high),
        1e-6 * one.reference_ns, 1e-6 * one.plan_ns);
  fmt::print("  speed: {} of {} within what was promised: {}\n", proof.speed.within,
             counted(proof.speed.seeds.size(), "seed", "seeds"), proof.speed.holds ? "holds" : "does NOT hold");
  for (const ErrorProof& one : proof.errors)
    fmt::print(
        "  error: {} of {} worse than promised (5 % may be), {} over the threshold; {} at the bad end's "
        "5 "
        "% {:.{}f}, worst {:.{}f} at {:.1f} pixels: {}\n",
        one.worse, counted(one.views, "unseen figure", "unseen figures"), one.over_threshold, score.title, one.tail,
        score.digits, one.worst, score.digits, one.worst_height_px, one.holds ? "holds" : "does NOT hold");
}

}  // namespace

bool TuneProof::holds() const {
  return speed.holds && std::all_of(errors.begin(), errors.end(), [](const ErrorProof& one) { return one.holds; });
}

std::string candidate_name(const TuneReport& report, size_t candidate) {
  return report.request.candidates[candidate].text();
}

double depth_in_report(const TuneReport& report, size_t subject, double height_px) {
  const SwitchCostRequest& lens = report.request.cost;
  return depth_of_height(report.request.subjects[subject].character->placement.height, height_px, lens.height,
                         lens.fov_y);
}

EngineSizes engines_in_report(const TuneReport& report, size_t subject, double height_px) {
  const SwitchCostRequest& lens = report.request.cost;
  return engine_sizes(report.bounds[subject], depth_in_report(report, subject, height_px), lens.fov_y,
                      static_cast<double>(lens.width) / lens.height);
}

double agents_in_view(const TuneReport& report) {
  double sum = 0;
  for (const double agents : report.result.together.table.agents) sum += agents;
  return sum;
}

std::string no_plan_text(const TuneReport& report, const TuneAnswer& answer) {
  if (answer.budget) {
    const TuneBudgetAnswer& budget = *answer.budget;
    std::string text = fmt::format("nothing fits in {:g} ms: ", 1e-6 * report.request.budget_ns);
    if (!std::isfinite(budget.cheapest_ns)) return text + "no chain of switches keeps the pop threshold";
    text += fmt::format("the cheapest set takes {:.2f} ms for {}, {:.2f} of them without any agent",
                        1e-6 * budget.factor * budget.cheapest_ns, counted(report.crowd, "agent", "agents"),
                        1e-6 * budget.factor * budget.base_ns);
    if (budget.measured_ns)
      text += fmt::format("; as a crowd a frame takes {:.2f} times its agents' costs", budget.factor);
    return text;
  }
  const auto bin = first_forbidden_bin(answer.table);
  if (!bin) return "no chain of switches keeps the pop threshold";
  return fmt::format("no candidate keeps {} {:g} at {:.1f} pixels", report.request.error.score->title,
                     report.request.error.value, report.request.heights_px[*bin]);
}

void print_tune(const TuneReport& report) {
  const TuneResult& result = report.result;
  const TuneAnswer& answer = result.together;
  if (report.proof && !report.proof->holds()) fmt::print("the promise below does NOT hold on unseen crowds\n");
  for (size_t s = 0; s < result.subjects.size(); ++s) {
    const size_t views = result.subjects[s].views;
    fmt::print("{}: {} at the bad end's 5 % of {}, threshold {:g}; {} of one more agent; {}x{}\n",
               printable(report.request.subjects[s].character->name), report.request.error.score->title,
               counted(views, "view and moment", "views and moments"), report.request.error.value,
               result.subjects[s].costs.clock, report.request.cost.width, report.request.cost.height);
    if (views < kTailValues)
      fmt::print("  fewer than {} views bound no tail: the worst one seen stands for its end\n", kTailValues);
    print_heights(report, s);
    print_noise(report, s);
    if (!result.alone.empty()) {
      fmt::print("{} by itself:\n", printable(report.request.subjects[s].character->name));
      print_answer(report, s, result.alone[s]);
    }
  }
  if (!result.alone.empty()) fmt::print("for all {} characters (metres of the first):\n", result.subjects.size());
  print_answer(report, 0, answer);
  if (!answer.plan) return;
  for (size_t i = 0; i < report.predicted_px.size(); ++i)
    if (const auto& predicted = report.predicted_px[i])
      fmt::print("  one texel a pixel would switch to {} at {:.1f} pixels ({:.1f} m)\n",
                 candidate_name(report, answer.switches[i].change.to), *predicted,
                 depth_in_report(report, 0, *predicted));
  if (agents_in_view(report) > 0)
    fmt::print("{} in view: {:.2f} times as fast as {} ({:.2f} to {:.2f}), what a frame costs anyhow not counted\n",
               counted(static_cast<uint64_t>(std::llround(agents_in_view(report))), "agent", "agents"),
               answer.reference_cost / std::max(answer.plan->cost, 1e-9), renderers::reference_spec().text(),
               answer.saving.low, answer.saving.high);
  if (report.promise)
    fmt::print("promised: the whole frame on another seed {:.2f} times as fast as {} ({:.2f} to {:.2f}, from {})\n",
               report.promise->ratio, renderers::reference_spec().text(), report.promise->on_another_seed.low,
               report.promise->on_another_seed.high, counted(report.promise->seeds.size(), "seed", "seeds"));
  if (report.lenses) print_lenses(report);
  if (report.proof) print_proof(report);
}

}  // namespace crowdbench::bench
