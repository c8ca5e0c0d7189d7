#include "studies/analysis/power.h"

#include <cassert>
#include <cmath>
#include <optional>
#include <vector>

#include "core/parallel.h"
#include "core/probability.h"
#include "core/progress.h"
#include "core/random.h"
#include "core/statistics.h"
#include "studies/analysis/analysis_parts.h"
#include "studies/analysis/mixed_model.h"
#include "studies/analysis/simulated.h"

namespace crowdbench::studies {
namespace {

// One study: rows of counts by observer, clip and condition.
std::vector<MixedRow> rows_of(const PowerSettings& s, uint64_t seed) {
  enum Purpose : uint64_t { kParticipant = 1, kClip, kAnswer };
  std::vector<MixedRow> out;
  uint64_t trial = 0;
  for (uint32_t p = 0; p < s.participants; ++p)
    for (uint32_t c = 0; c < s.clips; ++c)
      for (const double x : {-0.5, 0.5}) {
        MixedRow row{.participant = p, .clip = c, .fixed = {1, x}, .of = s.repeats};
        const double chance =
            logistic_cdf(s.intercept + s.effect * x + s.participant_sd * random_normal(seed, p, kParticipant) +
                         s.clip_sd * random_normal(seed, c, kClip));
        for (uint32_t r = 0; r < s.repeats; ++r) row.yes += random_unit(seed, trial++, kAnswer) < chance ? 1 : 0;
        out.push_back(std::move(row));
      }
  return out;
}

// One study of so many participants is simulated.
void advance(Progress* progress, uint32_t participants) {
  if (progress != nullptr) progress->advance(participants);
}

double share_se(double share, double n) { return n > 0 ? std::sqrt(share * (1 - share) / n) : 0; }

// The planned mixed model of one simulated study.
std::optional<MixedThreshold> threshold_of(const ThresholdPowerSettings& s, uint64_t seed) {
  const Answers answers = simulate_answers(s.observers, s.design, seed);
  parts::Rows rows;
  for (const Answer& row : answers.rows) rows.push_back(&row);
  const auto models = parts::mixed_models(answers, rows, parts::groups_of(answers, rows, false), {}, s.analysis);
  return models.at(0).threshold;
}

bool is_called_equivalent(const EquivalencePowerSettings& s, double chance, uint64_t seed) {
  std::vector<Share> shares;
  for (uint32_t p = 0; p < s.participants; ++p) {
    Share share{0, s.trials};
    for (uint32_t t = 0; t < s.trials; ++t) share.chosen += random_unit(seed, t, p) < chance ? 1 : 0;
    shares.push_back(share);
  }
  return judge_equivalence(shares, s.equivalence).verdict == Verdict::equivalent;
}

}  // namespace

double true_threshold(const ThresholdPowerSettings& s) {
  const double reach = (s.analysis.curve.level - s.observers.guess) / (1 - s.observers.guess);
  assert(s.observers.lapse == 0 && reach > 0 && reach < 1);
  return s.observers.threshold + std::log(reach / (1 - reach)) / s.observers.slope;
}

ThresholdPower simulate_threshold_power(const ThresholdPowerSettings& s) {
  assert(s.analysis.random != RandomEffects::none);
  const double truth = true_threshold(s);
  std::vector<std::optional<MixedThreshold>> all(s.simulations);
  parallel_for(s.simulations, s.threads, [&](size_t i) {
    throw_if_interrupted();
    all[i] = threshold_of(s, random_bits(s.seed, i, 0));
    advance(s.progress, s.design.participants);
  });
  ThresholdPower out;
  std::vector<double> estimates;
  std::vector<double> widths;
  for (const auto& one : all) {
    if (!one) {
      ++out.failed;
      continue;
    }
    estimates.push_back(one->at);
    if (!one->interval) {
      ++out.open;
      continue;
    }
    ++out.closed;
    widths.push_back(one->interval->high - one->interval->low);
    out.held += one->interval->low <= truth && truth <= one->interval->high ? 1 : 0;
  }
  if (!estimates.empty()) {
    const auto n = static_cast<double>(estimates.size());
    double squares = 0;
    for (const double each : estimates) out.mean_estimate += each / n;
    for (const double each : estimates) squares += (each - out.mean_estimate) * (each - out.mean_estimate);
    out.sd_estimate = n > 1 ? std::sqrt(squares / (n - 1)) : 0;
  }
  if (widths.empty()) return out;
  const auto closed = static_cast<double>(out.closed);
  out.held /= closed;
  out.held_se = share_se(out.held, closed);
  out.median_width = median(widths);
  return out;
}

EquivalencePower simulate_equivalence_power(const EquivalencePowerSettings& s) {
  std::vector<uint8_t> equal(s.simulations);
  std::vector<uint8_t> apart(s.simulations);
  parallel_for(s.simulations, s.threads, [&](size_t i) {
    throw_if_interrupted();
    const uint64_t seed = random_bits(s.seed, i, 1);
    equal[i] = is_called_equivalent(s, s.equivalence.chance, seed) ? 1 : 0;
    apart[i] = is_called_equivalent(s, s.equivalence.chance + s.equivalence.margin, seed) ? 1 : 0;
    advance(s.progress, s.participants);
  });
  EquivalencePower out;
  for (size_t i = 0; i < s.simulations; ++i) {
    out.power += equal[i];
    out.at_margin += apart[i];
  }
  const auto n = static_cast<double>(s.simulations);
  out.power /= n;
  out.at_margin /= n;
  out.power_se = share_se(out.power, n);
  out.at_margin_se = share_se(out.at_margin, n);
  return out;
}

Power simulate_power(const PowerSettings& s) {
  struct One {
    MixedState state = MixedState::no_data;
    MixedEffect effect;
  };
  std::vector<One> all(s.simulations);
  // Standard errors given the variances: they cost little, and are what the expected values were made with.
  const MixedSettings model{
      .clips = s.clip_sd > 0, .integration = Integration::laplace, .full_errors = false, .thorough = false};
  parallel_for(s.simulations, s.threads, [&](size_t i) {
    throw_if_interrupted();
    const MixedFit fit = fit_mixed(rows_of(s, random_bits(s.seed, i, 0)), model);
    all[i].state = fit.state;
    if (fit.fixed.size() == 2) all[i].effect = fit.fixed[1];
    advance(s.progress, s.participants);
  });
  Power out;
  double squares = 0;
  double fitted = 0;
  double rejected = 0;
  for (const One& one : all) {
    if (one.state != MixedState::fitted && one.state != MixedState::singular) {
      ++out.failed;
      continue;
    }
    out.singular += one.state == MixedState::singular ? 1 : 0;
    rejected += one.effect.p <= s.alpha ? 1 : 0;
    fitted += 1;
    out.mean_estimate += one.effect.estimate;
    squares += one.effect.estimate * one.effect.estimate;
    out.mean_se += one.effect.se;
  }
  const auto n = static_cast<double>(s.simulations);
  out.power = rejected / n;
  out.power_se = std::sqrt(out.power * (1 - out.power) / n);
  if (fitted == 0) return out;
  out.mean_estimate /= fitted;
  out.mean_se /= fitted;
  out.sd_estimate =
      fitted > 1 ? std::sqrt(std::max(0.0, squares - fitted * out.mean_estimate * out.mean_estimate) / (fitted - 1))
                 : 0;
  out.interval_width = 2 * normal_quantile(0.975) * out.mean_se;
  return out;
}

}  // namespace crowdbench::studies
