// Based on: Schuirmann, "A comparison of the two one-sided tests procedure and the power approach" (1987); Miettinen
// and Nurminen, "Comparative analysis of two rates" (1985), in the closed form of Farrington and Manning (1990).
#include "studies/analysis/equivalence.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numbers>
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
Moments moments_of(std::span<const double> values) {
  Moments out;
  const auto n = static_cast<double>(values.size());
  for (const double v : values) out.mean += v / n;
  double squares = 0;
  for (const double v : values) squares += (v - out.mean) * (v - out.mean);
  out.sd = values.size() > 1 ? std::sqrt(squares / (n - 1)) : 0;
  return out;
}

double share_of(const Share& s) { return static_cast<double>(s.chosen) / static_cast<double>(s.of); }

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

// t tests of participants' values, two or more, against `centre`. Fills the members that both results have.
template <typename Result>
void test_participants(std::span<const double> values, double centre, const EquivalenceSettings& s, Result& out) {
  const Moments m = moments_of(values);
  const auto n = static_cast<double>(values.size());
  const double variance = m.sd * m.sd / n;
  const auto above = [&](double limit) { return 1 - student_t_cdf(standardised(m.mean - limit, variance), n - 1); };
  out.by_participant = larger_of(above(centre - s.margin), 1 - above(centre + s.margin));
  const double tail = above(centre);
  out.different_by_participant = std::min(1.0, 2 * std::min(tail, 1 - tail));
  const double half = student_t_quantile(1 - s.alpha, n - 1) * std::sqrt(variance);
  out.interval = Interval{m.mean - half, m.mean + half};
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

// ---- two conditions

struct TwoShares {
  double n1 = 0, n2 = 0;
  double p1 = 0, p2 = 0;
};

// The share of the first condition that is likeliest where it exceeds the second's by `difference`: a root of a cubic.
double likeliest_first(const TwoShares& s, double difference) {
  const double ratio = s.n2 / s.n1;
  const double a = 1 + ratio;
  const double b = -(1 + ratio + s.p1 + ratio * s.p2 + difference * (ratio + 2));
  const double c = difference * difference + difference * (2 * s.p1 + ratio + 1) + s.p1 + ratio * s.p2;
  const double d = -s.p1 * difference * (1 + difference);
  const double third = b / (3 * a);
  const double v = third * third * third - b * c / (6 * a * a) + d / (2 * a);
  const double u = std::copysign(std::sqrt(std::max(0.0, third * third - c / (3 * a))), v);
  const double turn = u == 0 ? 1 : std::clamp(v / (u * u * u), -1.0, 1.0);
  const double angle = (std::numbers::pi + std::acos(turn)) / 3;
  return std::clamp(2 * u * std::cos(angle) - third, std::max(0.0, difference), std::min(1.0, 1 + difference));
}

// z of the difference against a limit, with the variance at that limit.
double score_z(const TwoShares& s, double limit) {
  const double p1 = likeliest_first(s, limit);
  const double p2 = p1 - limit;
  const double variance = (p1 * (1 - p1) / s.n1 + p2 * (1 - p2) / s.n2) * (s.n1 + s.n2) / (s.n1 + s.n2 - 1);
  return standardised(s.p1 - s.p2 - limit, std::max(0.0, variance));
}

// Trials of either condition (Chow, Shao and Wang 2008, section 4.2), were the shares equal.
std::optional<uint64_t> trials_for_difference(double share, const EquivalenceSettings& s) {
  const double z = normal_quantile(1 - s.alpha) + normal_quantile((1 + s.power) / 2);
  return static_cast<uint64_t>(std::ceil(2 * share * (1 - share) * z * z / (s.margin * s.margin)));
}

}  // namespace

