// The outside oracle: scores by other people's tools. The small pairs lie in tests/data; the whole set is read where
// the project's shared folder is present.
#include "tests/metrics/ground_truth.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <string>

#include "core/error.h"
#include "metrics/difference.h"
#include "metrics/ssim.h"
#include "metrics/temporal.h"

namespace crowdbench::metrics {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

void expect_score(const json& expected, std::optional<double> value, double tolerance, const std::string& what) {
  if (expected.is_null()) {
    EXPECT_FALSE(value.has_value()) << what << " must not exist";
    return;
  }
  ASSERT_TRUE(value.has_value()) << what;
  if (expected == "inf")
    EXPECT_EQ(*value, std::numeric_limits<double>::infinity()) << what;
  else
    EXPECT_NEAR(*value, expected.get<double>(), tolerance) << what;
}

// Returns how many pairs were checked.
int check_pairs(const fs::path& folder) {
  const json all = expected_of(folder);
  int checked = 0;
  for (const auto& [name, pair] : all["pairs"].items()) {
    const auto [reference, test] = pictures_of(folder, all, name);
    const json& contract = pair["contract"];
    // The stored numbers have nine decimals.
    const auto d = difference(reference, test);
    if (!d) throw std::logic_error(name);
    expect_score(contract["mae"], d->mae, 1e-6, name + " mae");
    expect_score(contract["mse"], d->mse, 1e-6, name + " mse");
    expect_score(contract["psnr"], d->psnr, 1e-6, name + " psnr");
    const Plane a = luma601(reference);
    const Plane b = luma601(test);
    const auto s = ssim(a, b);
    expect_score(contract["ssim_luma601"], s ? std::optional(s->mean) : std::nullopt, 1e-6, name + " ssim");
    expect_score(contract["ms_ssim_luma601"], ms_ssim(a, b, s ? &*s : nullptr), 1e-5, name + " ms_ssim");
    expect_score(contract["gmsd_luma601"], gmsd(a, b), 1e-6, name + " gmsd");
    // Sixteen bits of the same values give the same scores.
    const auto wide = difference(widen(reference), widen(test));
    EXPECT_NEAR(wide->mae, d->mae, 1e-12 * (1 + d->mae)) << name;
    EXPECT_NEAR(wide->mse, d->mse, 1e-12 * (1 + d->mse)) << name;
    ++checked;
  }
  return checked;
}

int check_maps(const fs::path& folder) {
  const json all = expected_of(folder);
  int checked = 0;
  for (const auto& [name, map] : all["maps"].items()) {
    const json& pair = all["pairs"][name];
    const Image8 expected = picture(folder / map["absdiff"].get<std::string>());
    const Image8 actual = absolute_difference(picture(folder / pair["ref"].get<std::string>()),
                                              picture(folder / pair["test"].get<std::string>()));
    EXPECT_EQ(actual, expected) << name;
    ++checked;
  }
  return checked;
}

TEST(GroundTruth, ScoresOfTheBundledPairs) { EXPECT_EQ(check_pairs(kOwn), 14); }

TEST(GroundTruth, AbsoluteDifferenceOfTheBundledPairs) { EXPECT_EQ(check_maps(kOwn), 2); }

TEST(GroundTruth, ScoresOfTheWholeSharedSet) {
  if (!fs::exists(kShared)) GTEST_SKIP() << "needs the shared ground-truth folder";
  EXPECT_EQ(check_pairs(kShared), 22);
  EXPECT_EQ(check_maps(kShared), 3);
}

TEST(GroundTruth, SsimMapAgainstTheQuantilesOfAnotherTool) {
  if (!fs::exists(kShared)) GTEST_SKIP() << "needs the shared ground-truth folder";
  const json all = expected_of(kShared);
  int checked = 0;
  for (const auto& [name, pair] : all["pairs"].items()) {
    const auto& map = pair["ssim"].value("map_luma601_valid", json());
    if (!map.is_object() || !pair.contains("ref")) continue;
    const auto s = ssim(luma601(picture(kShared / pair["ref"].get<std::string>())),
                        luma601(picture(kShared / pair["test"].get<std::string>())));
    ASSERT_TRUE(s) << name;
    const auto [low, high] = std::minmax_element(s->map.data.begin(), s->map.data.end());
    EXPECT_NEAR(*low, map["min"].get<double>(), 1e-6) << name;
    EXPECT_NEAR(*high, map["max"].get<double>(), 1e-6) << name;
    ++checked;
  }
  EXPECT_GE(checked, 10);
}

TEST(GroundTruth, LinearErrorsOfFloatPictures) {
  if (!fs::exists(kShared)) GTEST_SKIP() << "needs the shared ground-truth folder";
  const json all = expected_of(kShared);
  int checked = 0;
  for (const auto& [name, pair] : all["hdr"].items()) {
    const auto a = read_image(kShared / pair["ref"].get<std::string>());
    const auto b = read_image(kShared / pair["test"].get<std::string>());
    const auto d = linear_difference(std::get<ImageF>(a), std::get<ImageF>(b));
    EXPECT_NEAR(d.mae, pair["numpy_float64"]["mae"].get<double>(), 1e-9) << name;
    EXPECT_NEAR(d.rms * d.rms, pair["numpy_float64"]["mse"].get<double>(), 1e-9) << name;
    EXPECT_NEAR(d.rms, pair["idiff"]["rms_error"].get<double>(), 1e-4) << name;
    ++checked;
  }
  EXPECT_EQ(checked, 3);
}

TEST(GroundTruth, StepDifferenceOfTheSequenceWithAPop) {
  if (!fs::exists(kShared)) GTEST_SKIP() << "needs the shared ground-truth folder";
  const json sequence = expected_of(kShared)["sequence"];
  const auto frames = sequence["frames"].get<size_t>();
  ASSERT_GT(frames, 2U);
  std::vector<Image8> reference;
  std::vector<Image8> test;
  for (size_t t = 0; t < frames; ++t) {
    reference.push_back(picture(kShared / fmt::format("sequence/ref_{:02}.png", t)));
    test.push_back(picture(kShared / fmt::format("sequence/test_{:02}.png", t)));
  }
  const auto steps = step_difference(reference, test);
  ASSERT_EQ(steps.size(), frames - 1);
  for (size_t t = 1; t < frames; ++t)
    EXPECT_NEAR(steps[t - 1], sequence["per_frame"][t]["temporal_diff_error"].get<double>(), 1e-6) << t;
}

}  // namespace
}  // namespace crowdbench::metrics
