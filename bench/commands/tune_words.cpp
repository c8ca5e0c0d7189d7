// The sentences that a tuning is told in, on the terminal and on its page.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "bench/commands/tune_output.h"
#include "bench/experiments/tune_measure.h"
#include "core/counted.h"

namespace crowdbench::bench {
namespace {

std::string times_fast(double value, double low, double high) {
  return fmt::format("{:.2f} times as fast as {} (95 %: {:.2f} to {:.2f})", value, renderers::reference_spec().text(),
                     low, high);
}

std::string range_text(double low, double high, int digits) {
  const std::string a = fmt::format("{:.{}f}", low, digits);
  const std::string b = fmt::format("{:.{}f}", high, digits);
  return a == b ? a : a + " to " + b;
}

}  // namespace

std::string switch_certainty_text(const TuneReport& report, const TuneSwitch& one) {
  const std::string next =
      fmt::format("the next taller height measured is {:.1f}", report.request.heights_px[one.change.bin - 1]);
  if (!one.certainty.decided())
    return fmt::format("undecided: {:.1f} % of the resamples switch between these two; {}", 100 * one.certainty.share,
                       next);
  return fmt::format("95 % of the resamples: {} pixels; {}",
                     range_text(one.certainty.height_px->low, one.certainty.height_px->high, 1), next);
}

std::string predicted_text(const TuneReport& report, const PredictedSwitch& one) {
  const metrics::Score& score = *report.request.error.score;
  std::string text = fmt::format("{} would switch at {:.1f} pixels ({:.1f} m)", one.rule, one.height_px, one.depth_m);
  if (one.beyond) return text + ", beyond the heights that were measured";
  if (one.error->values.empty()) return text + ", where it has no score";
  return text + fmt::format(": there {} have {} {:.{}f} or {}, {:g} was asked for: {}; {:.2f} us an agent",
                            one.error->values.size() < kTailValues ? "all figures drawn" : "95 % of the figures",
                            score.title, one.error->promised, score.digits,
                            score.direction == metrics::Direction::higher_is_better ? "more" : "less",
                            report.request.error.value, one.error->allowed ? "enough" : "NOT enough",
                            1e-3 * one.cost_ns);
}

std::string unchosen_text(const TuneReport& report, size_t subject, const UnchosenCandidate& one) {
  const std::string name = candidate_name(report, one.candidate) + ", to which the rule changes nowhere: ";
  if (!one.kept_px) return name + "does not keep the threshold even at the smallest height measured";
  return fmt::format("{}keeps the threshold by itself from {:.1f} pixels ({:.1f} m) on", name, *one.kept_px,
                     depth_in_report(report, subject, *one.kept_px));
}

std::string few_views_text(size_t views) {
  if (views >= kTailValues) return {};
  return fmt::format("fewer than {} views bound no tail: the worst one seen stands for its end", kTailValues);
}

std::string lens_text(const TuneReport& report, const LensSpread& spread) {
  const metrics::Score& score = *report.request.error.score;
  const TuneError& error = report.result.subjects[spread.subject].errors[spread.candidate][spread.bin];
  const double height = report.request.heights_px[spread.bin];
  std::string text = fmt::format("{} at {:.1f} pixels", candidate_name(report, spread.candidate), height);
  if (report.request.subjects.size() > 1) text = report.request.subjects[spread.subject].character->name + ", " + text;
  if (spread.conditions == 0) return text + ": taller than any of these pictures shows whole";
  text += fmt::format(": {} at the bad end's 5 % is {} over {} pictures and lenses, {:.{}f} as tuned (95 %: {}): {}",
                      score.title, range_text(spread.low, spread.high, score.digits), spread.conditions, spread.tuned,
                      score.digits, range_text(error.interval.low, error.interval.high, score.digits),
                      !spread.kept    ? "the promise is NOT kept"
                      : spread.within ? "within"
                                      : "kept, but not within");
  if (spread.height_px)
    text += fmt::format("; as if switched at {} pixels", range_text(spread.height_px->low, spread.height_px->high, 1));
  if (spread.skipped > 0) text += fmt::format(" ({} more are too small for it)", spread.skipped);
  return text;
}

std::string lens_verdict(const std::vector<LensSpread>& spreads) {
  if (spreads.empty()) return "nothing but the reference is drawn: there is no rule to check";
  const auto all = [&](auto member) {
    return std::all_of(spreads.begin(), spreads.end(),
                       [&](const LensSpread& spread) { return spread.conditions == 0 || spread.*member; });
  };
  if (!all(&LensSpread::kept)) return "one rule in pixels does NOT hold at every resolution and field of view";
  return all(&LensSpread::within)
             ? "one rule in pixels holds at every resolution and field of view, within its interval"
             : "one rule in pixels keeps its promise at every resolution and field of view, though not all of them lie "
               "within its interval";
}

std::string budget_text(const TuneReport& report, const TuneAnswer& answer) {
  const TuneBudgetAnswer& budget = *answer.budget;
  const double agents = agents_in_view(answer);
  const double each = std::max(agents, 1.0);
  std::string text = fmt::format(
      "{:g} ms for {}, {:.0f} of them in view: the least visible set takes {:.2f} ms by its agents' costs, "
      "{:.2f} of them without any agent",
      1e-6 * report.request.budget_ns, counted(report.crowd, "agent", "agents"), agents,
      1e-6 * (budget.base_ns + answer.plan->cost), 1e-6 * budget.base_ns);
  if (budget.measured_ns) text += fmt::format("; as a crowd {:.2f} ms", 1e-6 * *budget.measured_ns);
  if (budget.factor > 1)
    text += fmt::format(" (costs corrected by {:.2f}: what was sought first took longer than its agents' costs said)",
                        budget.factor);
  return text + fmt::format("; an agent loses {:.3f} of {} on average, and no set within the budget less than {:.3f}",
                            answer.plan->error / each, report.request.error.score->title,
                            std::max(0.0, budget.bound) / each);
}

std::string saving_text(const TuneAnswer& answer) {
  return fmt::format(
      "{:.0f} agents in view: {}, what a frame costs anyhow not counted", agents_in_view(answer),
      times_fast(answer.reference_cost / std::max(answer.plan->cost, 1e-9), answer.saving.low, answer.saving.high));
}

std::string promise_text(const SpeedPromise& promise) {
  return fmt::format("promised of the whole frame on another seed: {}, from {}",
                     times_fast(promise.ratio, promise.on_another_seed.low, promise.on_another_seed.high),
                     counted(promise.seeds.size(), "seed", "seeds"));
}

std::string score_promise_text(const TuneReport& report) {
  const metrics::Score& score = *report.request.error.score;
  const ScorePromise& promise = *report.score_promise;
  return fmt::format(
      "promised of the figures on another seed: {} {:.{}f} on average (95 %: {:.{}f} to {:.{}f}), from {}", score.title,
      promise.mean, score.digits, promise.on_another_seed.low, score.digits, promise.on_another_seed.high, score.digits,
      counted(promise.seeds.size(), "seed", "seeds"));
}

std::string others_promise_text(const TuneReport& report) {
  if (!report.others) return "nothing is promised of a character that was not tuned: " + why_no_others(report);
  const metrics::Score& score = *report.request.error.score;
  const OthersPromise& promise = *report.others;
  const auto value = [&](double mean, const Interval& interval) {
    return fmt::format("{:.{}f} (95 %: {:.{}f} to {:.{}f})", mean, score.digits, interval.low, score.digits,
                       interval.high, score.digits);
  };
  return fmt::format(
      "promised of a character that was not tuned: {}; {} {} on average and {} at the bad end's 5 %; from {} "
      "characters, each drawn by the rule of the others",
      times_fast(promise.ratio, promise.ratio_of_another.low, promise.ratio_of_another.high), score.title,
      value(promise.mean, promise.mean_of_another), value(promise.tail, promise.tail_of_another),
      promise.left_out.size());
}

std::vector<std::string> proof_texts(const TuneReport& report) {
  const TuneProof& proof = *report.proof;
  const metrics::Score& score = *report.request.error.score;
  const auto verdict = [](bool holds) { return holds ? "holds" : "does NOT hold"; };
  if (proof.other) {
    const CharacterDrawn& drawn = proof.other->drawn;
    const OthersPromise& promise = *report.others;
    const auto held = [&](const Interval& interval, int digits, bool within) {
      return fmt::format("promised {:.{}f} to {:.{}f}: {}", interval.low, digits, interval.high, digits,
                         verdict(within));
    };
    return {fmt::format("speed of crowds of {}, which was not tuned: {:.2f} times over {}, {}", drawn.character,
                        drawn.ratio, counted(drawn.times.size(), "seed", "seeds"),
                        held(promise.ratio_of_another, 2, proof.other->ratio_within)),
            fmt::format("score of its figures: {} {:.{}f} on average, {}", score.title, drawn.mean, score.digits,
                        held(promise.mean_of_another, score.digits, proof.other->mean_within)),
            fmt::format("score at the bad end's 5 % of them: {:.{}f}, {}", drawn.tail, score.digits,
                        held(promise.tail_of_another, score.digits, proof.other->tail_within))};
  }
  std::vector<std::string> out{
      fmt::format("speed: {} of {} within what was promised: {}", proof.speed.within,
                  counted(proof.speed.seeds.size(), "unseen seed", "unseen seeds"), verdict(proof.speed.holds)),
      fmt::format("score: {} of {} within what was promised: {}", proof.score.within,
                  counted(proof.score.seeds.size(), "unseen seed", "unseen seeds"), verdict(proof.score.holds))};
  for (const ErrorProof& one : proof.errors)
    out.push_back(fmt::format(
        "error{}: {} of {} unseen figures worse than promised (5 % may be), {} over the threshold; {} {:.{}f} at the "
        "bad end's 5 %, worst {:.{}f} at {:.1f} pixels: {}",
        proof.errors.size() > 1 ? " of " + report.request.subjects[one.subject].character->name : "", one.worse,
        one.views, one.over_threshold, score.title, one.tail, score.digits, one.worst, score.digits,
        one.worst_height_px, verdict(one.holds)));
  return out;
}

}  // namespace crowdbench::bench
