// Based on: Schuirmann, "A comparison of the two one-sided tests procedure and the power approach" (1987).
#include "studies/analysis/equivalence.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <vector>

#include "core/probability.h"
#include "studies/analysis/proportions.h"

namespace crowdbench::studies {
namespace {

constexpr double kMostTrials = 6000;  // searched one by one; above, the normal approximation is as good
constexpr uint64_t kMostParticipants = 100000;

Tost larger_of(double p_low, double p_upp) { return {p_low, p_upp, std::max(p_low, p_upp)}; }

// z of a distance; a variance of 0 leaves no doubt either way.
double standardised(double distance, double variance) {
  if (variance > 0) return distance / std::sqrt(variance);
  return distance == 0 ? 0 : std::copysign(HUGE_VAL, distance);
}

// The outcomes of which the exact test says "equivalent": from .. to, none where from > to.
struct Outcomes {
  uint64_t from = 1;
  uint64_t to = 0;
};
Outcomes equivalent_outcomes(uint64_t n, double low, double upp, double alpha) {
  const std::vector<double> at_low = binomial_probabilities(n, low);
  const std::vector<double> at_upp = binomial_probabilities(n, upp);
  Outcomes out{n + 1, 0};
  double tail = 0;
  for (uint64_t k = n + 1; k-- > 0 && (tail += at_low[k]) <= alpha;) out.from = k;
  tail = 0;
  uint64_t above = 0;  // one past the last
  for (uint64_t k = 0; k <= n && (tail += at_upp[k]) <= alpha; ++k) above = k + 1;
  if (above == 0 || out.from > above - 1) return {};
  out.to = above - 1;
  return out;
}

struct Moments {
  double mean = 0;
  double sd = 0;
};
Moments moments_of(std::span<const Share> shares) {
  Moments out;
  const auto n = static_cast<double>(shares.size());
  for (const Share& s : shares) out.mean += static_cast<double>(s.chosen) / static_cast<double>(s.of) / n;
  double squares = 0;
  for (const Share& s : shares) {
    const double d = static_cast<double>(s.chosen) / static_cast<double>(s.of) - out.mean;
    squares += d * d;
  }
  out.sd = shares.size() > 1 ? std::sqrt(squares / (n - 1)) : 0;
  return out;
}

// Participants whose t tests have the power, were the truth chance itself and their shares of that spread.
std::optional<uint64_t> participants_for(double sd, const EquivalenceSettings& s) {
  const auto enough = [&](uint64_t n) {
    const auto degrees = static_cast<double>(n - 1);
    const double reach = standardised(s.margin, sd * sd / static_cast<double>(n));
    return 2 * student_t_cdf(reach - student_t_quantile(1 - s.alpha, degrees), degrees) - 1 >= s.power;
  };
  uint64_t high = 2;
  while (!enough(high)) {
    high *= 2;
    if (high > kMostParticipants) return std::nullopt;
  }
  // Power grows with n.
  uint64_t low = high / 2;
  while (high - low > 1) {
    const uint64_t middle = (low + high) / 2;
    (enough(middle) ? high : low) = middle;
  }
  return high;
}

void test_participants(std::span<const Share> shares, const EquivalenceSettings& s, Equivalence& out) {
  const Moments m = moments_of(shares);
  out.mean = m.mean;
  if (shares.size() < 2) return;
  const auto n = static_cast<double>(shares.size());
  const double variance = m.sd * m.sd / n;
  const auto above = [&](double limit) { return 1 - student_t_cdf(standardised(m.mean - limit, variance), n - 1); };
  out.by_participant = larger_of(above(s.chance - s.margin), 1 - above(s.chance + s.margin));
  const double tail = above(s.chance);
  out.different_by_participant = std::min(1.0, 2 * std::min(tail, 1 - tail));
  const double half = student_t_quantile(1 - s.alpha, n - 1) * std::sqrt(variance);
  out.interval = Interval{std::max(0.0, m.mean - half), std::min(1.0, m.mean + half)};
  out.participant_sd = m.sd;
  out.participants_needed = participants_for(m.sd, s);
}

// Trials that the exact test needs, were the truth chance itself. The normal approximation says about where to look.
std::optional<uint64_t> trials_for(const EquivalenceSettings& s) {
  const double z = normal_quantile(1 - s.alpha) + normal_quantile((1 + s.power) / 2);
  const double about = s.chance * (1 - s.chance) * z * z / (s.margin * s.margin);
  if (about > kMostTrials) return static_cast<uint64_t>(std::ceil(about));
  return tost_sample_size(s.chance - s.margin, s.chance + s.margin, s.chance, s.alpha, s.power,
                          static_cast<uint64_t>(about * 1.2) + 40, static_cast<uint64_t>(about * 0.7) + 1)
      .always;
}

uint64_t missing(const std::optional<uint64_t>& needed, uint64_t have) {
  return needed && *needed > have ? *needed - have : 0;
}

}  // namespace

std::string_view verdict_text(Verdict verdict) {
  switch (verdict) {
    case Verdict::equivalent: return "equivalent";
    case Verdict::different: return "different";
    case Verdict::not_enough_data: break;
  }
  return "not enough data";
}

Tost tost_exact(uint64_t k, uint64_t n, double low, double upp) {
  return larger_of(binomial_at_least(k, n, low), binomial_at_most(k, n, upp));
}

Tost tost_score(uint64_t k, uint64_t n, double low, double upp) {
  const auto count = static_cast<double>(n);
  const double p = static_cast<double>(k) / count;
  return larger_of(normal_cdf(-standardised(p - low, low * (1 - low) / count)),
                   normal_cdf(standardised(p - upp, upp * (1 - upp) / count)));
}

Tost tost_wald(uint64_t k, uint64_t n, double low, double upp) {
  const auto count = static_cast<double>(n);
  const double p = static_cast<double>(k) / count;
  const double variance = p * (1 - p) / count;
  return larger_of(normal_cdf(-standardised(p - low, variance)), normal_cdf(standardised(p - upp, variance)));
}

double tost_power(uint64_t n, double low, double upp, double p_true, double alpha) {
  const Outcomes outcomes = equivalent_outcomes(n, low, upp, alpha);
  if (outcomes.from > outcomes.to) return 0;
  const std::vector<double> chances = binomial_probabilities(n, p_true);
  double sum = 0;
  for (uint64_t k = outcomes.from; k <= outcomes.to; ++k) sum += chances[k];
  return std::min(1.0, sum);
}

SampleSize tost_sample_size(double low, double upp, double p_true, double alpha, double power, uint64_t searched_to,
                            uint64_t searched_from) {
  SampleSize out;
  for (uint64_t n = searched_from; n <= searched_to; ++n) {
    if (tost_power(n, low, upp, p_true, alpha) < power) {
      out.always.reset();
      continue;
    }
    if (!out.first) out.first = n;
    if (!out.always) out.always = n;
  }
  return out;
}

Equivalence judge_equivalence(std::span<const Share> shares, const EquivalenceSettings& s) {
  assert(!shares.empty() && s.margin > 0 && s.chance - s.margin >= 0 && s.chance + s.margin <= 1);
  uint64_t chosen = 0;
  uint64_t of = 0;
  for (const Share& share : shares) {
    chosen += share.chosen;
    of += share.of;
  }
  const double low = s.chance - s.margin;
  const double upp = s.chance + s.margin;
  Equivalence out;
  out.exact = tost_exact(chosen, of, low, upp);
  out.different_exact = binomial_test(chosen, of, s.chance).two_sided;
  test_participants(shares, s, out);
  const bool inside = out.exact.p <= s.alpha && (!out.by_participant || out.by_participant->p <= s.alpha);
  const bool apart = out.different_exact <= s.alpha && out.different_by_participant.value_or(0) <= s.alpha;
  out.verdict = inside ? Verdict::equivalent : apart ? Verdict::different : Verdict::not_enough_data;
  out.trials_needed = trials_for(s);
  if (out.verdict == Verdict::not_enough_data) {
    out.more_trials = missing(out.trials_needed, of);
    out.more_participants = missing(out.participants_needed, shares.size());
  }
  return out;
}

}  // namespace crowdbench::studies
