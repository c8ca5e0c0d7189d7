#include "studies/analysis/power.h"

#include <cmath>
#include <vector>

#include "core/parallel.h"
#include "core/probability.h"
#include "core/random.h"
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

}  // namespace

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
    const MixedFit fit = fit_mixed(rows_of(s, random_bits(s.seed, i, 0)), model);
    all[i].state = fit.state;
    if (fit.fixed.size() == 2) all[i].effect = fit.fixed[1];
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
