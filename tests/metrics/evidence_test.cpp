// What each score of the table is held to: equal pictures, values worked out by hand, and an outside oracle. The table
// below is the place to look which test does it, and a score without a line in it fails.
//
// What this can see: that every score has three tests, that they are in this program, and that none is named that is
// not. Whether a test is a good one is for its reader.
#include <gtest/gtest.h>

#include <set>
#include <string>
#include <string_view>

#include "metrics/registry.h"

namespace crowdbench::metrics {
namespace {

struct Evidence {
  std::string_view score;
  std::string_view identity;  // equal pictures score the best there is
  std::string_view by_hand;   // the arithmetic is in the test
  std::string_view oracle;    // another program's values; it runs without the shared folder
};

constexpr std::string_view kEqualPictures = "Registry.EqualPicturesScoreTheBestAndOthersWorse";
constexpr std::string_view kShifted = "Silhouette.BoundaryDistanceOfAShiftedSquare";
constexpr std::string_view kSquares = "Silhouette.HausdorffAndSymmetricDifference";
constexpr std::string_view kTwoPixels = "Difference.TwoPixelsByHand";
constexpr std::string_view kFloats = "Difference.LinearErrorsOfFloats";
constexpr std::string_view kFrame = "CrowdOracle.AFrameAndItsAgents";
constexpr std::string_view kGrids = "CrowdOracle.SilhouettesAtTheEdgeOfWhatExists";
constexpr std::string_view kPairs = "GroundTruth.ScoresOfTheBundledPairs";
constexpr std::string_view kLinear = "CrowdOracle.LinearLight";

constexpr Evidence kEvidence[] = {
    {"silhouette_iou", kEqualPictures, "Silhouette.IouByHand", kGrids},
    {"boundary_px_mean", kEqualPictures, kShifted, kGrids},
    {"boundary_px_p95", kEqualPictures, kShifted, kGrids},
    {"silhouette_hausdorff_px", kEqualPictures, kSquares, kGrids},
    {"silhouette_difference_px", kEqualPictures, kSquares, kGrids},
    {"holes", kEqualPictures, "Tears.ByHand", kGrids},
    {"strays", kEqualPictures, "Tears.ByHand", kGrids},
    {"ssim", kEqualPictures, "Ssim.OnePointInTheWindowByHand", kPairs},
    {"ssim_union", kEqualPictures, "Ssim.OfARegionByHand", kFrame},
    {"ms_ssim", kEqualPictures, "MsSsim.IdentitySizesAndOrder", kPairs},
    {"flip", kEqualPictures, "Flip.BlackAndWhiteByHand", "FlipGroundTruth.TheBundledPairs"},
    {"psnr", kEqualPictures, kTwoPixels, kPairs},
    {"mae", kEqualPictures, kTwoPixels, kPairs},
    {"mse", kEqualPictures, kTwoPixels, kPairs},
    {"gmsd", kEqualPictures, "Gmsd.IdentityAndAStepByHand", kPairs},
    {"depth_mae", kEqualPictures, "Agents.EachAgentIsScoredOverItsOwnUnion", kFrame},
    {"linear_mae", kEqualPictures, kFloats, kLinear},
    {"linear_rms", kEqualPictures, kFloats, kLinear},
    {"hdr_flip", kEqualPictures, "HdrFlip.IdentityAndTwoExposuresByHand", "HdrFlipGroundTruth.HalfTheLight"},
    {"cvvdp", kEqualPictures, "Cvvdp.FourPixelsByHand", "CvvdpGroundTruth.EveryScoreWithin1e4Jod"},
    {"flicker", "Registry.FramesAreTakenOneByOne", "Flicker.ByHandAndOverSilhouettes", "CrowdOracle.SuccessiveFrames"},
};

std::set<std::string> tests_of_this_program() {
  std::set<std::string> names;
  const testing::UnitTest& all = *testing::UnitTest::GetInstance();
  for (int s = 0; s < all.total_test_suite_count(); ++s) {
    const testing::TestSuite& suite = *all.GetTestSuite(s);
    for (int t = 0; t < suite.total_test_count(); ++t)
      names.insert(std::string(suite.name()) + "." + suite.GetTestInfo(t)->name());
  }
  return names;
}

TEST(Evidence, EveryScoreHasItsThreeTests) {
  const std::set<std::string> tests = tests_of_this_program();
  std::set<std::string_view> proven;
  for (const Evidence& of : kEvidence) {
    EXPECT_TRUE(proven.insert(of.score).second) << of.score << " twice";
    for (const std::string_view test : {of.identity, of.by_hand, of.oracle})
      EXPECT_TRUE(tests.contains(std::string(test))) << of.score << ": there is no test " << test;
    EXPECT_NE(of.identity, of.by_hand) << of.score;
    EXPECT_NE(of.by_hand, of.oracle) << of.score;
  }
  std::set<std::string_view> registered;
  for (const Score* score : scores()) registered.insert(score->name);
  for (const std::string_view score : registered)
    EXPECT_TRUE(proven.contains(score)) << score << " has no line: what is it held to?";
  for (const std::string_view score : proven) EXPECT_TRUE(registered.contains(score)) << score << " is not a score";
}

}  // namespace
}  // namespace crowdbench::metrics
