#include "bench/experiments/tune_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "bench/experiments/tune_measure.h"
#include "core/counted.h"

namespace crowdbench::bench {
namespace {

const TuneError& error_of(const TuneReport& report, size_t subject, size_t candidate, size_t bin) {
  return report.result.subjects[subject].errors[candidate][bin];
}

// Change of the tail with the logarithm of the height, between the neighbours of a bin; 0 where there are none.
double slope_at(const TuneReport& report, const LensSpread& spread) {
  const std::vector<double>& heights = report.request.heights_px;
  const size_t near = spread.bin > 0 ? spread.bin - 1 : spread.bin;
  const size_t far = std::min(spread.bin + 1, heights.size() - 1);
  const TuneError& a = error_of(report, spread.subject, spread.candidate, near);
  const TuneError& b = error_of(report, spread.subject, spread.candidate, far);
  if (near == far || a.values.empty() || b.values.empty()) return 0;
  return (a.tail - b.tail) / std::log(heights[near] / heights[far]);
}

std::optional<Interval> as_heights(const TuneReport& report, const LensSpread& spread) {
  const std::vector<double>& heights = report.request.heights_px;
  const double slope = slope_at(report, spread);
  const double step = std::log(heights.front() / heights.back()) / static_cast<double>(heights.size() - 1);
  const double low = (spread.low - spread.tuned) / slope;
  const double high = (spread.high - spread.tuned) / slope;
  if (!std::isfinite(low) || !std::isfinite(high) || std::max(std::abs(low), std::abs(high)) > step)
    return std::nullopt;
  const double height = heights[spread.bin];
  return Interval{height * std::exp(std::min(low, high)), height * std::exp(std::max(low, high))};
}

bool is_reference_type(const renderers::Spec& spec) { return renderers::representation_type(spec.name).reference; }

}  // namespace

bool TuneProof::holds() const {
  if (other) return other->holds();
  return speed.holds && score.holds &&
         std::all_of(errors.begin(), errors.end(), [](const ErrorProof& one) { return one.holds; });
}

std::string why_no_others(const TuneReport& report) {
  const std::string why = no_promise_of_others(report.request);
  return why.empty() ? "nothing was measured for it" : why;
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

double agents_in_view(const TuneAnswer& answer) {
  double sum = 0;
  for (const double agents : answer.table.agents) sum += agents;
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

std::string times_text(const TuneReport& report) {
  return fmt::format(
      "{} time of {}{}, on {}", report.result.subjects[0].costs.clock, report.run.gl_renderer,
      report.run.software ? " (a software rasteriser: nothing here says how long a graphics card takes)" : "",
      report.run.cpu_model.value_or("a processor that the machine does not name"));
}

size_t mesh_switches(const TuneReport& report, const TuneAnswer& answer) {
  size_t count = 0;
  while (count < answer.switches.size() &&
         is_reference_type(report.request.candidates[answer.switches[count].change.from]) &&
         is_reference_type(report.request.candidates[answer.switches[count].change.to]))
    ++count;
  return count;
}

std::optional<MeshLodCurve> mesh_lod_in_report(const TuneReport& report, size_t subject, const TuneAnswer& answer) {
  const SwitchCostRequest& lens = report.request.cost;
  std::vector<double> diameters;
  for (size_t i = 0; i < mesh_switches(report, answer); ++i)
    diameters.push_back(sphere_pixels(report.bounds[subject],
                                      depth_in_report(report, subject, answer.switches[i].height_px), lens.height,
                                      lens.fov_y));
  return mesh_lod_curve(diameters);
}

std::optional<double> godot_pixels_in_report(const TuneReport& report, size_t subject, const TuneSwitch& one) {
  const SwitchCostRequest& lens = report.request.cost;
  const double error = report.predicted.empty() ? 0 : report.predicted[subject][one.change.to].error;
  if (!(error > 0)) return std::nullopt;
  return godot_threshold_pixels(error, report.bounds[subject], depth_in_report(report, subject, one.height_px),
                                lens.height, lens.fov_y);
}

std::vector<PredictedSwitch> predicted_switches(const TuneReport& report, size_t subject, size_t candidate,
                                                double switch_px) {
  std::vector<PredictedSwitch> out;
  if (report.predicted.empty()) return out;
  const TunePrediction& of = report.predicted[subject][candidate];
  const TuneMeasured& measured = report.result.subjects[subject];
  const TuneSubject& who = report.request.subjects[subject];
  const auto add = [&](const char* rule, const char* unit, double metres) {
    const std::optional<double> height = height_of_one_pixel(metres, who);
    if (!height) return;
    const size_t bin = bin_of_height(report.request.heights_px, *height);
    out.push_back({rule, unit, pixels_spanned(metres, who, switch_px), *height,
                   depth_in_report(report, subject, *height), &measured.errors[candidate][bin],
                   measured.table.cost[candidate][bin],
                   *height > report.request.heights_px.front() || *height < report.request.heights_px.back()});
  };
  add("one texel a pixel", "a texel", of.texel);
  add("an error of one pixel", "of error", of.error);
  return out;
}

std::vector<UnchosenCandidate> unchosen_candidates(const TuneReport& report, size_t subject, const TuneAnswer& answer) {
  std::vector<UnchosenCandidate> out;
  for (size_t c = 0; c < report.request.candidates.size(); ++c) {
    if (std::any_of(answer.switches.begin(), answer.switches.end(),
                    [&](const TuneSwitch& one) { return one.change.to == c; }))
      continue;
    UnchosenCandidate one{.candidate = c, .rules = {}, .kept_px = {}};
    for (size_t b = report.request.heights_px.size(); b-- > 0 && error_of(report, subject, c, b).allowed;)
      one.kept_px = report.request.heights_px[b];
    one.rules = predicted_switches(report, subject, c, one.kept_px.value_or(0));
    if (!one.rules.empty()) out.push_back(std::move(one));
  }
  return out;
}

std::vector<LensSpread> lens_spreads(const TuneReport& report) {
  std::vector<LensSpread> out;
  if (!report.lenses) return out;
  for (const TuneLensCheck& check : *report.lenses) {
    if (out.empty() || out.back().subject != check.subject || out.back().bin != check.bin) {
      out.push_back({.subject = check.subject, .bin = check.bin, .candidate = check.candidate});
      out.back().kept = out.back().within = true;
    }
    LensSpread& spread = out.back();
    if (check.skipped) {
      ++spread.skipped;
      continue;
    }
    const TuneError& error = error_of(report, check.subject, check.candidate, check.bin);
    spread.tuned = check.tuned_tail;
    spread.low = spread.conditions == 0 ? check.tail : std::min(spread.low, check.tail);
    spread.high = spread.conditions == 0 ? check.tail : std::max(spread.high, check.tail);
    spread.kept = spread.kept && check.holds;
    spread.within = spread.within && check.tail >= error.interval.low && check.tail <= error.interval.high;
    ++spread.conditions;
  }
  for (LensSpread& spread : out) {
    if (spread.conditions == 0) spread.kept = spread.within = false;
    if (spread.conditions > 0) spread.height_px = as_heights(report, spread);
  }
  return out;
}

}  // namespace crowdbench::bench
