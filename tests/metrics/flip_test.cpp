// FLIP: its arithmetic, identity, by hand. The outside oracle: flip_ground_truth_test.cpp.
#include "metrics/flip.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "core/colour.h"
#include "core/error.h"
#include "core/random.h"
#include "metrics/fast_math.h"
#include "metrics/flip_filters.h"
#include "metrics/flip_rows.h"
#include "metrics/pseudocolour.h"
#include "metrics/registry.h"

namespace crowdbench::metrics {
namespace {

Image8 noise(int width, int height, uint64_t seed) {
  Image8 out(width, height, 3);
  for (size_t i = 0; i < out.data.size(); ++i) out.data[i] = static_cast<uint8_t>(random_below(seed, i, 1, 256));
  return out;
}

// ---- arithmetic ----

TEST(FastMath, IsAsNearAsItSays) {
  for (int i = 0; i <= 200'000; ++i) {
    const float t = std::exp2(static_cast<float>(i - 100'000) / 1005.0F);
    ASSERT_NEAR(fast_cbrt(t) / std::cbrt(double{t}), 1, 2.5e-7) << t;
    const double log = std::log2(double{t});
    ASSERT_NEAR(fast_log2(t), log, 2e-7 + std::abs(log) * 6e-8) << t;
    const float p = static_cast<float>(i - 100'000) / 800.0F;
    ASSERT_NEAR(fast_exp2(p) / std::exp2(double{p}), 1, 3e-7) << p;
  }
  for (int i = 1; i <= 2000; ++i)
    for (const float exponent : {0.01F, 0.3F, 0.7F, 1.0F}) {
      const float base = static_cast<float>(i) / 10;
      ASSERT_NEAR(fast_pow(base, exponent) / std::pow(double{base}, double{exponent}), 1, 1e-6) << base;
    }
  EXPECT_EQ(fast_pow(0, 0.7F), 0);
  EXPECT_EQ(fast_exp2(-500), fast_exp2(-126));
}

TEST(FlipFilters, TrimmedTapsLoseNothing) {
  EXPECT_EQ(trimmed({0.5F, 0.25F}), (Taps{0.5F, 0.25F}));
  EXPECT_EQ(trimmed({0.5F, 0.25F, 1e-12F, 0}), (Taps{0.5F, 0.25F}));
  EXPECT_EQ(trimmed({1}), Taps{1});
  const ContrastFilters contrast = contrast_filters(kFlipPixelsPerDegree);
  EXPECT_LT(trimmed(contrast.achromatic).size(), contrast.achromatic.size());
  EXPECT_EQ(trimmed(contrast.blue_yellow[0]).size(), contrast.blue_yellow[0].size());
}

// ---- identity ----

TEST(Flip, EqualPicturesAreExactlyZeroAndTheOrderHardlyMatters) {
  const Image8 a = noise(70, 41, 1);
  const Image8 b = noise(70, 41, 2);
  const ImageF same = flip_map(a, a);
  EXPECT_TRUE(std::all_of(same.data.begin(), same.data.end(), [](float v) { return v == 0; }));
  EXPECT_EQ(flip_map(a, b), flip_map(b, a)) << "FLIP is symmetric";
  EXPECT_THROW(flip_map(a, noise(70, 40, 1)), Error);
}

TEST(Flip, SixteenBitsAndGreyAndAlphaGiveTheSame) {
  const Image8 a = noise(40, 30, 1);
  const Image8 b = noise(40, 30, 2);
  EXPECT_EQ(flip_map(widen(a), widen(b)), flip_map(a, b));
  Image8 grey(40, 30, 1);
  Image8 repeated(40, 30, 3);
  Image8 with_alpha(40, 30, 4);
  for (size_t i = 0; i < grey.data.size(); ++i) {
    grey.data[i] = a.data[3 * i];
    for (size_t c = 0; c < 3; ++c) repeated.data[3 * i + c] = with_alpha.data[4 * i + c] = grey.data[i];
    with_alpha.data[4 * i + 3] = static_cast<uint8_t>(i);
  }
  EXPECT_EQ(flip_map(grey, b), flip_map(repeated, b));
  EXPECT_EQ(flip_map(with_alpha, b), flip_map(repeated, b));
}

TEST(Flip, AnyNumberOfThreadsGivesTheSameBytes) {
  // More than one tile in both directions, neither a whole number of them.
  const Image8 a = noise(801, 530, 1);
  const Image8 b = noise(801, 530, 2);
  const ImageF one = flip_map(a, b, {kFlipPixelsPerDegree, 1});
  EXPECT_EQ(flip_map(a, b, {kFlipPixelsPerDegree, 3}), one);
  EXPECT_EQ(flip_map(a, b, {kFlipPixelsPerDegree, 8}), one);
}

// Tiles are an arrangement of the work alone: the definition, written down plainly in double precision over the whole
// picture, gives the same where tiles meet.
TEST(Flip, TilesDoNotShow) {
  const Image8 a = noise(420, 300, 1);
  const Image8 b = noise(420, 300, 2);
  const ImageF whole = flip_map(a, b);
  // The same pixels in a picture that begins elsewhere, so that its tiles end elsewhere.
  constexpr int kLeft = 60;
  constexpr int kTop = 40;
  const auto cut = [&](const Image8& image) {
    Image8 out(image.width - kLeft, image.height - kTop, 3);
    for (int y = 0; y < out.height; ++y)
      std::copy_n(image.at(kLeft, y + kTop), 3 * static_cast<size_t>(out.width), out.at(0, y));
    return out;
  };
  const ImageF part = flip_map(cut(a), cut(b));
  constexpr int kReach = 10;  // of the filters
  for (int y = kReach; y < part.height; ++y)
    for (int x = kReach; x < part.width; ++x)
      ASSERT_EQ(*part.at(x, y), *whole.at(x + kLeft, y + kTop)) << x << ' ' << y;
}

// ---- by hand ----

// Flat pictures have no features, so that the error is that of the colours alone. Black has L = 0 and no hue, white L =
// 100: HyAB 100, to the power 0.7 it is 25.119. The greatest distance is 41.2761, of which 0.4 is 16.5104: above, the
// last 0.05 are spread over the rest.
TEST(Flip, BlackAndWhiteByHand) {
  EXPECT_NEAR(greatest_colour_distance(), 41.2761, 1e-4);
  Image8 black(9, 7, 3);
  Image8 white = black;
  std::fill(white.data.begin(), white.data.end(), uint8_t{255});
  const double error = std::pow(100, 0.7);
  const double expected = 0.95 + 0.05 * (error - 16.51044) / (41.2761 - 16.51044);
  for (const float v : flip_map(black, white).data) EXPECT_NEAR(v, expected, 2e-5);
  // A small step of grey: L of a code value is 116 (linear)^(1/3) - 16, and 0.95 / 16.51 of its distance^0.7 counts.
  Image8 grey = black;
  Image8 lighter = black;
  std::fill(grey.data.begin(), grey.data.end(), uint8_t{120});
  std::fill(lighter.data.begin(), lighter.data.end(), uint8_t{130});
  const auto lightness = [](int code) { return 116 * std::cbrt(srgb_to_linear(code / 255.0)) - 16; };
  const double step = 0.95 / 16.51044 * std::pow(lightness(130) - lightness(120), 0.7);
  for (const float v : flip_map(grey, lighter).data) EXPECT_NEAR(v, step, 2e-5);
}

TEST(Flip, PooledByHand) {
  ImageF map(5, 1, 1);
  map.data = {0.4F, 0.1F, 0.3F, 0.0F, 0.2F};
  const FlipPooled pooled = flip_pooled(map);
  EXPECT_NEAR(pooled.mean, 0.2, 1e-7);
  // Ascending sums: 0, 0.1, 0.3, 0.6, 1.
  EXPECT_EQ(pooled.q1, 0.2F);
  EXPECT_EQ(pooled.weighted_median, 0.3F);
  EXPECT_EQ(pooled.q3, 0.4F);
  EXPECT_EQ(pooled.min, 0);
  EXPECT_EQ(pooled.max, 0.4F);
  const FlipPooled zero = flip_pooled(ImageF(3, 3, 1));
  EXPECT_EQ(zero.mean + zero.q1 + zero.weighted_median + zero.q3 + zero.min + zero.max, 0);
}

// The drawers by which quantiles are found give what sorting gives.
TEST(Flip, QuantilesAreThoseOfASort) {
  for (uint64_t seed = 1; seed <= 5; ++seed) {
    ImageF map(37, 29, 1);
    for (size_t i = 0; i < map.data.size(); ++i)
      map.data[i] = std::pow(static_cast<float>(random_below(seed, i, 1, 1000)) / 1000, static_cast<float>(seed));
    std::vector<float> sorted = map.data;
    std::sort(sorted.begin(), sorted.end());
    double total = 0;
    for (const float v : sorted) total += v;
    const auto quantile = [&](double q) {
      double sum = 0;
      for (const float v : sorted)
        if ((sum += v) > q * total) return v;
      return sorted.back();
    };
    const FlipPooled pooled = flip_pooled(map);
    EXPECT_EQ(pooled.q1, quantile(0.25)) << seed;
    EXPECT_EQ(pooled.weighted_median, quantile(0.5)) << seed;
    EXPECT_EQ(pooled.q3, quantile(0.75)) << seed;
  }
}

// ---- the scores ----

TEST(FlipScore, IsPooledAndOfTheDisplayAndOfAgents) {
  const Image8 a = noise(40, 30, 1);
  Image8 b = a;
  for (int y = 10; y < 20; ++y)
    for (int x = 5; x < 15; ++x) b.at(x, y)[1] = static_cast<uint8_t>(255 - b.at(x, y)[1]);
  ScoreInput input;
  input.reference.codes = &a;
  input.test.codes = &b;
  const auto flip_of = [](const ScoreInput& of, Shared& shared) {
    for (const Scored& one : score_pictures(scores(), of, shared))
      if (one.score->name == "flip") return one;
    return Scored{};
  };
  Shared shared;
  const Scored at_default = flip_of(input, shared);
  ASSERT_TRUE(at_default.score);
  std::vector<std::string> names;
  for (const ScoreFigure& of : at_default.result.pooled) names.push_back(of.name);
  EXPECT_EQ(names, (std::vector<std::string>{"mean", "weighted_median", "q1", "q3", "min", "max"}));
  EXPECT_EQ(at_default.result.value, flip_pooled(flip_map(a, b)).mean);
  Display display;
  display.pixels_per_degree = 20;
  input.display = &display;
  Shared near;
  EXPECT_EQ(flip_of(input, near).result.value, flip_pooled(flip_map(a, b, {20, 0})).mean);
  display.pixels_per_degree = 0.5;
  Shared none;
  EXPECT_NE(flip_of(input, none).result.reason.find("less than one pixel"), std::string::npos);
  input.display = nullptr;
  const AgentPixels inside{1, {{7, 12}, {8, 12}}};
  const AgentPixels outside{2, {{38, 28}}};
  const ImageF map = flip_map(a, b);
  EXPECT_NEAR(at_default.score->by_agent(input, shared, inside).value(), (*map.at(7, 12) + *map.at(8, 12)) / 2.0, 1e-7);
  EXPECT_EQ(at_default.score->by_agent(input, shared, outside), 0);
}

TEST(FlipScore, MapsInEveryColour) {
  const Image8 a = noise(40, 30, 1);
  const Image8 b = noise(40, 30, 2);
  ScoreInput input;
  input.reference.codes = &a;
  input.test.codes = &b;
  input.maps = true;
  Shared shared;
  for (const Scored& one : score_pictures(scores(), input, shared)) {
    if (!one.result.map) continue;
    SCOPED_TRACE(one.score->name);
    const Image8 error = map_picture(*one.score, one.result, MapColours::error);
    const Image8 magma = map_picture(*one.score, one.result, MapColours::magma);
    const Image8 viridis = map_picture(*one.score, one.result, MapColours::viridis);
    for (const Image8* picture : {&error, &magma, &viridis}) {
      EXPECT_EQ(picture->channels, 3);
      EXPECT_EQ(picture->height, error.height);
      EXPECT_GT(picture->height, one.result.map->values.height + 50) << "the colour bar";
    }
    EXPECT_NE(magma, error);
    EXPECT_NE(viridis, magma);
  }
}

// Every step of a uniform table is lighter than the one before, in CIE lightness.
TEST(ColourTables, GetLighterAllTheWay) {
  for (const ColourTable* table : {&magma_colours(), &viridis_colours()}) {
    double before = -1;
    for (const auto& [r, g, b] : *table) {
      const double y =
          0.2126 * srgb_to_linear(r / 255.0) + 0.7152 * srgb_to_linear(g / 255.0) + 0.0722 * srgb_to_linear(b / 255.0);
      EXPECT_GT(std::cbrt(y), before - 2e-3);
      before = std::cbrt(y);
    }
  }
}

}  // namespace
}  // namespace crowdbench::metrics
