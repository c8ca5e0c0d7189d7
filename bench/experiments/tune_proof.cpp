#include "bench/experiments/tune_proof.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <numbers>

#include "bench/experiments/tune_measure.h"
#include "bench/stage/stage.h"
#include "bench/timing/timed_representation.h"
#include "bench/timing/timing_method.h"
#include "core/error.h"
#include "core/probability.h"
#include "core/progress.h"
#include "core/random.h"

namespace crowdbench::bench {
namespace {

enum ProofPurpose : uint64_t {
  kPromiseSeed = 101,
  kProofSeed,
  kAzimuth,
  kElevation,
  kTime,
  kPromisedRadius,
  kPromisedAngle,
  kCharacterSeed
};

// At least two values.
double sample_variance(const std::vector<double>& values) {
  double sum = 0;
  for (const double one : values) sum += one;
  const double mean = sum / static_cast<double>(values.size());
  double squares = 0;
  for (const double one : values) squares += (one - mean) * (one - mean);
  return squares / static_cast<double>(values.size() - 1);
}

// Unseen figures: everything drawn at random, heights in even steps so that every bin has its part.
std::vector<QualityView> unseen_views(const TuneRequest& request, const TuneSubject& subject, size_t views,
                                      uint64_t seed) {
  const TuneBlocks& blocks = request.blocks;
  double low = blocks.lowest_deg;
  double high = blocks.highest_deg;
  if (!blocks.elevations_deg.empty()) {
    low = *std::min_element(blocks.elevations_deg.begin(), blocks.elevations_deg.end());
    high = *std::max_element(blocks.elevations_deg.begin(), blocks.elevations_deg.end());
  }
  const double nearest = request.heights_px.front();
  const double farthest = request.heights_px.back();
  const Moments moments(subject);
  std::vector<QualityView> out;
  for (size_t i = 0; i < views; ++i) {
    QualityView view;
    const double along = (static_cast<double>(i) + 0.5) / static_cast<double>(views);
    view.height_px = nearest * std::pow(farthest / nearest, along);
    view.azimuth_deg = 360 * random_unit(seed, i, kAzimuth);
    view.elevation_deg = low + (high - low) * random_unit(seed, i, kElevation);
    view.clip = subject.clip;
    // Each at a moment of its own: figures of one moment err alike, and are not so many independent ones.
    view.time = moments.time(random_unit(seed, i, kTime));
    out.push_back(view);
  }
  return out;
}

SeedTimes times_of(gl::Context& context, const TuneProofRequest& request, uint64_t seed, const TimingMethod& method) {
  scene::Scenario scenario = request.scenario;
  scenario.seed = seed;
  const Staged staged = stage_scenario(scenario, *request.cast, context);
  Stage stage(context, *request.cast);
  stage.show(staged);
  TimedRepresentation reference(stage, renderers::reference_spec(), staged.scenario, request.bake_budget);
  TimedRepresentation plan(stage, request.representation, staged.scenario, request.bake_budget);
  TimingPlan timing;
  timing.rounds = timing.least_rounds = request.rounds;
  timing.metric = method.headline;
  timing.order_seed = seed;
  const std::vector<Variant> variants{reference.variant(), plan.variant()};
  const std::vector<VariantTimes> times = time_interleaved(
      variants, timing, system_clocks(), gpu_timer_of(context, method), [] { throw_if_interrupted(); });
  SeedTimes out;
  out.seed = seed;
  out.reference_ns = median(values_of(times[0].samples, method.headline));
  out.plan_ns = median(values_of(times[1].samples, method.headline));
  if (const auto ratio = paired_ratio(times[0].samples, times[1].samples, method.headline, kBootstrapSeed)) {
    out.ratio = ratio->median;
    out.interval = ratio->interval;
  }
  return out;
}

// Half of a prediction interval from so many values, in their standard deviation, known with so many degrees of
// freedom.
double interval_reach(size_t values, double degrees) {
  return student_t_quantile(0.975, degrees) * std::sqrt(1 + 1 / static_cast<double>(values));
}

// The variance of the mean over a seed's figures, and its degrees of freedom; 0 of those where no place has two.
struct MeanVariance {
  double variance = 0, degrees = 0;
};
MeanVariance variance_of_means(const std::vector<SeedScores>& seeds) {
  size_t most = 0;
  for (const SeedScores& one : seeds) most = std::max(most, one.by_place.size());
  double sum = 0;      // of the places' variances
  double squares = 0;  // of them, each over its degrees of freedom
  size_t places = 0;
  size_t tallied = 0;  // places with a score on any seed
  for (size_t p = 0; p < most; ++p) {
    std::vector<double> values;
    for (const SeedScores& one : seeds)
      if (p < one.by_place.size() && !std::isnan(one.by_place[p])) values.push_back(one.by_place[p]);
    tallied += values.empty() ? 0 : 1;
    if (values.size() < 2) continue;
    const double variance = sample_variance(values);
    ++places;
    sum += variance;
    squares += variance * variance / static_cast<double>(values.size() - 1);
  }
  if (places == 0) return {};
  MeanVariance out;
  out.variance = sum / static_cast<double>(places) / static_cast<double>(tallied);
  out.degrees = squares > 0 ? sum * sum / squares : static_cast<double>(places * (seeds.size() - 1));
  return out;
}

// Based on: G. E. P. Box and M. E. Muller, "A note on the generation of random normal deviates", 1958.
double random_normal(uint64_t index) {
  const double radius = std::sqrt(-2 * std::log(1 - random_unit(1, index, kPromisedRadius)));
  return radius * std::cos(2 * std::numbers::pi * random_unit(1, index, kPromisedAngle));
}

}  // namespace

std::vector<uint64_t> derived_seeds(uint64_t seed, SeedsFor purpose, size_t count) {
  std::vector<uint64_t> out;
  const uint64_t which = purpose == SeedsFor::promise ? kPromiseSeed
                         : purpose == SeedsFor::proof ? kProofSeed
                                                      : kCharacterSeed;
  // Below 2^53, so that any program can write and read them.
  for (size_t i = 0; i < count; ++i) out.push_back(random_below(seed, i, which, uint64_t{1} << 53));
  return out;
}

std::vector<SeedTimes> time_seeds(gl::Context& context, const TuneProofRequest& request,
                                  const std::vector<uint64_t>& seeds) {
  assert(!request.scenario.occupancy);
  const TimingMethod method = choose_timing_method(context);
  std::vector<SeedTimes> out;
  Progress progress("timing crowds", seeds.size());
  for (const uint64_t seed : seeds) {
    out.push_back(times_of(context, request, seed, method));
    progress.advance();
  }
  return out;
}

bool lies_within(const Interval& interval, double value) {
  // Means of equal values may differ in their last digits.
  const double slack = std::isfinite(value) ? 1e-9 * std::abs(value) : 0;
  return value >= interval.low - slack && value <= interval.high + slack;
}

double rounds_variance(const std::vector<SeedTimes>& seeds) {
  double sum = 0;
  for (const SeedTimes& one : seeds) {
    if (!(one.interval.low > 0)) continue;
    const double deviation = std::log(one.interval.high / one.interval.low) / (2 * normal_quantile(0.975));
    sum += deviation * deviation;
  }
  return seeds.empty() ? 0 : sum / static_cast<double>(seeds.size());
}

Interval prediction_interval(const std::vector<double>& values, double least_variance) {
  assert(values.size() >= 2);
  const bool same = std::all_of(values.begin(), values.end(), [&](double one) { return one == values[0]; });
  if (same && !(least_variance > 0)) return {values[0], values[0]};
  if (!std::all_of(values.begin(), values.end(), [](double one) { return std::isfinite(one); }))
    return {-std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity()};
  const auto n = static_cast<double>(values.size());
  double sum = 0;
  for (const double one : values) sum += one;
  const double half =
      interval_reach(values.size(), n - 1) * std::sqrt(std::max(sample_variance(values), least_variance));
  return {sum / n - half, sum / n + half};
}

SpeedPromise promised_speed(std::vector<SeedTimes> seeds) {
  std::vector<double> logarithms;
  std::vector<double> plans;
  double sum = 0;
  for (const SeedTimes& one : seeds) {
    logarithms.push_back(std::log(one.ratio));
    sum += logarithms.back();
    plans.push_back(one.plan_ns);
  }
  const Interval interval = prediction_interval(logarithms, rounds_variance(seeds));
  SpeedPromise out;
  out.seeds = std::move(seeds);
  out.ratio = std::exp(sum / static_cast<double>(logarithms.size()));
  out.on_another_seed = {std::exp(interval.low), std::exp(interval.high)};
  out.plan_ns = median(plans);
  return out;
}

double chance_of_so_few(size_t within, size_t unseen, size_t promised, double degrees) {
  assert(promised >= 2 && degrees > 0);
  constexpr size_t kPromises = 10'000;
  constexpr double kMany = 200;  // of more degrees the law is hardly another one
  const auto squared = std::max<size_t>(1, static_cast<size_t>(std::lround(std::min(degrees, kMany))));
  const double reach = interval_reach(promised, static_cast<double>(squared));
  double chance = 0;
  size_t draw = 0;
  for (size_t i = 0; i < kPromises; ++i) {
    const double mean = random_normal(draw++) / std::sqrt(static_cast<double>(promised));
    double squares = 0;
    for (size_t k = 0; k < squared; ++k) {
      const double value = random_normal(draw++);
      squares += value * value;
    }
    const double half = reach * std::sqrt(squares / static_cast<double>(squared));
    // Given the interval the unseen ones are independent.
    chance += binomial_at_most(within, unseen, normal_cdf(mean + half) - normal_cdf(mean - half));
  }
  return chance / kPromises;
}

SpeedProof prove_speed(const SpeedPromise& promise, std::vector<SeedTimes> unseen) {
  SpeedProof out;
  out.seeds = std::move(unseen);
  for (const SeedTimes& one : out.seeds) out.within += lies_within(promise.on_another_seed, one.ratio);
  const size_t promised = promise.seeds.size();
  out.holds = chance_of_so_few(out.within, out.seeds.size(), promised, static_cast<double>(promised - 1)) >= 0.025;
  return out;
}

std::vector<UnseenFigure> draw_unseen(gl::Context& context, const TuneRequest& request, const TuneSubject& subject,
                                      const renderers::Spec& representation, size_t count, uint64_t seed) {
  const metrics::Score* score = request.error.score;
  QualitySetup setup;
  setup.character = subject.character;
  setup.representations = {representation.text()};
  setup.views = unseen_views(request, subject, count, seed);
  setup.antialiasing = request.cost.antialiasing;
  setup.bake_budget = request.cost.bake_budget;
  setup.use_cache = request.cost.use_cache;
  setup.display = request.display;
  setup.table = {&score, 1};
  std::vector<UnseenFigure> out;
  const std::vector<QualityRow> rows = compute_quality(context, setup);
  for (size_t i = 0; i < rows.size(); ++i) {
    if (!rows[i].refused.empty()) throw Error("tune", rows[i].refused, "");
    if (const auto value = rows[i].scores.value(score->name)) out.push_back({i, rows[i].view.height_px, *value});
  }
  return out;
}

SeedScores scores_of(const metrics::Score& score, uint64_t seed, const std::vector<UnseenFigure>& figures) {
  SeedScores out;
  out.seed = seed;
  out.figures = figures.size();
  if (figures.empty()) return out;
  std::vector<double> bad;
  double sum = 0;
  for (const UnseenFigure& one : figures) {
    bad.push_back(badness_of(score, one.value));
    sum += bad.back();
    if (out.by_place.size() <= one.place) out.by_place.resize(one.place + 1, std::numeric_limits<double>::quiet_NaN());
    out.by_place[one.place] = one.value;
  }
  out.mean = value_of_badness(score, sum / static_cast<double>(bad.size()));
  out.tail = value_of_badness(score, badness_tail(bad));
  return out;
}

Interval within_range(const metrics::Score& score, Interval interval) {
  const double best = metrics::best_value(score);
  return score.direction == metrics::Direction::higher_is_better
             ? Interval{std::min(interval.low, best), std::min(interval.high, best)}
             : Interval{std::max(interval.low, best), std::max(interval.high, best)};
}

ScorePromise promised_score(const metrics::Score& score, std::vector<SeedScores> seeds) {
  std::vector<double> means;
  double sum = 0;
  for (const SeedScores& one : seeds) {
    means.push_back(one.mean);
    sum += one.mean;
  }
  ScorePromise out;
  out.mean = sum / static_cast<double>(means.size());
  const MeanVariance of = variance_of_means(seeds);
  Interval interval = prediction_interval(means);
  out.degrees = static_cast<double>(means.size() - 1);
  if (of.degrees > 0 && std::isfinite(of.variance) && std::isfinite(out.mean)) {
    out.degrees = of.degrees;
    const double half = interval_reach(means.size(), of.degrees) * std::sqrt(of.variance);
    interval = {out.mean - half, out.mean + half};
  }
  out.on_another_seed = within_range(score, interval);
  out.seeds = std::move(seeds);
  return out;
}

ScoreProof prove_score(const ScorePromise& promise, std::vector<SeedScores> unseen) {
  ScoreProof out;
  out.seeds = std::move(unseen);
  for (const SeedScores& one : out.seeds) out.within += lies_within(promise.on_another_seed, one.mean);
  out.holds = chance_of_so_few(out.within, out.seeds.size(), promise.seeds.size(), promise.degrees) >= 0.025;
  return out;
}

ErrorProof prove_errors(const TuneRequest& request, const TuneResult& result, size_t subject,
                        const std::vector<UnseenFigure>& figures) {
  assert(result.together.plan);
  const metrics::Score& score = *request.error.score;
  ErrorProof out;
  out.subject = subject;
  out.views = figures.size();
  if (figures.empty()) return out;
  out.worst = figures[0].value;
  out.worst_height_px = figures[0].height_px;
  std::vector<double> bad;
  for (const UnseenFigure& one : figures) {
    const size_t bin = bin_of_height(request.heights_px, one.height_px);
    const TuneError& error = result.subjects[subject].errors[result.together.plan->candidate[bin]][bin];
    bad.push_back(badness_of(score, one.value));
    if (bad.back() > badness_of(score, error.promised)) ++out.worse;
    if (bad.back() > badness_of(score, request.error.value)) ++out.over_threshold;
    if (bad.back() > badness_of(score, out.worst)) {
      out.worst = one.value;
      out.worst_height_px = one.height_px;
    }
  }
  out.tail = value_of_badness(score, badness_tail(bad));
  out.holds = binomial_at_least(out.worse, out.views, 0.05) >= 0.025;
  return out;
}

}  // namespace crowdbench::bench
