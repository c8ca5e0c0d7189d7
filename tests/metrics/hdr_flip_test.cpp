// HDR-FLIP, and pixels that are not finite.
#include "metrics/hdr_flip.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <nlohmann/json.hpp>
#include <string>

#include "core/error.h"
#include "metrics/not_finite.h"
#include "metrics/pseudocolour.h"
#include "metrics/registry.h"
#include "tests/metrics/flip_expected.h"
#include "tests/metrics/ground_truth.h"

namespace crowdbench::metrics {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

void expect_hdr_of(const ImageF& reference, const ImageF& test, const HdrFlipSettings& settings, const json& expected,
                   const std::string& name) {
  const HdrFlip actual = hdr_flip(reference, test, settings);
  ASSERT_EQ(actual.range.reason, "") << name;
  const auto either = [&](const char* a, const char* b) { return expected.contains(a) ? expected[a] : expected[b]; };
  EXPECT_NEAR(actual.range.start, either("start_exposure", "start").get<double>(), 1e-4) << name;
  EXPECT_NEAR(actual.range.stop, either("stop_exposure", "stop").get<double>(), 1e-4) << name;
  EXPECT_EQ(actual.range.exposures, either("num_exposures", "n").get<int>()) << name;
  expect_pooled(flip_pooled(actual.map), expected, name);
}

void expect_hdr(const std::string& name, const HdrFlipSettings& settings, const json& expected) {
  const json pair = expected_of(kShared)["hdr"][name];
  expect_hdr_of(float_picture(kShared / pair["ref"].get<std::string>()),
                float_picture(kShared / pair["test"].get<std::string>()), settings, expected, name);
}

TEST(HdrFlipGroundTruth, EveryToneMapperAndRange) {
  if (!fs::exists(kShared)) GTEST_SKIP() << "needs the shared ground-truth folder";
  const json all = expected_of(kShared)["hdr"];
  const json more = json::parse(read_text(kShared / "flip_stages.json"))["hdr_extra_reference_cli"];
  HdrFlipSettings aces;
  HdrFlipSettings fixed;
  fixed.start = -4;
  fixed.stop = 2;
  fixed.exposures = 7;
  HdrFlipSettings far;
  far.flip.pixels_per_degree = 33.5;
  HdrFlipSettings hable;
  hable.tone_mapper = ToneMapper::hable;
  HdrFlipSettings reinhard;
  reinhard.tone_mapper = ToneMapper::reinhard;
  const std::string h01 = "h01_noise_fireflies";
  const std::string h03 = "h03_half_exposure";
  for (const auto& name : {h01, std::string("h02_identical"), h03})
    expect_hdr(name, aces, all[name]["hdrflip_aces_default"]);
  expect_hdr(h01, fixed, all[h01]["hdrflip_fixed_exposures_-4_to_2_n7"]);
  expect_hdr(h01, far, all[h01]["hdrflip_ppd33.5"]);
  expect_hdr(h01, reinhard, all[h01]["hdrflip_reinhard"]);
  expect_hdr(h01, hable, more[h01]["hable"]);
  expect_hdr(h03, hable, more[h03]["hable"]);
  expect_hdr(h03, reinhard, more[h03]["reinhard"]);
}

// The bundled case: a picture and its half, a stop darker.
TEST(HdrFlipGroundTruth, HalfTheLight) {
  const json pair = expected_of(kOwn)["hdr"]["h03_half_exposure"];
  const ImageF reference = float_picture(kOwn / pair["ref"].get<std::string>());
  ImageF test = reference;
  for (float& v : test.data) v *= 0.5F;
  for (const auto& [mapper, key] :
       {std::pair(ToneMapper::aces, "hdrflip_aces_default"), std::pair(ToneMapper::hable, "hdrflip_hable"),
        std::pair(ToneMapper::reinhard, "hdrflip_reinhard")}) {
    HdrFlipSettings settings;
    settings.tone_mapper = mapper;
    expect_hdr_of(reference, test, settings, pair[key], key);
  }
}

TEST(HdrFlipGroundTruth, ErrorAndExposureMaps) {
  const fs::path images = kShared / "cvvdp" / "images";
  if (!fs::exists(images)) GTEST_SKIP() << "needs the shared ground-truth folder";
  const ImageF reference = float_picture(kShared / "hdr" / "h01_noise_fireflies_ref.exr");
  const ImageF test = float_picture(kShared / "hdr" / "h01_noise_fireflies_test.exr");
  const HdrFlip actual = hdr_flip(reference, test);
  const Image8 grey = picture(images / "flip_hdr_h01_aces_grey.png");
  const Image8 viridis = picture(images / "flip_hdr_h01_aces_exposure_viridis.png");
  size_t beyond = 0;
  size_t other_exposure = 0;
  for (size_t i = 0; i < grey.pixels(); ++i) {
    const int level = static_cast<int>(255 * actual.map.data[i] + 0.5F);
    beyond += std::abs(level - int{grey.data[i * static_cast<size_t>(grey.channels)]}) > 1 ? 1 : 0;
    const auto& colour = viridis_colours()[static_cast<size_t>(255 * actual.exposure.data[i] + 0.5F)];
    other_exposure +=
        std::equal(colour.begin(), colour.end(), &viridis.data[static_cast<size_t>(viridis.channels) * i]) ? 0 : 1;
  }
  EXPECT_LE(beyond, grey.pixels() / 1000);
  // Two exposures of nearly equal error change places by the last bits.
  EXPECT_LE(other_exposure, grey.pixels() / 1000);
}

TEST(HdrFlip, ExposuresByHand) {
  // Luminances 1, 1, 2: the median 1, the greatest 2. Reinhard's curve is 0.85 at 17/3.
  ImageF image(3, 1, 1);
  image.data = {1, 2, 1};
  HdrFlipSettings settings;
  settings.tone_mapper = ToneMapper::reinhard;
  const ExposureRange range = exposure_range(image, settings);
  EXPECT_NEAR(range.start, std::log2(17.0 / 3 / 2), 1e-12);
  EXPECT_NEAR(range.stop, std::log2(17.0 / 3), 1e-12);
  EXPECT_EQ(range.exposures, 2) << "a stop apart, two at least";
  EXPECT_NEAR(range.at(1), range.stop, 1e-12);
  settings.start = -3;
  EXPECT_EQ(exposure_range(image, settings).exposures, static_cast<int>(std::ceil(std::log2(17.0 / 3) + 3)));
  settings.exposures = 4;
  EXPECT_EQ(exposure_range(image, settings).exposures, 4);
  settings.start = 9;
  EXPECT_NE(exposure_range(image, settings).reason.find("start above"), std::string::npos);
}

// Flat greys of light 1 and 2, at half and at twice the light, by Reinhard's v / (1 + v): 1/3 against 1/2 and 2/3
// against 4/5. The darker exposure shows more of it; FLIP of two flat greys is 0.95 / 16.51 of their lightnesses'
// distance^0.7.
TEST(HdrFlip, IdentityAndTwoExposuresByHand) {
  ImageF one(9, 7, 1);
  std::fill(one.data.begin(), one.data.end(), 1.0F);
  ImageF two = one;
  std::fill(two.data.begin(), two.data.end(), 2.0F);
  HdrFlipSettings settings;
  settings.tone_mapper = ToneMapper::reinhard;
  settings.start = -1;
  settings.stop = 1;
  settings.exposures = 2;
  const auto flip = [](double a, double b) {
    return 0.95 / 16.51044 * std::pow(116 * (std::cbrt(b) - std::cbrt(a)), 0.7);
  };
  ASSERT_GT(flip(1.0 / 3, 1.0 / 2), flip(2.0 / 3, 4.0 / 5) + 0.01);
  const HdrFlip errors = hdr_flip(one, two, settings);
  for (const float v : errors.map.data) EXPECT_NEAR(v, flip(1.0 / 3, 1.0 / 2), 1e-4);
  for (const float v : errors.exposure.data) EXPECT_EQ(v, 0) << "the first exposure";
  for (const float v : hdr_flip(two, two, settings).map.data) EXPECT_EQ(v, 0);
}

TEST(HdrFlip, WhatHasNoValueSaysWhy) {
  ImageF black(6, 6, 3);
  ImageF lit = black;
  for (size_t i = 0; i < 3 * 10; ++i) lit.data[i] = 2;  // ten of 36 pixels: the median is 0
  EXPECT_NE(hdr_flip(lit, black).range.reason.find("median luminance is 0"), std::string::npos);
  EXPECT_NE(hdr_flip(black, lit).range.reason.find("black"), std::string::npos);
  HdrFlipSettings settings;
  settings.start = -2;
  settings.stop = 2;
  EXPECT_EQ(hdr_flip(lit, black, settings).range.reason, "") << "exposures that are given need no median";
  EXPECT_THROW(hdr_flip(lit, ImageF(6, 5, 3)), Error);
}

TEST(HdrFlip, HugeValuesDoNotOverflow) {
  ImageF a(8, 8, 3);
  std::fill(a.data.begin(), a.data.end(), 1e-3F);
  ImageF b = a;
  b.data[0] = std::numeric_limits<float>::max();
  const HdrFlip errors = hdr_flip(b, a);
  for (const float v : errors.map.data) {
    EXPECT_GE(v, 0);
    EXPECT_LE(v, 1);
  }
  EXPECT_GT(errors.map.data[0], 0.5F) << "where the pictures differ by all that there is";
  EXPECT_LT(errors.map.data[63], errors.map.data[0]) << "and the corner opposite less";
}

// ---- not a number, infinite ----

TEST(NotFinite, AreCountedAndPlacedAndNeverBecomeAScore) {
  ImageF clean(8, 5, 4);
  std::fill(clean.data.begin(), clean.data.end(), 0.5F);
  ImageF broken = clean;
  broken.at(3, 1)[1] = std::numeric_limits<float>::infinity();
  broken.at(6, 1)[0] = std::numeric_limits<float>::quiet_NaN();
  broken.at(6, 1)[2] = std::numeric_limits<float>::infinity();
  broken.at(2, 4)[2] = std::numeric_limits<float>::quiet_NaN();
  broken.at(0, 0)[3] = std::numeric_limits<float>::quiet_NaN();  // alpha
  const NotFinite found = not_finite(broken);
  EXPECT_EQ(found.nan, 2U);
  EXPECT_EQ(found.infinite, 1U);
  EXPECT_EQ(found.x, 3);
  EXPECT_EQ(found.y, 1);
  EXPECT_EQ(not_finite(clean).pixels(), 0U);
  const std::string text = "the test has 2 pixels that are not a number and 1 infinite, the first at (3, 1)";
  EXPECT_EQ(not_finite_text({}, found), text);
  EXPECT_EQ(
      not_finite_text({1, 0, 2, 3}, {0, 1, 4, 5}),
      "the reference has 1 pixel that is not a number, the first at (2, 3); the test has 1 pixel that is infinite, "
      "the first at (4, 5)");
  ScoreInput input;
  input.reference.linear = &clean;
  input.test.linear = &broken;
  Shared shared;
  const auto scored = score_pictures(scores(), input, shared);
  EXPECT_GE(scored.size(), 3U);
  for (const Scored& one : scored) {
    EXPECT_FALSE(one.result.value) << one.score->name;
    EXPECT_EQ(one.result.reason, text) << one.score->name;
  }
}

// The same infinity in both pictures is counted and placed, too, and makes no score: a picture of depths that is empty
// here and there is judged by the depth error, with ids.
TEST(NotFinite, InfinityInBothIsNoScore) {
  ImageF depth(4, 4, 1);
  std::fill(depth.data.begin(), depth.data.end(), std::numeric_limits<float>::infinity());
  *depth.at(1, 1) = 5;
  ImageF other = depth;
  *other.at(1, 1) = 6;
  ScoreInput input;
  input.reference.linear = &depth;
  input.test.linear = &other;
  Shared shared;
  size_t absent = 0;
  for (const Scored& one : score_pictures(scores(), input, shared)) {
    EXPECT_FALSE(one.result.value) << one.score->name;
    EXPECT_EQ(one.result.reason,
              "the reference has 15 pixels that are infinite, the first at (0, 0); the test has 15 pixels that are "
              "infinite, the first at (0, 0)")
        << one.score->name;
    ++absent;
  }
  EXPECT_GE(absent, 3U);
}

}  // namespace
}  // namespace crowdbench::metrics
