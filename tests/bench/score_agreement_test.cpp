#include "bench/experiments/score_agreement.h"

#include <gtest/gtest.h>

namespace crowdbench::bench {
namespace {

const metrics::Score kLikeness = {.name = "likeness", .direction = metrics::Direction::higher_is_better};
const metrics::Score kError = {.name = "error", .direction = metrics::Direction::lower_is_better};
const metrics::Score kUnused = {.name = "unused"};
const std::vector<const metrics::Score*> kTable = {&kLikeness, &kError, &kUnused};

ComparisonRow view(int64_t id, double height, double azimuth, double likeness, std::optional<double> error) {
  ComparisonRow row;
  row.id = id;
  row.kind = "agent";
  row.representation = azimuth < 90 ? "flat" : "relief";
  row.character = "mannequin";
  row.height_px = height;
  row.azimuth_deg = azimuth;
  row.scores = {{"likeness", likeness, ""}, {"error", error, error ? "" : "too small"}};
  return row;
}

TEST(ScoreAgreement, HigherIsBetterAndLowerIsBetterAgreeAtPlusOne) {
  StoreContents contents;
  for (int i = 0; i < 5; ++i) contents.comparisons.push_back(view(i, 60, 30.0 * i, 0.1 * i, 10 - i));
  const ScoreAgreements all = agreements_of(contents, kTable, 1);
  ASSERT_EQ(all.scores.size(), 2U) << "a score without values is left out";
  ASSERT_EQ(all.pairs.size(), 1U);
  EXPECT_EQ(all.groups, 2U);
  EXPECT_EQ(all.pairs[0].ranks.pairs, 5U);
  EXPECT_DOUBLE_EQ(all.pairs[0].ranks.spearman->value, 1);
  EXPECT_DOUBLE_EQ(all.pairs[0].ranks.kendall->value, 1);
  EXPECT_FALSE(all.pairs[0].worst);
  EXPECT_TRUE(worst_pairs(all, 3).empty());
  EXPECT_EQ(&pair_of(all, 1, 0), &all.pairs[0]);
}

// Four views of 60 pixels. By likeness from worst to best: 0 1 2 3; by error: 3 1 2 0. Views 3 and 0 lie three ranks
// apart of three, in opposite order. Those of 20 pixels disagree across heights alone.
TEST(ScoreAgreement, TheWorstPairIsOfOneHeight) {
  StoreContents contents;
  contents.comparisons = {view(1, 60, 0, 0.1, 1),  view(2, 60, 10, 0.2, 3), view(3, 60, 20, 0.3, 2),
                          view(4, 60, 30, 0.4, 4), view(5, 20, 0, 0.9, 9),  view(6, 20, 10, 0.95, 8)};
  const ScoreAgreements all = agreements_of(contents, kTable, 1);
  const std::optional<Disagreement>& worst = all.pairs.at(0).worst;
  ASSERT_TRUE(worst);
  EXPECT_EQ(all.rows[worst->first]->id, 4) << "the likeness prefers it";
  EXPECT_EQ(all.rows[worst->second]->id, 1);
  EXPECT_DOUBLE_EQ(worst->gap_a, 1);
  EXPECT_DOUBLE_EQ(worst->gap_b, 1);
  EXPECT_EQ(worst_pairs(all, 3), (std::vector<const ScorePair*>{&all.pairs[0]}));
}

TEST(ScoreAgreement, CountsViewsOnceAndOnlyThoseThatHaveBoth) {
  StoreContents contents;
  contents.comparisons = {view(1, 60, 0, 0.1, 1), view(2, 60, 10, 0.2, std::nullopt), view(3, 60, 20, 0.3, 2),
                          view(4, 60, 0, 0.5, 3), view(5, 60, 40, 0.6, 4)};
  contents.comparisons.push_back(view(6, 60, 50, 0.7, 5));
  contents.comparisons.back().kind = "crowd";
  const ScoreAgreements all = agreements_of(contents, kTable, 1);
  EXPECT_EQ(all.rows.size(), 4U) << "the first view was scored again, a crowd is none";
  EXPECT_EQ(all.rows[0]->id, 4);
  EXPECT_EQ(all.pairs.at(0).ranks.pairs, 3U);
}

}  // namespace
}  // namespace crowdbench::bench
