#include "bench/experiments/tune_rows.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "bench/experiments/score_rows.h"
#include "bench/experiments/tune_measure.h"

namespace crowdbench::bench {
namespace {

std::string name_of(const TuneReport& report, size_t subject) {
  return report.request.subjects[subject].character->name;
}

std::string all_names(const TuneReport& report) {
  std::string out;
  for (size_t s = 0; s < report.request.subjects.size(); ++s) out += (s > 0 ? " + " : "") + name_of(report, s);
  return out;
}

void add_comparisons(const TuneReport& report, size_t subject, int64_t run, std::vector<ComparisonRow>& rows) {
  const TuneRequest& request = report.request;
  const TuneSubject& who = request.subjects[subject];
  const std::vector<QualityView> views = tune_views(request.blocks, who, request.seed);
  for (size_t c = 0; c < request.candidates.size(); ++c) {
    if (request.candidates[c].text() == renderers::reference_spec().text()) continue;
    for (size_t b = 0; b < request.heights_px.size(); ++b) {
      const TuneError& error = report.result.subjects[subject].errors[c][b];
      for (size_t i = 0; i < error.values.size(); ++i) {
        ComparisonRow& row = rows.emplace_back();
        row.run = run;
        row.kind = "agent";
        row.representation = candidate_name(report, c);
        row.reference = renderers::reference_spec().text();
        row.character = name_of(report, subject);
        row.height_px = request.heights_px[b];
        row.azimuth_deg = views[i].azimuth_deg;
        row.elevation_deg = views[i].elevation_deg;
        row.clip = who.clip < 0 ? "none" : who.character->clips[static_cast<size_t>(who.clip)].name;
        row.time = views[i].time;
        put_display(row, request.display);
        row.scores = {{std::string(request.error.score->name), error.values[i], ""}};
      }
    }
  }
}

TunedSwitchRow switch_row(const TuneReport& report, size_t subject, const TuneSwitch& one) {
  TunedSwitchRow row;
  row.from = candidate_name(report, one.change.from);
  row.to = candidate_name(report, one.change.to);
  row.height_px = one.height_px;
  if (one.certainty.height_px) {
    row.low_px = one.certainty.height_px->low;
    row.high_px = one.certainty.height_px->high;
  }
  row.share = one.certainty.share;
  row.decided = one.certainty.decided();
  row.depth = depth_in_report(report, subject, one.height_px);
  if (!report.predicted.empty()) {
    const TunePrediction& of = report.predicted[subject][one.change.to];
    const TuneSubject& who = report.request.subjects[subject];
    if (of.texel > 0) row.pixels_per_texel = pixels_spanned(of.texel, who, one.height_px);
    if (of.error > 0) row.pixels_per_error = pixels_spanned(of.error, who, one.height_px);
  }
  row.hysteresis = one.hysteresis;
  row.pop = one.pop.tail;
  return row;
}

TuningRow tuning_row(const TuneReport& report, size_t subject, const TuneAnswer& answer, int64_t run) {
  const TuneRequest& request = report.request;
  TuningRow row;
  row.run = run;
  row.character = name_of(report, subject);
  row.score = request.error.score->name;
  row.threshold = request.error.value;
  row.pop_score = request.pop.score->name;
  row.pop_threshold = request.pop.value;
  if (request.budget_ns > 0) row.budget_ns = request.budget_ns;
  row.agents = agents_in_view(answer);
  row.display = metrics::display_text(request.display);
  row.display_given = request.display.given;
  if (!answer.plan) {
    row.reason = no_plan_text(report, answer);
    return row;
  }
  row.representation = tuned_representation(request, answer).text();
  if (row.agents > 0) {
    row.saving = answer.reference_cost / std::max(answer.plan->cost, 1e-9);
    row.saving_low = answer.saving.low;
    row.saving_high = answer.saving.high;
  }
  for (const TuneSwitch& one : answer.switches) {
    row.switches.push_back(switch_row(report, subject, one));
    row.switches.back().place = static_cast<int>(row.switches.size()) - 1;
  }
  return row;
}

}  // namespace

StoreContents tune_rows(const TuneReport& report, int64_t run) {
  StoreContents rows;
  for (size_t s = 0; s < report.request.subjects.size(); ++s) add_comparisons(report, s, run, rows.comparisons);
  TuningRow all = tuning_row(report, 0, report.result.together, run);
  all.character = all_names(report);
  if (report.promise) {
    all.promised = report.promise->ratio;
    all.promised_low = report.promise->on_another_seed.low;
    all.promised_high = report.promise->on_another_seed.high;
  }
  if (report.lenses) {
    const std::vector<LensSpread> spreads = lens_spreads(report);
    all.lenses_hold = std::all_of(spreads.begin(), spreads.end(),
                                  [](const LensSpread& one) { return one.conditions == 0 || one.kept; });
  }
  if (report.proof) all.proof_holds = report.proof->holds();
  rows.tunings.push_back(std::move(all));
  for (size_t s = 0; s < report.result.alone.size(); ++s)
    rows.tunings.push_back(tuning_row(report, s, report.result.alone[s], run));
  return rows;
}

void write_tune_rows(StoreWriter& store, const StoreContents& rows) {
  store.begin();
  for (const ComparisonRow& row : rows.comparisons) store.write(row);
  for (const TuningRow& row : rows.tunings) store.write(row);
  store.commit();
}

}  // namespace crowdbench::bench
