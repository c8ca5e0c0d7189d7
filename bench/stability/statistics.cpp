// Metrics and statistics where they have least, or most, to go by: each with its stated result.
#include "core/statistics.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "bench/stability/fixture.h"
#include "core/error.h"
#include "core/hodges_lehmann.h"
#include "core/random.h"
#include "core/rank_correlation.h"
#include "core/rank_tests.h"
#include "metrics/registry.h"
#include "studies/analysis/paired_comparison.h"
#include "studies/analysis/proportions.h"
#include "studies/analysis/psychometric.h"

namespace crowdbench::bench {
namespace {

// Statements that do not hold, and the first of them.
struct Statements {
  Found found;
  int made = 0;
  Statements() { found.measured = 0; }
  void state(bool holds, const std::string& place, const std::string& expected, const std::string& got) {
    ++made;
    if (holds) return;
    if (found.measured == 0) {
      found.place = place;
      found.expected = expected;
      found.got = got;
    }
    found.measured += 1;
  }
  void equal(const std::string& place, double expected, double got) {
    state(expected == got, place, fmt::format("{}", expected), fmt::format("{}", got));
  }
  Found end() {
    found.note = fmt::format("{} statements", made);
    return found;
  }
};

// Two pictures with all that a score may ask for.
struct Pair {
  Image8 a, b;
  ImageF linear_a, linear_b, depth;
  ImageU32 ids;
  metrics::Mask region;

