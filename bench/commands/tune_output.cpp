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

std::string engines_text(const TuneReport& report, size_t subject, const TuneSwitch& one) {
  const EngineSizes engines = engines_in_report(report, subject, one.height_px);
  std::string text = fmt::format(
      "Unity {:.4f} of the screen's height at lodBias 1, Unreal screen size {:.4f}, Godot visibility range "
      "{:.2f} m",
      engines.unity_height, engines.unreal_size, engines.godot_metres);
  if (const auto pixels = godot_pixels_in_report(report, subject, one))
    text += fmt::format(", its mesh LOD threshold {:.2f} pixels", *pixels);
  return text;
}

void print_switch(const TuneReport& report, size_t subject, const TuneSwitch& one) {
  const metrics::Score& pop = *report.request.pop.score;
  fmt::print("from {:.1f} pixels ({:.1f} m) on {} instead of {}; {}\n", one.height_px,
             depth_in_report(report, subject, one.height_px), candidate_name(report, one.change.to),
             candidate_name(report, one.change.from), switch_certainty_text(report, one));
  if (one.hysteresis > 0)
    fmt::print("  hysteresis {:.1f} %: far below {:.1f} pixels, near again above {:.1f}\n", 100 * one.hysteresis,
               one.height_px / (1 + one.hysteresis), one.height_px * (1 + one.hysteresis));
  fmt::print("  the switch shows {} {:.{}f}; {}\n", pop.title, one.pop.tail, pop.digits,
             engines_text(report, subject, one));
  for (const PredictedSwitch& predicted : predicted_switches(report, subject, one.change.to, one.height_px))
    fmt::print("  {:.2f} pixels {}; {}\n", predicted.pixels, predicted.unit, predicted_text(report, predicted));
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
  for (const TuneSwitch& one : answer.switches) print_switch(report, subject, one);
  if (const auto curve = mesh_lod_in_report(report, subject, answer))
    fmt::print("Unity Mesh LOD of those levels: slope {:.3f}, bias {:.3f} at threshold 1\n", curve->slope, curve->bias);
  fmt::print("draws as: {}\n", tuned_representation(report.request, answer).text());
}

// Whether or not there is a rule: a rule of thumb is held beside what was measured.
void print_unchosen(const TuneReport& report, size_t subject, const TuneAnswer& answer) {
  for (const UnchosenCandidate& one : unchosen_candidates(report, subject, answer)) {
    fmt::print("{}\n", unchosen_text(report, subject, one));
    for (const PredictedSwitch& rule : one.rules) fmt::print("  {}\n", predicted_text(report, rule));
  }
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
  const std::vector<LensSpread> spreads = lens_spreads(report);
  fmt::print("720, 1080 and 2160 rows, 30 and 90 degrees, at the same pixels per degree: {}\n", lens_verdict(spreads));
  for (const LensSpread& spread : spreads) fmt::print("  {}\n", printable(lens_text(report, spread), 1000));
  for (const TuneLensCheck& one : *report.lenses)
    if (!one.holds && !one.skipped)
      fmt::print("  NOT through {:g} degrees on {} rows: {} at {:.1f} pixels, {} of {} views are worse than promised\n",
                 one.lens.fov_y_deg, one.lens.rows, candidate_name(report, one.candidate),
                 report.request.heights_px[one.bin], one.worse, one.views);
}

void print_proof(const TuneReport& report) {
  const TuneProof& proof = *report.proof;
  const metrics::Score& score = *report.request.error.score;
  fmt::print("proof: {}\n", proof.holds() ? "the promise holds" : "the promise does NOT hold");
  const std::vector<SeedTimes>& times = proof.other ? proof.other->drawn.times : proof.speed.seeds;
  const std::vector<SeedScores>& scores = proof.other ? proof.other->drawn.scores : proof.score.seeds;
  const Interval& fast = proof.other ? report.others->ratio_of_another : report.promise->on_another_seed;
  const Interval& good = proof.other ? report.others->mean_of_another : report.score_promise->on_another_seed;
  const auto range = [](const Interval& of, int digits) {
    return fmt::format("{:.{}f} to {:.{}f}", of.low, digits, of.high, digits);
  };
  fmt::print("{:>20} {:>12} {:>18} {:>12} {:>18} {:>13} {:>9}\n", "unseen seed", "times fast", "promised", score.column,
             "promised", "reference ms", "plan ms");
  for (size_t i = 0; i < times.size(); ++i)
    fmt::print("{:>20} {:>12.3f} {:>18} {:>12.{}f} {:>18} {:>13.2f} {:>9.2f}\n", times[i].seed, times[i].ratio,
               range(fast, 3), scores[i].mean, score.digits, range(good, score.digits), 1e-6 * times[i].reference_ns,
               1e-6 * times[i].plan_ns);
  for (const std::string& text : proof_texts(report)) fmt::print("  {}\n", printable(text, 1000));
}

}  // namespace

void print_tune(const TuneReport& report) {
  const TuneResult& result = report.result;
  const TuneAnswer& answer = result.together;
  if (report.proof && !report.proof->holds()) fmt::print("the promise below does NOT hold on what was not measured\n");
  fmt::print("times: {}\n", times_text(report));
  for (size_t s = 0; s < result.subjects.size(); ++s) {
    const size_t views = result.subjects[s].views;
    fmt::print("{}: {} at the bad end's 5 % of {} views and moments, threshold {:g}; time of one more agent; {}x{}\n",
               printable(report.request.subjects[s].character->name), report.request.error.score->title, views,
               report.request.error.value, report.request.cost.width, report.request.cost.height);
    if (const std::string few = few_views_text(views); !few.empty()) fmt::print("  {}\n", few);
    print_heights(report, s);
    print_noise(report, s);
    if (!result.alone.empty()) {
      fmt::print("{} by itself:\n", printable(report.request.subjects[s].character->name));
      print_answer(report, s, result.alone[s]);
    }
  }
  if (!result.alone.empty()) fmt::print("for all {} characters (metres of the first):\n", result.subjects.size());
  print_answer(report, 0, answer);
  print_unchosen(report, 0, answer);
  if (!answer.plan) return;
  if (agents_in_view(answer) > 0) fmt::print("{}\n", saving_text(answer));
  if (report.promise)
    fmt::print("{}\n{}\n{}\n", promise_text(*report.promise), score_promise_text(report),
               printable(others_promise_text(report), 1000));
  if (report.lenses) print_lenses(report);
  if (report.proof) print_proof(report);
}

}  // namespace crowdbench::bench
