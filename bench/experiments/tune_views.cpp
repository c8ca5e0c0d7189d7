#include "bench/experiments/tune_views.h"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "bench/experiments/tune_measure.h"
#include "core/probability.h"
#include "core/progress.h"

namespace crowdbench::bench {
namespace {

// The first bin of each stretch that one candidate other than the reference draws.
std::vector<size_t> bins_to_check(const TuneRequest& request, const SwitchPlan& plan) {
  std::vector<size_t> out;
  for (size_t b = 0; b < plan.candidate.size(); ++b)
    if ((b == 0 || plan.candidate[b] != plan.candidate[b - 1]) &&
        request.candidates[plan.candidate[b]].text() != renderers::reference_spec().text())
      out.push_back(b);
  return out;
}

// Fills in what is said of the scores; `first` those of the same views at the tuning's lens.
void judge(TuneLensCheck& check, const metrics::Score& score, double promised, const std::vector<double>& first,
           const std::vector<double>& values) {
  std::vector<double> bad;
  std::vector<double> tuned;
  double sum = 0;
  for (size_t i = 0; i < values.size(); ++i) {
    bad.push_back(badness_of(score, values[i]));
    tuned.push_back(badness_of(score, first[i]));
    if (bad.back() > badness_of(score, promised)) ++check.worse;
    const double difference = values[i] - first[i];
    sum += difference;
    if (std::abs(difference) > std::abs(check.largest_difference)) check.largest_difference = difference;
  }
  check.views = values.size();
  check.tail = value_of_badness(score, badness_tail(bad));
  check.tuned_tail = value_of_badness(score, badness_tail(tuned));
  check.mean_difference = sum / static_cast<double>(values.size());
  check.holds = binomial_at_least(check.worse, check.views, 0.05) >= 0.025;
}

}  // namespace

std::vector<TuneLens> usual_lenses() {
  std::vector<TuneLens> out;
  for (const int rows : {720, 1080, 2160})
    for (const double fov : {30.0, 90.0}) out.push_back({rows, fov});
  return out;
}

std::vector<TuneLensCheck> check_lenses(gl::Context& context, const TuneRequest& request, const TuneResult& result,
                                        const std::vector<TuneLens>& lenses, size_t views) {
  assert(result.together.plan);
  const metrics::Score* score = request.error.score;
  std::vector<TuneLensCheck> out;
  const std::vector<size_t> bins = bins_to_check(request, *result.together.plan);
  Progress progress("checking lenses", request.subjects.size() * bins.size() * lenses.size());
  for (size_t s = 0; s < request.subjects.size(); ++s) {
    const std::vector<QualityView> all = tune_views(request.blocks, request.subjects[s], request.seed);
    const size_t count = std::min(views, all.size());
    for (const size_t bin : bins) {
      const size_t candidate = result.together.plan->candidate[bin];
      const TuneError& error = result.subjects[s].errors[candidate][bin];
      for (const TuneLens& lens : lenses) {
        progress.advance();
        if (error.values.empty()) continue;
        QualitySetup setup;
        setup.character = request.subjects[s].character;
        setup.representations = {request.candidates[candidate].text()};
        setup.rows = lens.rows;
        if (quality_size(setup, request.heights_px[bin]).height != lens.rows) {
          out.push_back({.subject = s, .lens = lens, .bin = bin, .candidate = candidate, .skipped = true});
          continue;
        }
        setup.antialiasing = request.cost.antialiasing;
        setup.bake_budget = request.cost.bake_budget;
        setup.use_cache = request.cost.use_cache;
        setup.display = request.display;
        setup.table = {&score, 1};
        std::vector<double> first;
        for (size_t i = 0; i < count; ++i) {
          const size_t block = i * all.size() / count;
          QualityView view = all[block];
          view.height_px = request.heights_px[bin];
          view.fov_y_deg = lens.fov_y_deg;
          setup.views.push_back(view);
          first.push_back(error.values[block]);
        }
        std::vector<double> values;
        for (const QualityRow& row : compute_quality(context, setup))
          values.push_back(row.scores.value(score->name).value_or(error.promised));
        TuneLensCheck check{.subject = s, .lens = lens, .bin = bin, .candidate = candidate};
        judge(check, *score, error.promised, first, values);
        out.push_back(check);
      }
    }
  }
  return out;
}

}  // namespace crowdbench::bench
