#include "studies/analysis/simulated.h"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numeric>

#include "core/probability.h"
#include "core/random.h"

namespace crowdbench::studies {
namespace {

enum Purpose : uint64_t { kThreshold = 1, kSlope, kClip, kOrder, kAnswer, kWorth, kChoice };

// One observer's trials, as numbers of (level, clip, repeat), in the order in which they come.
std::vector<uint32_t> order_of(uint32_t trials, uint64_t seed) {
  std::vector<uint32_t> out(trials);
  std::iota(out.begin(), out.end(), 0U);
  for (uint32_t i = trials; i > 1; --i) std::swap(out[i - 1], out[random_below(seed, i, kOrder, i)]);
  return out;
}

}  // namespace

double random_normal(uint64_t seed, uint64_t index, uint64_t purpose) {
  return normal_quantile(random_unit(seed, index, purpose) + 0x1.0p-54);
}

double biased_guess(double guess, double lapse, double bias) {
  if (guess <= 0 || guess >= 1 || bias == 0) return guess;
  return std::min(1 - lapse, logistic_cdf(std::log(guess / (1 - guess)) + bias));
}

Answers simulate_answers(const SimulatedObservers& o, const SimulatedDesign& design, uint64_t seed) {
  assert(!design.levels.empty() && design.clips > 0);
  Answers out;
  out.sources = {"simulated"};
  for (uint32_t c = 0; c < design.clips; ++c) out.clips.push_back(fmt::format("clip {}", c + 1));
  const auto levels = static_cast<uint32_t>(design.levels.size());
  const uint32_t trials = levels * design.clips * design.repeats;
  for (uint32_t p = 0; p < design.participants; ++p) {
    out.participants.push_back(fmt::format("simulated {}", p + 1));
    const uint64_t own = random_bits(seed, p, kAnswer);
    const double threshold = o.threshold + o.threshold_sd * random_normal(own, 0, kThreshold);
    const double slope = o.slope * std::exp(o.slope_log_sd * random_normal(own, 0, kSlope));
    const std::vector<uint32_t> order = order_of(trials, own);
    for (uint32_t t = 0; t < trials; ++t) {
      const uint32_t level = order[t] % levels;
      const uint32_t clip = order[t] / levels % design.clips;
      const bool first = order[t] / levels / design.clips % 2 == 0;
      const double done = (t + 0.5) / trials;
      const double bias = first ? o.side_bias : -o.side_bias;
      const double eta = slope * (design.levels[level] - threshold) + o.clip_sd * random_normal(seed, clip, kClip) +
                         o.learning * (done - 0.5) + bias;
      const double guess = biased_guess(o.guess, o.lapse, bias);
      const double chance = guess + (1 - guess - o.lapse) * logistic_cdf(eta);
      Answer row;
      row.line = out.rows.size() + 2;
      row.participant = p;
      row.simulated = true;
      row.yes_first = first;
      row.clip = clip;
      row.level = design.levels[level];
      row.trial = fmt::format("{}", t + 1);
      const bool yes = random_unit(own, t, kChoice) < chance;
      row.yes = yes ? 1 : 0;
      row.no = yes ? 0 : 1;
      out.rows.push_back(std::move(row));
    }
  }
  return out;
}

std::string answers_csv(const Answers& answers) {
  std::string out = "observers,participant,trial,clip,level,yes_first,answer\n";
  for (const Answer& row : answers.rows)
    out += fmt::format("simulated,{},{},{},{},{},{}\n", answers.participants[*row.participant], row.trial,
                       answers.clips[*row.clip], *row.level, *row.yes_first ? 1 : 0, row.yes > 0 ? "yes" : "no");
  return out;
}

std::vector<Comparison> simulate_comparisons(const SimulatedRanking& ranking, uint32_t participants, uint32_t repeats,
                                             uint64_t seed) {
  const auto items = static_cast<uint32_t>(ranking.log_worth.size());
  std::vector<Comparison> out;
  for (uint32_t p = 0; p < participants; ++p) {
    const uint64_t own = random_bits(seed, p, kWorth);
    std::vector<double> worth = ranking.log_worth;
    for (uint32_t i = 0; i < items; ++i) worth[i] += ranking.worth_sd * random_normal(own, i, kWorth);
    uint64_t trial = 0;
    for (uint32_t a = 0; a < items; ++a)
      for (uint32_t b = a + 1; b < items; ++b)
        for (uint32_t r = 0; r < repeats; ++r, ++trial) {
          Comparison c{.a = a, .b = b, .a_is_first = (r + p) % 2 == 0};
          const double win_a = std::exp(worth[a] + (*c.a_is_first ? ranking.position : 0));
          const double win_b = std::exp(worth[b] + (*c.a_is_first ? 0 : ranking.position));
          const double tie = std::exp(ranking.log_nu + (worth[a] + worth[b]) / 2);
          const double u = random_unit(own, trial, kChoice) * (win_a + win_b + tie);
          (u < win_a ? c.a_wins : u < win_a + win_b ? c.b_wins : c.ties) = 1;
          out.push_back(c);
        }
  }
  return out;
}

}  // namespace crowdbench::studies
