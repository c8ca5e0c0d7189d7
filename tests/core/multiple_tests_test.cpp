// Corrections for many tests: by hand, and against R's p.adjust (shared ground truth).
#include "core/multiple_tests.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>

#include "core/random.h"
#include "tests/core/statistics_cases.h"

namespace crowdbench {
namespace {

using Numbers = std::vector<double>;

void expect_near(const Numbers& got, const Numbers& expected, double tolerance, const std::string& what) {
  ASSERT_EQ(got.size(), expected.size()) << what;
  for (size_t i = 0; i < got.size(); ++i) EXPECT_NEAR(got[i], expected[i], tolerance) << what << ' ' << i;
}

// Ascending: 0.01, 0.02, 0.03, 0.2. Holm: 4 x 0.01, 3 x 0.02, 2 x 0.03, 1 x 0.2. Benjamini-Hochberg: 0.01 x 4/1,
// 0.02 x 4/2, 0.03 x 4/3, 0.2: all of the first three 0.04.
TEST(MultipleTests, FourByHand) {
  const Numbers p = {0.03, 0.2, 0.01, 0.02};
  expect_near(holm(p), {0.06, 0.2, 0.04, 0.06}, 1e-15, "Holm");
  expect_near(benjamini_hochberg(p), {0.04, 0.2, 0.04, 0.04}, 1e-15, "Benjamini-Hochberg");
  EXPECT_EQ(adjusted_p_values(p, Correction::none), p);
  EXPECT_EQ(adjusted_p_values(p, Correction::holm), holm(p));
  EXPECT_EQ(adjusted_p_values(p, Correction::benjamini_hochberg), benjamini_hochberg(p));
}

// 2 x 0.04 = 0.08 is more than 1 x 0.05: Holm never lets a larger p pass where a smaller one did not.
// 0.04 x 2 = 0.08 is more than 0.05 x 1: Benjamini-Hochberg lets a smaller p pass where a larger one did.
TEST(MultipleTests, AdjustedValuesKeepTheOrder) {
  expect_near(holm(Numbers{0.04, 0.05}), {0.08, 0.08}, 1e-15, "Holm");
  expect_near(benjamini_hochberg(Numbers{0.04, 0.05}), {0.05, 0.05}, 1e-15, "Benjamini-Hochberg");
  EXPECT_EQ(holm(Numbers{0.9, 0.8}), (Numbers{1, 1})) << "never above 1";
  EXPECT_TRUE(holm(Numbers{}).empty());
  EXPECT_TRUE(benjamini_hochberg(Numbers{}).empty());
}

TEST(MultipleTests, AreThoseOfTheSharedGroundTruth) {
  const nlohmann::json* all = test::statistics_cases();
  if (all == nullptr) GTEST_SKIP() << "needs the shared ground-truth folder";
  size_t cases = 0;
  for (const auto& [name, one] : all->at("p_adjust").items()) {
    const auto p = one.at("p").get<Numbers>();
    expect_near(holm(p), one.at("holm").get<Numbers>(), 1e-12, name);
    expect_near(benjamini_hochberg(p), one.at("BH").get<Numbers>(), 1e-12, name);
    ++cases;
  }
  EXPECT_EQ(cases, 7U);
}

// Twenty true hypotheses at once, 4,000 times: some false alarm at 5 % in 5 % of the families, within the 95 % binomial
// limits (0.0432 to 0.0568); without a correction in 1 - 0.95^20 = 64 %.
TEST(MultipleTests, FamilyKeepsTheLevel) {
  constexpr size_t kFamilies = 4000;
  size_t alarms_holm = 0;
  size_t alarms_none = 0;
  for (size_t family = 0; family < kFamilies; ++family) {
    Numbers p(20);
    for (size_t i = 0; i < p.size(); ++i) p[i] = random_unit(11, family * p.size() + i, 0x66616d);
    const auto alarm = [](const Numbers& adjusted) {
      return std::any_of(adjusted.begin(), adjusted.end(), [](double value) { return value <= 0.05; });
    };
    alarms_holm += alarm(holm(p)) ? 1 : 0;
    alarms_none += alarm(p) ? 1 : 0;
  }
  EXPECT_NEAR(static_cast<double>(alarms_holm) / kFamilies, 0.05, 0.0068);
  EXPECT_GT(static_cast<double>(alarms_none) / kFamilies, 0.6);
}

}  // namespace
}  // namespace crowdbench