uint64_t still_needed(const std::optional<uint64_t>& needed, uint64_t have) {
  return needed && *needed > have ? *needed - have : 0;
}

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
  std::vector<double> each;
  for (const Share& share : shares) each.push_back(share_of(share));
  out.mean = moments_of(each).mean;
  if (each.size() > 1) {
    test_participants<Equivalence>(each, s.chance, s, out);
    // Of participants who differ less than their own trials would scatter, the spread between them is luck.
    const Interval trials = clopper_pearson(chosen, of, 1 - 2 * s.alpha);
    out.interval = Interval{std::max(0.0, std::min(out.interval->low, trials.low)),
                            std::min(1.0, std::max(out.interval->high, trials.high))};
  }
  const bool inside = out.exact.p <= s.alpha && (!out.by_participant || out.by_participant->p <= s.alpha);
  const bool apart = out.different_exact <= s.alpha && out.different_by_participant.value_or(0) <= s.alpha;
  out.verdict = inside ? Verdict::equivalent : apart ? Verdict::different : Verdict::not_enough_data;
  out.trials_needed = trials_for(s);
  if (out.verdict == Verdict::not_enough_data) {
    out.more_trials = still_needed(out.trials_needed, of);
    out.more_participants = still_needed(out.participants_needed, shares.size());
  }
  return out;
}

Tost tost_difference(uint64_t k1, uint64_t n1, uint64_t k2, uint64_t n2, double margin, DifferenceMethod method) {
  const double more = method == DifferenceMethod::agresti_caffo ? 1 : 0;
  TwoShares s{static_cast<double>(n1) + 2 * more, static_cast<double>(n2) + 2 * more};
  s.p1 = (static_cast<double>(k1) + more) / s.n1;
  s.p2 = (static_cast<double>(k2) + more) / s.n2;
  if (method == DifferenceMethod::score)
    return larger_of(normal_cdf(-score_z(s, -margin)), normal_cdf(score_z(s, margin)));
  const double variance = s.p1 * (1 - s.p1) / s.n1 + s.p2 * (1 - s.p2) / s.n2;
  const double difference = s.p1 - s.p2;
  return larger_of(normal_cdf(-standardised(difference + margin, variance)),
                   normal_cdf(standardised(difference - margin, variance)));
}

DifferenceEquivalence judge_difference(std::span<const SharePair> pairs, bool known, const EquivalenceSettings& s) {
  Share first;
  Share second;
  std::vector<double> each;
  for (const SharePair& pair : pairs) {
    first = {first.chosen + pair.first.chosen, first.of + pair.first.of};
    second = {second.chosen + pair.second.chosen, second.of + pair.second.of};
    if (pair.first.of > 0 && pair.second.of > 0) each.push_back(share_of(pair.first) - share_of(pair.second));
  }
  assert(first.of > 0 && second.of > 0 && s.margin > 0 && s.margin < 1);
  DifferenceEquivalence out;
  out.difference = share_of(first) - share_of(second);
  out.score = tost_difference(first.chosen, first.of, second.chosen, second.of, s.margin, DifferenceMethod::score);
  const TwoShares shares{static_cast<double>(first.of), static_cast<double>(second.of), share_of(first),
                         share_of(second)};
  out.different_score = two_sided_normal_p(score_z(shares, 0));
  out.participants = known ? each.size() : 0;
  if (out.participants > 1) test_participants<DifferenceEquivalence>(each, 0, s, out);
  const bool inside = out.score.p <= s.alpha && (!out.by_participant || out.by_participant->p <= s.alpha);
  const bool apart = out.different_score <= s.alpha && out.different_by_participant.value_or(0) <= s.alpha;
  // The trials of one participant, or of others in either condition, say too little where participants are known.
  const bool enough = !known || out.participants > 1;
  if (enough) out.verdict = inside ? Verdict::equivalent : apart ? Verdict::different : Verdict::not_enough_data;
  const auto all = static_cast<double>(first.of + second.of);
  out.trials_needed = trials_for_difference((static_cast<double>(first.chosen + second.chosen) + 1) / (all + 2), s);
  if (out.verdict == Verdict::not_enough_data) {
    out.more_trials = still_needed(out.trials_needed, std::min(first.of, second.of));
    out.more_participants = still_needed(out.participants_needed, out.participants);
    if (!enough) out.more_participants = std::max<uint64_t>(2 - out.participants, out.more_participants);
  }
  return out;
}

}  // namespace crowdbench::studies