  Pair(int width, int height)
      : a(width, height, 4),
        b(a),
        linear_a(width, height, 4),
        linear_b(linear_a),
        depth(width, height, 1),
        ids(width, height, 1),
        region(width, height, 1) {
    std::fill(depth.data.begin(), depth.data.end(), 2.0F);
    std::fill(ids.data.begin(), ids.data.end(), 1U);
    std::fill(region.data.begin(), region.data.end(), uint8_t{255});
  }
  void fill(uint8_t first, uint8_t second) {
    std::fill(a.data.begin(), a.data.end(), first);
    std::fill(b.data.begin(), b.data.end(), second);
    std::fill(linear_a.data.begin(), linear_a.data.end(), static_cast<float>(first) / 255);
    std::fill(linear_b.data.begin(), linear_b.data.end(), static_cast<float>(second) / 255);
  }
  void fill_with_noise() {
    for (size_t i = 0; i < a.data.size(); ++i) {
      a.data[i] = b.data[i] = static_cast<uint8_t>(random_below(1, i, 1, 256));
      linear_a.data[i] = linear_b.data[i] = static_cast<float>(a.data[i]) / 255;
    }
  }
  metrics::ScoreInput input() const {
    metrics::ScoreInput in;
    in.reference = {.codes = &a, .linear = &linear_a, .ids = &ids, .depth = &depth};
    in.test = {.codes = &b, .linear = &linear_b, .ids = &ids, .depth = &depth};
    in.region = &region;
    return in;
  }
};

std::vector<metrics::Scored> score(const metrics::ScoreInput& input) {
  metrics::Shared shared;
  return metrics::score_pictures(metrics::scores(), input, shared);
}

std::string got_text(const metrics::ScoreResult& result) {
  return result.value ? fmt::format("{}", *result.value) : "absent: " + result.reason;
}

void state_equal_pictures(Statements& all, const Pair& pair, const char* name) {
  for (const metrics::Scored& one : score(pair.input())) {
    const metrics::ScoreResult& result = one.result;
    const double best = metrics::best_value(*one.score);
    all.state(result.value ? *result.value == best : !result.reason.empty(),
              fmt::format("{}, {}", one.score->name, name), fmt::format("{}, or absent with a reason", best),
              got_text(result));
  }
}

// In its range, or absent with a reason.
void state_ranges(Statements& all, const metrics::ScoreInput& input, const char* name) {
  for (const metrics::Scored& one : score(input)) {
    const metrics::ScoreResult& result = one.result;
    const bool in_range = result.value && *result.value >= one.score->least && *result.value <= one.score->greatest;
    all.state(in_range || (!result.value && !result.reason.empty()), fmt::format("{}, {}", one.score->name, name),
              fmt::format("within {} .. {}, or absent with a reason", one.score->least, one.score->greatest),
              got_text(result));
  }
}

Found equal_pictures(Fixture& fixture) {
  Statements all;
  for (const auto& [width, height] : {std::pair{1, 1}, std::pair{3, 2}, std::pair{11, 11}, std::pair{96, 64}}) {
    Pair pair(width, height);
    pair.fill(0, 0);
    state_equal_pictures(all, pair, "black");
    pair.fill(255, 255);
    state_equal_pictures(all, pair, "white");
    pair.fill_with_noise();
    state_equal_pictures(all, pair, "noise");
  }
  if (!fixture.small()) {
    Pair wide(16384, 8);
    wide.fill_with_noise();
    state_equal_pictures(all, wide, "16384 wide");
  }
  return all.end();
}

Found extreme_pictures(Fixture&) {
  Statements all;
  for (const auto& [width, height] : {std::pair{1, 1}, std::pair{1, 9}, std::pair{5, 5}, std::pair{200, 180}}) {
    Pair pair(width, height);
    pair.fill(0, 255);
    state_ranges(all, pair.input(), "black against white");
    pair.fill(255, 0);
    state_ranges(all, pair.input(), "white against black");
  }
  return all.end();
}

Found pictures_of_no_numbers(Fixture&) {
  Statements all;
  for (const float value : {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity(),
                            -std::numeric_limits<float>::infinity(), std::numeric_limits<float>::max(), 1e-42F}) {
    Pair pair(32, 24);
    pair.fill(100, 100);
    pair.linear_b.at(5, 7)[1] = value;
    state_ranges(all, pair.input(), "one linear value");
    pair.linear_a.at(5, 7)[1] = value;
    state_ranges(all, pair.input(), "one linear value of both");
    *pair.depth.at(3, 3) = value;
    state_ranges(all, pair.input(), "one depth");
  }
  return all.end();
}

Found sixteen_bits(Fixture&) {
  Statements all;
  Image16 a(40, 30, 3);
  for (size_t i = 0; i < a.data.size(); ++i) a.data[i] = static_cast<uint16_t>(random_below(2, i, 1, 65536));
  Image16 b = a;
  metrics::ScoreInput input;
  input.reference.codes16 = &a;
  input.test.codes16 = &b;
  for (const metrics::Scored& one : score(input))
    all.state(!one.result.value || *one.result.value == metrics::best_value(*one.score), std::string(one.score->name),
              fmt::format("{}", metrics::best_value(*one.score)), got_text(one.result));
  for (uint16_t& value : b.data) value ^= 1U;  // the least difference
  state_ranges(all, input, "one of 65,535 steps");
  return all.end();
}

Found few_values(Fixture&) {
  Statements all;
  const std::vector<double> zeros(9, 0.0);
  all.equal("the median of zeros", 0, median(zeros));
  const Interval none = bootstrap_median(zeros, 1);
  all.equal("its interval's low end", 0, none.low);
  all.equal("its interval's high end", 0, none.high);
  const std::vector<double> one = {3.5};
  all.equal("the median of one value", 3.5, median(one));
  all.equal("its 0.99-quantile", 3.5, quantile(one, 0.99));
  const Interval alone = bootstrap_median(one, 1);
  all.equal("the width of its interval", 0, alone.high - alone.low);
  all.equal("its Hodges-Lehmann estimate", 3.5, hodges_lehmann(one).estimate);
  const RankTest same = mann_whitney(zeros, zeros);
  all.equal("p of equal samples", 1, same.p_two_sided);
  all.state(same.degenerate, "equal samples", "said to be degenerate", "not said");
  all.equal("p of pairs that do not differ", 1, wilcoxon_signed_rank(zeros).p_two_sided);
  all.state(!brunner_munzel(zeros, zeros), "Brunner-Munzel of equal samples", "not defined", "a value");
  all.state(!kendall_tau_b(zeros, zeros), "tau of ties only", "not defined", "a value");
  all.state(!spearman(one, one), "rho of one pair", "not defined", "a value");
  const Interval nobody = studies::clopper_pearson(0, 5);
  all.equal("low end of 0 of 5", 0, nobody.low);
  all.equal("high end of 5 of 5", 1, studies::clopper_pearson(5, 5).high);
  return all.end();
}

// 1 to n in a mixed order: every order statistic is known.
Found many_values(Fixture& fixture) {
  Statements all;
  const size_t n = fixture.small() ? 100'001 : 10'000'001;
  std::vector<double> values(n);
  for (size_t i = 0; i < n; ++i) values[i] = static_cast<double>((i * 48271) % n) + 1;  // 48271 is prime to n
  all.equal("the median of 1 to n", static_cast<double>(n + 1) / 2, median(values));
  all.equal("the 0.05-quantile", 1 + 0.05 * static_cast<double>(n - 1), quantile(values, 0.05));
  const std::vector<double> twice(values.begin(), values.begin() + 50'000);
  all.equal("rho of 50,000 pairs with themselves", 1, spearman(twice, twice).value_or(NAN));
  all.equal("tau of them", 1, kendall_tau_b(twice, twice).value_or(NAN));
  return all.end();
}

void state_curve(Statements& all, const char* name, const std::vector<studies::Level>& levels,
                 studies::CurveState expected) {
  const studies::CurveFit fit = studies::fit_curve(levels, {});
  all.state(fit.state == expected, name, std::string(studies::state_text(expected)),
            std::string(studies::state_text(fit.state)));
  if (fit.threshold) all.state(std::isfinite(*fit.threshold), name, "a finite threshold", "another");
}

Found odd_answers(Fixture&) {
  using studies::CurveState;
  using studies::WorthState;
  Statements all;
  state_curve(all, "no answers", {}, CurveState::no_data);
  state_curve(all, "levels without answers", {{1, 0, 0}, {2, 0, 0}}, CurveState::no_data);
  state_curve(all, "one level", {{1, 5, 9}}, CurveState::one_level);
  state_curve(all, "all alike", {{1, 9, 9}, {2, 9, 9}, {3, 9, 9}}, CurveState::all_alike);
  state_curve(all, "perfect separation", {{1, 0, 20}, {2, 0, 20}, {3, 20, 20}, {4, 20, 20}}, CurveState::step);
  state_curve(all, "contradictory answers", {{1, 20, 20}, {2, 10, 20}, {3, 0, 20}}, CurveState::no_slope);
  const auto worths = [&](const char* name, const std::vector<studies::Comparison>& comparisons, size_t items,
                          WorthState expected) {
    const studies::Worths fit = studies::fit_worths(comparisons, items, false);
    all.state(fit.state == expected, name, std::string(studies::state_text(expected)),
              std::string(studies::state_text(fit.state)));
  };
  const auto compared = [](uint32_t a, uint32_t b, uint64_t a_wins, uint64_t ties, uint64_t b_wins) {
    studies::Comparison one;
    one.a = a;
    one.b = b;
    one.a_wins = a_wins;
    one.ties = ties;
    one.b_wins = b_wins;
    return one;
  };
  worths("no comparisons", {}, 3, WorthState::no_data);
  worths("two items that never met a third", {compared(0, 1, 3, 0, 3)}, 3, WorthState::disconnected);
  worths("an item that never lost", {compared(0, 1, 9, 0, 0), compared(1, 2, 4, 0, 5)}, 3, WorthState::unbeaten);
  worths("ties only", {compared(0, 1, 0, 9, 0), compared(1, 2, 0, 9, 0)}, 3, WorthState::all_ties);
  worths("a circle", {compared(0, 1, 9, 0, 0), compared(1, 2, 9, 0, 0), compared(2, 0, 9, 0, 0)}, 3,
         WorthState::fitted);
  return all.end();
}

}  // namespace

void add_statistics_cases(std::vector<StabilityCase>& cases) {
  const auto add = [&](std::string_view group, std::string_view name, std::string_view asked, std::string_view from,
                       Found (*measure)(Fixture&)) {
    cases.push_back({.name = name,
                     .group = group,
                     .asked = asked,
                     .unit = "wrong answers",
                     .bound_from = from,
                     .once = true,
                     .measure = measure});
  };
  constexpr const char* kRange = "every score states its range: a value within it, or absent with a reason; never NaN";
  add("metrics", "metrics_equal", "equal pictures, black, white and noise, of 1x1 to 16384 wide: every score",
      "equal pictures score the better end of the range, exactly", equal_pictures);
  add("metrics", "metrics_black_white", "all black against all white, down to one pixel: every score", kRange,
      extreme_pictures);
  add("metrics", "metrics_no_numbers", "linear light and depths that are NaN, infinite, largest or subnormal", kRange,
      pictures_of_no_numbers);
  add("metrics", "metrics_16_bit", "pictures of 16 bits: equal, and one step apart everywhere", kRange, sixteen_bits);
  constexpr const char* kByHand = "the results are known without reckoning";
  add("statistics", "statistics_few", "zeros, one value, equal samples, ties only, none of n and all of n", kByHand,
      few_values);
  add("statistics", "statistics_many", "1e7 values whose order statistics are known", kByHand, many_values);
  add("statistics", "statistics_answers",
      "no answers, one level, all alike, separated, contradictory; nobody compared, ties only, never beaten, a circle",
      "the state that the fit must name; no number in its place", odd_answers);
}

}  // namespace crowdbench::bench
