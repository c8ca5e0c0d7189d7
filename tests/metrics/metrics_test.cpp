// Each metric: identity, and an image small enough to work out by hand. Outside oracles: ground_truth_test.cpp.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <set>
#include <vector>

#include "core/colour.h"
#include "core/error.h"
#include "core/random.h"
#include "metrics/agents.h"
#include "metrics/difference.h"
#include "metrics/figure.h"
#include "metrics/panel.h"
#include "metrics/pseudocolour.h"
#include "metrics/silhouette.h"
#include "metrics/ssim.h"
#include "metrics/tears.h"
#include "metrics/temporal.h"

namespace crowdbench::metrics {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

template <typename T>
Image<T> image(int width, int height, int channels, std::vector<T> data) {
  Image<T> out(width, height, channels);
  EXPECT_EQ(out.data.size(), data.size());
  out.data = std::move(data);
  return out;
}

Image8 noise(int width, int height, int channels, uint64_t seed) {
  Image8 out(width, height, channels);
  for (size_t i = 0; i < out.data.size(); ++i) out.data[i] = static_cast<uint8_t>(random_below(seed, i, 1, 256));
  return out;
}

// A filled rectangle.
Mask rectangle(int width, int height, int x, int y, int w, int h) {
  Mask mask(width, height, 1);
  for (int j = y; j < y + h; ++j)
    for (int i = x; i < x + w; ++i) *mask.at(i, j) = 255;
  return mask;
}

Buffers with_ids(const Image8& picture, const ImageU32& ids) {
  Buffers out;
  out.codes = &picture;
  out.ids = &ids;
  return out;
}

ImageU32 ids_of(const Mask& mask) {
  ImageU32 ids(mask.width, mask.height, 1);
  for (size_t i = 0; i < ids.data.size(); ++i) ids.data[i] = mask.data[i] != 0 ? 1 : 0;
  return ids;
}

TEST(Difference, IdenticalPicturesHaveNoneAndInfinitePsnr) {
  const Image8 a = noise(13, 7, 3, 1);
  const auto d = difference(a, a);
  ASSERT_TRUE(d);
  EXPECT_EQ(d->pixels, 91U);
  EXPECT_EQ(d->mae, 0);
  EXPECT_EQ(d->mse, 0);
  EXPECT_EQ(d->psnr, kInfinity);
  EXPECT_EQ(d->worst, 0);
}

TEST(Difference, TwoPixelsByHand) {
  // Differences 3, 0, 0 and 0, 1, 9: sum 13, squares 91, over 6 samples.
  const Image8 a = image<uint8_t>(2, 1, 3, {10, 20, 30, 40, 50, 60});
  const Image8 b = image<uint8_t>(2, 1, 3, {13, 20, 30, 40, 49, 51});
  const auto d = difference(a, b);
  EXPECT_DOUBLE_EQ(d->mae, 13.0 / 6);
  EXPECT_DOUBLE_EQ(d->mse, 91.0 / 6);
  EXPECT_DOUBLE_EQ(d->psnr, 10 * std::log10(65025.0 / (91.0 / 6)));
  EXPECT_EQ(d->worst, 9);
  EXPECT_EQ(d->worst_x, 1);
  EXPECT_EQ(d->worst_y, 0);
  EXPECT_EQ(absolute_difference(a, b), (image<uint8_t>(2, 1, 3, {3, 0, 0, 0, 1, 9})));
  EXPECT_EQ(error_levels(a, b), (image<uint8_t>(2, 1, 1, {1, 3})));  // 3/3 and 10/3
  const Mask second = image<uint8_t>(2, 1, 1, {0, 1});
  EXPECT_DOUBLE_EQ(difference(a, b, &second)->mae, 10.0 / 3);
  const Mask none(2, 1, 1);
  EXPECT_FALSE(difference(a, b, &none));
}

TEST(Difference, BlackAgainstWhiteIsTheMost) {
  Image8 white(4, 4, 3);
  std::fill(white.data.begin(), white.data.end(), uint8_t{255});
  const auto d = difference(Image8(4, 4, 3), white);
  EXPECT_EQ(d->mae, 255);
  EXPECT_EQ(d->mse, 65025);
  EXPECT_EQ(d->psnr, 0);
}

TEST(Difference, GreyIsRepeatedAndAlphaIsIgnored) {
  const Image8 grey = image<uint8_t>(1, 1, 1, {100});
  const Image8 rgba = image<uint8_t>(1, 1, 4, {101, 102, 103, 7});
  EXPECT_DOUBLE_EQ(difference(grey, rgba)->mae, 2);
  EXPECT_EQ(absolute_difference(rgba, grey), (image<uint8_t>(1, 1, 3, {1, 2, 3})));
}

TEST(Difference, SixteenBitsAreScaledUnrounded) {
  const Image16 a = image<uint16_t>(1, 1, 1, {1000});
  const Image16 b = image<uint16_t>(1, 1, 1, {1001});
  EXPECT_DOUBLE_EQ(difference(a, b)->mae, 1 / 257.0);
  EXPECT_DOUBLE_EQ(difference(a, b)->mse, 1 / (257.0 * 257.0));
  EXPECT_DOUBLE_EQ(luma601(a).data[0], 1000 / 257.0);
  EXPECT_EQ(absolute_difference(a, image<uint16_t>(1, 1, 1, {1000 + 2 * 257 + 129})).data[0], 3);
  EXPECT_EQ(widen(image<uint8_t>(1, 1, 1, {200})).data[0], 51400);
}

TEST(Difference, SizesMustAgree) {
  EXPECT_THROW(difference(Image8(2, 3, 3), Image8(3, 2, 3)), Error);
  EXPECT_THROW(ssim(Plane(20, 20, 1), Plane(20, 21, 1)), Error);
  EXPECT_THROW(gmsd(Plane(20, 20, 1), Plane(20, 21, 1)), Error);
  EXPECT_THROW(silhouette_iou(Mask(2, 2, 1), Mask(2, 3, 1)), Error);
  const ImageU32 ids(2, 2, 1);
  const ImageU32 other_ids(2, 1, 1);
  const Image8 picture(2, 2, 3);
  Shared shared;
  EXPECT_THROW(score_agents(scores(), {with_ids(picture, ids), with_ids(picture, other_ids)}, shared), Error);
}

TEST(Difference, LinearErrorsOfFloats) {
  const ImageF a = image<float>(2, 1, 1, {1, 2});
  const ImageF b = image<float>(2, 1, 1, {4, -2});
  EXPECT_DOUBLE_EQ(linear_difference(a, b).mae, 3.5);
  EXPECT_DOUBLE_EQ(linear_difference(a, b).rms, std::sqrt(12.5));
  const float inf = std::numeric_limits<float>::infinity();
  EXPECT_EQ(linear_difference(image<float>(2, 1, 1, {inf, 1}), image<float>(2, 1, 1, {inf, 1})).mae, 0);
  EXPECT_EQ(linear_difference(image<float>(2, 1, 1, {inf, 1}), image<float>(2, 1, 1, {5, 1})).mae, kInfinity);
}

TEST(Over, IsSourceOverOnEncodedValues) {
  // Alpha 128/255 over 100: (200 * 128 + 100 * 127) / 255 = 150.196; 0 gives 49.804, 255 gives 177.804. Rounded down.
  const Image8 a = image<uint8_t>(3, 1, 4, {200, 0, 255, 128, 9, 9, 9, 0, 1, 2, 3, 255});
  EXPECT_EQ(over(a, {100, 100, 100}), (image<uint8_t>(3, 1, 3, {150, 49, 177, 100, 100, 100, 1, 2, 3})));
  EXPECT_EQ(over(image<uint8_t>(1, 1, 1, {77}), {1, 2, 3}), (image<uint8_t>(1, 1, 3, {77, 77, 77})));
  // Sixteen bits at the same point: 51400 * 32896 + 25700 * 32639 over 65535 * 257.
  EXPECT_EQ(over(image<uint16_t>(1, 1, 4, {51400, 0, 65535, 32896}), {100, 100, 100}),
            (image<uint8_t>(1, 1, 3, {150, 49, 177})));
  EXPECT_EQ(over(a, {100, 100, 100}, OverRounding::nearest),
            (image<uint8_t>(3, 1, 3, {150, 50, 178, 100, 100, 100, 1, 2, 3})));
}

TEST(Ssim, IdenticalPicturesScoreOne) {
  const Plane a = luma601(noise(31, 23, 3, 4));
  const auto s = ssim(a, a);
  ASSERT_TRUE(s);
  EXPECT_NEAR(s->mean, 1, 1e-12);
  EXPECT_NEAR(s->contrast, 1, 1e-12);
  EXPECT_EQ(s->map.width, 21);
  EXPECT_EQ(s->map.height, 13);
}

TEST(Ssim, TwoFlatPicturesByHand) {
  // No variance: only the means count, (2 * 100 * 150 + C1) / (100^2 + 150^2 + C1), C1 = 6.5025.
  Plane a(11, 11, 1);
  Plane b(11, 11, 1);
  std::fill(a.data.begin(), a.data.end(), 100.0);
  std::fill(b.data.begin(), b.data.end(), 150.0);
  const auto s = ssim(a, b);
  ASSERT_TRUE(s);
  EXPECT_EQ(s->map.pixels(), 1U);
  EXPECT_NEAR(s->mean, (30000 + 6.5025) / (32500 + 6.5025), 1e-9);
  EXPECT_NEAR(s->contrast, 1, 1e-9);
}

TEST(Ssim, OnePointInTheWindowByHand) {
  // a is 0 but for one pixel of value v at the window's centre, whose weight is w; b = 0. Then mu_a = w v,
  // s_a = w v^2 - (w v)^2, all else 0.
  double norm = 0;
  for (int y = -5; y <= 5; ++y)
    for (int x = -5; x <= 5; ++x) norm += std::exp(-(x * x + y * y) / 4.5);
  const double v = 255;
  const double mu = v / norm;
  const double variance = v * v / norm - mu * mu;
  Plane a(11, 11, 1);
  *a.at(5, 5) = v;
  const auto s = ssim(a, Plane(11, 11, 1));
  EXPECT_NEAR(s->mean, 6.5025 / (mu * mu + 6.5025) * 58.5225 / (variance + 58.5225), 1e-12);
}

// 13 x 11 pixels hold three windows, at x = 5, 6 and 7 of row 5. a = 0; b = 0 but for one pixel of value v in column 0,
// which the first window alone sees, at its left edge, with the weight w = exp(-25 / 4.5) / sum. There mu_b = w v and
// s_b = w v^2 - (w v)^2, so that its SSIM is C1 / (mu_b^2 + C1) * C2 / (s_b + C2); the other two are 1.
TEST(Ssim, OfARegionByHand) {
  double norm = 0;
  for (int y = -5; y <= 5; ++y)
    for (int x = -5; x <= 5; ++x) norm += std::exp(-(x * x + y * y) / 4.5);
  const double w = std::exp(-25 / 4.5) / norm;
  const double mu = w * 200;
  const double variance = w * 200 * 200 - mu * mu;
  const double first = 6.5025 / (mu * mu + 6.5025) * 58.5225 / (variance + 58.5225);
  EXPECT_LT(first, 0.9) << "it shows";
  const Image8 a(13, 11, 1);
  Image8 b = a;
  *b.at(0, 5) = 200;
  const auto score = [&](const Mask& region, bool by_agent) -> std::optional<double> {
    const ImageU32 ids = ids_of(region);
    ScoreInput input{with_ids(a, ids), with_ids(b, ids)};
    input.region = &region;
    Shared shared;
    if (by_agent) {
      const AgentScores agents = score_agents(scores(), input, shared);
      for (size_t s = 0; s < agents.scores.size(); ++s)
        if (agents.scores[s]->name == "ssim_union") return agents.agents.at(0).values[s];
      return std::nullopt;
    }
    for (const Scored& one : score_pictures(scores(), input, shared))
      if (one.score->name == "ssim_union") return one.result.value;
    return std::nullopt;
  };
  for (const bool by_agent : {false, true}) {
    // One window, two of them, all three; what lies beside the windows, the changed pixel too, adds nothing.
    EXPECT_NEAR(score(rectangle(13, 11, 5, 5, 1, 1), by_agent).value(), first, 1e-12);
    EXPECT_NEAR(score(rectangle(13, 11, 0, 3, 7, 6), by_agent).value(), (first + 1) / 2, 1e-12);
    EXPECT_NEAR(score(rectangle(13, 11, 0, 0, 13, 11), by_agent).value(), (first + 2) / 3, 1e-12);
    EXPECT_NEAR(score(rectangle(13, 11, 6, 5, 7, 1), by_agent).value(), 1, 1e-12);
    EXPECT_FALSE(score(rectangle(13, 11, 0, 0, 5, 11), by_agent)) << "no window has its centre there";
  }
}

TEST(Ssim, DoesNotExistBelowElevenPixels) {
  EXPECT_FALSE(ssim(Plane(10, 40, 1), Plane(10, 40, 1)));
  EXPECT_FALSE(ssim(Plane(40, 10, 1), Plane(40, 10, 1)));
  EXPECT_TRUE(ssim(Plane(11, 11, 1), Plane(11, 11, 1)));
}

TEST(MsSsim, IdentitySizesAndOrder) {
  const Plane a = luma601(noise(180, 177, 1, 5));
  EXPECT_NEAR(*ms_ssim(a, a), 1, 1e-12);
  EXPECT_FALSE(ms_ssim(Plane(175, 300, 1), Plane(175, 300, 1)));
  // A constant offset leaves every contrast term at 1; only the coarsest scale's mean factor counts.
  Plane flat_a(176, 176, 1);
  Plane flat_b(176, 176, 1);
  std::fill(flat_a.data.begin(), flat_a.data.end(), 100.0);
  std::fill(flat_b.data.begin(), flat_b.data.end(), 150.0);
  EXPECT_NEAR(*ms_ssim(flat_a, flat_b), std::pow((30000 + 6.5025) / (32500 + 6.5025), 0.1333), 1e-9);
  // An inverted picture has negative contrast terms: 0, never a number without meaning.
  Plane inverted = a;
  for (double& v : inverted.data) v = 255 - v;
  EXPECT_EQ(*ms_ssim(a, inverted), 0);
  const auto first = ssim(a, inverted);
  EXPECT_EQ(*ms_ssim(a, inverted, &*first), 0);
}

TEST(Gmsd, IdentityAndAStepByHand) {
  const Plane a = luma601(noise(17, 9, 1, 6));
  EXPECT_EQ(gmsd(a, a), 0);
  EXPECT_EQ(gmsd(Plane(1, 1, 1), Plane(1, 1, 1)), 0);
  // 4 x 2 pixels halve to 2 x 1: b = (30, 0), a = 0. Zeros beyond the border: the gradients of b are horizontal (0 -
  // 0)/3 and (0 - 30)/3, vertical 0 (no row above or below) in both. So magnitudes 0 and 10, similarities 1 and 170 /
  // (100 + 170); the deviation of two values is their difference over sqrt(2).
  Plane b(4, 2, 1);
  for (const int x : {0, 1})
    for (const int y : {0, 1}) *b.at(x, y) = 30;
  EXPECT_NEAR(gmsd(Plane(4, 2, 1), b), (1 - 170.0 / 270.0) / std::sqrt(2.0), 1e-12);
}

TEST(Silhouette, IouByHand) {
  const Mask a = rectangle(10, 10, 0, 0, 4, 4);
  const Mask b = rectangle(10, 10, 2, 2, 4, 4);
  EXPECT_DOUBLE_EQ(*silhouette_iou(a, a), 1);
  EXPECT_DOUBLE_EQ(*silhouette_iou(a, b), 4.0 / 28.0);
  EXPECT_DOUBLE_EQ(*silhouette_iou(a, Mask(10, 10, 1)), 0);
  EXPECT_FALSE(silhouette_iou(Mask(10, 10, 1), Mask(10, 10, 1)));
}

TEST(Silhouette, BoundaryDistanceOfAShiftedSquare) {
  const Mask a = rectangle(40, 40, 10, 10, 9, 9);
  EXPECT_DOUBLE_EQ(boundary_distance(a, a)->mean, 0);
  EXPECT_DOUBLE_EQ(boundary_distance(a, a)->p95, 0);
  // One pixel squares d apart: both distances are d, whatever the direction.
  const auto d = boundary_distance(rectangle(40, 40, 5, 5, 1, 1), rectangle(40, 40, 8, 9, 1, 1));
  EXPECT_NEAR(d->mean, 5, 1e-5);
  EXPECT_NEAR(d->p95, 5, 1e-5);
  // A 9 x 9 square shifted by one to the right. Of its 32 boundary pixels the 7 inner ones of the left side are 1 off,
  // the right side's 7 lie inside the other's ring: 1 off as well; the top and bottom rows but for the left corners
  // coincide (16), and those two corners are 1 off. 16 of 32 are 1 off, from both sides: mean 0.5.
  const auto shifted = boundary_distance(a, rectangle(40, 40, 11, 10, 9, 9));
  EXPECT_NEAR(shifted->mean, 0.5, 1e-6);
  EXPECT_NEAR(shifted->p95, 1, 1e-6);
  EXPECT_FALSE(boundary_distance(a, Mask(40, 40, 1)));
}

TEST(Silhouette, ThePicturesEdgeIsNoBoundary) {
  // Both figures are cut by the left edge; they differ by one column on the right.
  const auto d = boundary_distance(rectangle(10, 4, 0, 0, 5, 4), rectangle(10, 4, 0, 0, 6, 4));
  ASSERT_TRUE(d);
  EXPECT_NEAR(d->mean, 1, 1e-6);
  EXPECT_FALSE(boundary_distance(rectangle(4, 4, 0, 0, 4, 4), rectangle(4, 4, 0, 0, 2, 4)));
}

TEST(Silhouette, CropIsWidenedAndCut) {
  const auto box = crop_box(rectangle(40, 30, 10, 2, 4, 4), rectangle(40, 30, 33, 8, 2, 3));
  ASSERT_TRUE(box);
  EXPECT_EQ(box->x, 5);
  EXPECT_EQ(box->y, 0);
  EXPECT_EQ(box->width, 35);   // 5 .. 39: 34 + 5 is the last column
  EXPECT_EQ(box->height, 16);  // 0 .. 15
  EXPECT_FALSE(crop_box(Mask(4, 4, 1), Mask(4, 4, 1)));
}

TEST(Figure, IdenticalFiguresAndNothingDrawn) {
  const Image8 a = noise(60, 50, 3, 8);
  const ImageU32 ids = ids_of(rectangle(60, 50, 20, 15, 12, 20));
  const FigureScores same = score_figure(scores(), with_ids(a, ids), with_ids(a, ids));
  EXPECT_DOUBLE_EQ(same.value("silhouette_iou").value(), 1);
  EXPECT_DOUBLE_EQ(same.value("boundary_px_mean").value(), 0);
  EXPECT_NEAR(same.value("ssim").value(), 1, 1e-12);
  EXPECT_NEAR(same.value("ssim_union").value(), 1, 1e-12);
  EXPECT_EQ(same.value("psnr"), kInfinity);
  EXPECT_EQ(same.value("mae"), 0);
  ASSERT_TRUE(same.box);
  EXPECT_EQ(same.box->width, 12 + 2 * kCropMargin);
  const ImageU32 none(60, 50, 1);
  const FigureScores nothing = score_figure(scores(), with_ids(a, none), with_ids(a, none));
  EXPECT_FALSE(nothing.box);
  ASSERT_EQ(nothing.scores.size(), same.scores.size()) << "the same columns, whatever is drawn";
  for (const Scored& one : nothing.scores) {
    EXPECT_FALSE(one.result.value) << one.score->name;
    EXPECT_EQ(one.result.reason, "nothing is drawn in either picture");
  }
}

TEST(Figure, ScoresAreOverTheUnionAndTheCropOnly) {
  Image8 a = noise(80, 60, 3, 9);
  Image8 b = a;
  const ImageU32 in_a = ids_of(rectangle(80, 60, 20, 20, 10, 12));
  const ImageU32 in_b = ids_of(rectangle(80, 60, 22, 20, 10, 12));
  // Inside the union (12 x 12 at 20, 20): every red is 6 off. Far outside: garbage, which must not count.
  for (int y = 20; y < 32; ++y)
    for (int x = 20; x < 32; ++x) {
      a.at(x, y)[0] = 100;
      b.at(x, y)[0] = 106;
    }
  for (int x = 0; x < 80; ++x) b.at(x, 59)[1] ^= 0xff;
  const FigureScores s = score_figure(scores(), with_ids(a, in_a), with_ids(b, in_b));
  EXPECT_DOUBLE_EQ(s.value("silhouette_iou").value(), 8.0 / 12.0);
  EXPECT_DOUBLE_EQ(s.value("mae").value(), 2);
  EXPECT_DOUBLE_EQ(s.value("psnr").value(), 10 * std::log10(65025.0 / 12.0));
  // The crop is 22 x 22 at (15, 15), its valid region the 12 x 12 pixels of the union: here the two are the same.
  const Box box{15, 15, 22, 22};
  EXPECT_NEAR(s.value("ssim").value(), ssim(luma601(crop(a, box)), luma601(crop(b, box)))->mean, 1e-12);
  EXPECT_NEAR(s.value("ssim_union").value(), s.value("ssim").value(), 1e-12);
  EXPECT_LT(s.value("ssim").value(), 1);
}

// The value of one agent's score; nothing where it does not exist. Fails where the score is not defined for agents.
std::optional<double> of_agent(const AgentScores& all, size_t agent, std::string_view name) {
  for (size_t s = 0; s < all.scores.size(); ++s)
    if (all.scores[s]->name == name) return all.agents[agent].values[s];
  ADD_FAILURE() << name << " is not scored by agent";
  return std::nullopt;
}

// A square of four pixels a side and the same three to the right and one down: the far corners lie sqrt(10) apart, and
// all other boundary pixels are nearer.
TEST(Silhouette, HausdorffAndSymmetricDifference) {
  ImageU32 a(20, 16, 1);
  ImageU32 b(20, 16, 1);
  for (int y = 4; y < 8; ++y)
    for (int x = 5; x < 9; ++x) {
      *a.at(x, y) = 7;
      *b.at(x + 3, y + 1) = 7;
    }
  *a.at(19, 15) = *b.at(19, 15) = 9;  // another agent, equal and cut off by the corner
  EXPECT_EQ(symmetric_difference(mask_of(a), mask_of(b)), 2U * (16 - 3));
  EXPECT_EQ(symmetric_difference(mask_of(a), mask_of(a)), 0U);
  ScoreInput input;
  input.reference.ids = &a;
  input.test.ids = &b;
  Shared shared;
  for (const Scored& one : score_pictures(scores(), input, shared)) {
    if (one.score->name == "silhouette_hausdorff_px") {
      EXPECT_NEAR(*one.result.value, std::sqrt(10.0), 1e-6);
    }
    if (one.score->name == "silhouette_difference_px") {
      EXPECT_EQ(one.result.value, 26.0);
    }
  }
  const AgentScores agents = score_agents(scores(), input, shared);
  ASSERT_EQ(agents.agents.size(), 2U);
  for (size_t s = 0; s < agents.scores.size(); ++s) {
    if (agents.scores[s]->name == "silhouette_hausdorff_px") {
      EXPECT_NEAR(agents.agents[0].values[s].value(), std::sqrt(10.0), 1e-6);
      EXPECT_EQ(agents.agents[1].values[s], 0.0) << "its left and upper neighbours make it a boundary";
    }
    if (agents.scores[s]->name == "silhouette_difference_px") {
      EXPECT_EQ(agents.agents[0].values[s], 26.0);
      EXPECT_EQ(agents.agents[1].values[s], 0.0);
    }
  }
}

// A figure of 8 x 6 pixels: what is missing at its edge is no hole, what is added next to it, corners included, is no
// stray.
TEST(Tears, ByHand) {
  Mask reference(20, 16, 1);
  for (int y = 4; y < 10; ++y)
    for (int x = 5; x < 13; ++x) *reference.at(x, y) = 255;
  Mask test = reference;
  EXPECT_EQ(tears(reference, test)->holes, 0);
  EXPECT_EQ(tears(reference, test)->strays, 0);
  *test.at(5, 4) = *test.at(8, 4) = *test.at(12, 7) = 0;     // its edge
  *test.at(4, 3) = *test.at(8, 3) = *test.at(13, 10) = 255;  // around it
  EXPECT_EQ(tears(reference, test)->holes, 0);
  EXPECT_EQ(tears(reference, test)->strays, 0);
  *test.at(6, 5) = *test.at(11, 8) = *test.at(8, 6) = 0;  // one pixel inside, and deeper
  *test.at(3, 3) = *test.at(14, 10) = 255;                // one pixel farther
  *test.at(0, 0) = *test.at(19, 15) = *test.at(8, 2) = 255;
  EXPECT_DOUBLE_EQ(tears(reference, test)->holes, 3 * 1000.0 / 48);
  EXPECT_DOUBLE_EQ(tears(reference, test)->strays, 5 * 1000.0 / 48);
}

TEST(Tears, EdgesOfThePictureAndNothing) {
  // A figure that the picture's corner cuts: its pixels there are inside of it.
  Mask reference(4, 4, 1);
  for (int y = 0; y < 2; ++y)
    for (int x = 0; x < 2; ++x) *reference.at(x, y) = 255;
  Mask test = reference;
  *test.at(0, 0) = 0;
  EXPECT_DOUBLE_EQ(tears(reference, test)->holes, 250);
  *test.at(1, 1) = 0;
  EXPECT_DOUBLE_EQ(tears(reference, test)->holes, 250) << "its edge";
  // Nothing drawn is all hole but for the edge; everything drawn is all stray.
  EXPECT_DOUBLE_EQ(tears(reference, Mask(4, 4, 1))->holes, 250);
  Mask full(4, 4, 1);
  std::fill(full.data.begin(), full.data.end(), uint8_t{255});
  EXPECT_DOUBLE_EQ(tears(full, Mask(4, 4, 1))->holes, 1000);
  EXPECT_DOUBLE_EQ(tears(reference, full)->strays, 7 * 250.0);
  EXPECT_FALSE(tears(Mask(4, 4, 1), full)) << "per mille of nothing";
  EXPECT_THROW(tears(full, Mask(4, 5, 1)), Error);
  // Thin as a pixel, a figure has no inside that could be left out.
  Mask line(8, 8, 1);
  for (int x = 1; x < 7; ++x) *line.at(x, 3) = 255;
  EXPECT_EQ(tears(line, Mask(8, 8, 1))->holes, 0);
}

// Where another agent covers one there is a hole in it, though not in the picture.
TEST(Tears, OfAgents) {
  ImageU32 a(20, 16, 1);
  ImageU32 b(20, 16, 1);
  for (int y = 4; y < 8; ++y)
    for (int x = 5; x < 15; ++x) *a.at(x, y) = *b.at(x, y) = x < 10 ? 7 : 9;
  *b.at(7, 6) = 9;    // a hole of 7, and a stray of 9 whose picture it is
  *b.at(12, 12) = 9;  // a stray of 9
  *b.at(14, 8) = 9;   // beside 9
  ScoreInput input;
  input.reference.ids = &a;
  input.test.ids = &b;
  Shared shared;
  const AgentScores agents = score_agents(scores(), input, shared);
  ASSERT_EQ(agents.agents.size(), 2U);
  size_t seen = 0;
  for (size_t s = 0; s < agents.scores.size(); ++s) {
    const bool holes = agents.scores[s]->name == "holes";
    if (!holes && agents.scores[s]->name != "strays") continue;
    ++seen;
    EXPECT_EQ(agents.agents[0].values[s], holes ? 50.0 : 0.0);
    EXPECT_EQ(agents.agents[1].values[s], holes ? 0.0 : 100.0);
  }
  EXPECT_EQ(seen, 2U);
  for (const Scored& one : score_pictures(scores(), input, shared)) {
    if (one.score->name == "holes") {
      EXPECT_EQ(one.result.value, 0.0) << "covered, whoever it is";
    }
    if (one.score->name == "strays") {
      EXPECT_EQ(one.result.value, 25.0);
    }
  }
}

// Against every pair of boundary pixels, on blobs.
TEST(Silhouette, HausdorffIsThatOfAllPairs) {
  const auto blob = [](uint64_t seed) {
    Mask mask(40, 30, 1);
    for (int k = 0; k < 6; ++k) {
      const auto at = [&](uint64_t purpose, uint64_t n) {
        return static_cast<int>(random_below(seed, static_cast<uint64_t>(k), purpose, n));
      };
      const int left = 3 + at(1, 25);
      const int top = 3 + at(2, 15);
      for (int y = top; y < top + 3 + at(3, 6); ++y)
        for (int x = left; x < left + 3 + at(4, 6); ++x) *mask.at(x, y) = 255;
    }
    return mask;
  };
  for (uint64_t seed = 1; seed <= 5; ++seed) {
    const Mask a = blob(seed);
    const Mask b = blob(seed + 100);
    const auto boundary = [](const Mask& mask) {
      std::vector<std::pair<int, int>> out;
      for (int y = 1; y + 1 < mask.height; ++y)
        for (int x = 1; x + 1 < mask.width; ++x)
          if (*mask.at(x, y) != 0 && (*mask.at(x - 1, y) == 0 || *mask.at(x + 1, y) == 0 || *mask.at(x, y - 1) == 0 ||
                                      *mask.at(x, y + 1) == 0))
            out.emplace_back(x, y);
      return out;
    };
    double greatest = 0;
    for (const auto& [from, to] : {std::pair(boundary(a), boundary(b)), std::pair(boundary(b), boundary(a))})
      for (const auto& [x, y] : from) {
        double nearest = std::numeric_limits<double>::infinity();
        for (const auto& [u, v] : to) nearest = std::min(nearest, std::hypot(x - u, y - v));
        greatest = std::max(greatest, nearest);
      }
    EXPECT_NEAR(boundary_distance(a, b)->greatest, greatest, 1e-5) << seed;
  }
}

TEST(Agents, EachAgentIsScoredOverItsOwnUnion) {
  // Agent 7: pixels 0, 1 in the reference, 1, 2 in the test; agent 4000000000 only in the test, at pixel 3; agent 2 at
  // pixel 4 in both. Differences of the pixels: 0, 3, 6, 9, 0 in every channel.
  const Image8 a = image<uint8_t>(6, 1, 1, {50, 50, 50, 50, 50, 50});
  const Image8 b = image<uint8_t>(6, 1, 1, {50, 53, 56, 59, 50, 99});
  const ImageU32 ids_a = image<uint32_t>(6, 1, 1, {7, 7, 0, 0, 2, 0});
  const ImageU32 ids_b = image<uint32_t>(6, 1, 1, {0, 7, 7, 4000000000U, 2, 0});
  const ImageF depth_a = image<float>(6, 1, 1, {1, 2, 3, 4, 5, 6});
  const ImageF depth_b = image<float>(6, 1, 1, {1, 2.5, 3, 4, 5, 6});
  ScoreInput input{with_ids(a, ids_a), with_ids(b, ids_b)};
  input.reference.depth = &depth_a;
  input.test.depth = &depth_b;
  Shared shared;
  const AgentScores all = score_agents(scores(), input, shared);
  ASSERT_EQ(all.agents.size(), 3U);
  EXPECT_EQ(all.agents[0].id, 2U);
  EXPECT_EQ(of_agent(all, 0, "silhouette_iou"), 1);
  EXPECT_EQ(of_agent(all, 0, "psnr"), kInfinity);
  EXPECT_EQ(all.agents[1].id, 7U);
  EXPECT_EQ(all.agents[1].pixels_ref, 2U);
  EXPECT_EQ(all.agents[1].pixels_test, 2U);
  EXPECT_EQ(all.agents[1].pixels_both, 1U);
  EXPECT_DOUBLE_EQ(of_agent(all, 1, "silhouette_iou").value(), 1.0 / 3);
  EXPECT_DOUBLE_EQ(of_agent(all, 1, "mae").value(), 3);
  EXPECT_DOUBLE_EQ(of_agent(all, 1, "mse").value(), 15);
  EXPECT_DOUBLE_EQ(of_agent(all, 1, "depth_mae").value(), 0.5);
  EXPECT_FALSE(of_agent(all, 1, "ssim_union"));  // one row has no SSIM
  EXPECT_EQ(all.agents[2].id, 4000000000U);
  EXPECT_EQ(all.agents[2].pixels_ref, 0U);
  EXPECT_EQ(of_agent(all, 2, "silhouette_iou"), 0);
  EXPECT_DOUBLE_EQ(of_agent(all, 2, "mae").value(), 9);
  EXPECT_FALSE(of_agent(all, 2, "depth_mae"));
  // Of all together: pixels 1 and 4 carry the same agent in both, half a metre and none apart.
  const auto whole = score_pictures(scores(), input, shared);
  const auto depth =
      std::find_if(whole.begin(), whole.end(), [](const Scored& s) { return s.score->name == "depth_mae"; });
  ASSERT_NE(depth, whole.end());
  EXPECT_DOUBLE_EQ(depth->result.value.value(), 0.25);
}

TEST(Agents, DepthsThatAreNoFiniteNumbersAreNoError) {
  const ImageU32 ids = []() {
    ImageU32 image(3, 1, 1);
    image.data = {1, 1, 2};
    return image;
  }();
  ImageF depth(3, 1, 1);
  depth.data = {4, 5, 6};
  const auto scored = [&](float broken) {
    ImageF test = depth;
    test.data[1] = broken;
    Buffers reference_side, test_side;
    reference_side.ids = &ids, reference_side.depth = &depth;
    test_side.ids = &ids, test_side.depth = &test;
    const ScoreInput input{.reference = reference_side, .test = test_side};
    Shared shared;
    const AgentScores agents = score_agents(scores(), input, shared);
    EXPECT_FALSE(of_agent(agents, 0, "depth_mae"));
    EXPECT_EQ(of_agent(agents, 1, "depth_mae"), 0);
    const auto whole = score_pictures(scores(), input, shared);
    const auto found =
        std::find_if(whole.begin(), whole.end(), [](const Scored& s) { return s.score->name == "depth_mae"; });
    EXPECT_FALSE(found->result.value);
    return found->result.reason;
  };
  EXPECT_EQ(
      scored(kInfinity),
      "depths of 1 pixel are not finite numbers where both show one agent, the first at (1, 0): reference 5, test inf");
  EXPECT_NE(scored(std::numeric_limits<float>::quiet_NaN()).find("test nan"), std::string::npos);
}

TEST(Agents, SsimOfAnAgentIsTheMapOverItsPixels) {
  const Image8 a = noise(30, 30, 3, 1);
  const Image8 b = noise(30, 30, 3, 2);
  ImageU32 ids(30, 30, 1);
  *ids.at(12, 13) = 5;
  *ids.at(2, 2) = 5;  // no window there
  const auto s = ssim(luma601(a), luma601(b));
  Shared shared;
  const AgentScores all = score_agents(scores(), {with_ids(a, ids), with_ids(b, ids)}, shared);
  ASSERT_EQ(all.agents.size(), 1U);
  EXPECT_DOUBLE_EQ(of_agent(all, 0, "ssim_union").value(), *s->map.at(7, 8));
  // Sixteen bits of the same values: the same scores.
  const Image16 wide_a = widen(a);
  const Image16 wide_b = widen(b);
  ScoreInput wide;
  wide.reference.codes16 = &wide_a;
  wide.test.codes16 = &wide_b;
  wide.reference.ids = wide.test.ids = &ids;
  Shared of_wide;
  const AgentScores same = score_agents(scores(), wide, of_wide);
  for (const char* name : {"mae", "mse", "psnr", "ssim_union"})
    EXPECT_NEAR(of_agent(same, 0, name).value(), of_agent(all, 0, name).value(), 1e-9) << name;
}

Image8 grey(uint8_t left, uint8_t right) { return image<uint8_t>(2, 1, 1, {left, right}); }

TEST(Flicker, ByHandAndOverSilhouettes) {
  // A shared movement is no flicker; a constant error is none; one frame of the test that is 10 off is 10, -20, 10.
  const std::vector<Image8> r = {grey(0, 10), grey(20, 10), grey(10, 10), grey(5, 10), grey(0, 10)};
  EXPECT_EQ(*flicker(r, r), 0);
  std::vector<Image8> t = r;
  for (Image8& frame : t) frame.data[0] = static_cast<uint8_t>(frame.data[0] + 7);
  EXPECT_NEAR(*flicker(r, t), 0, 1e-12);
  t = r;
  t[2].data[1] = 20;
  EXPECT_NEAR(*flicker(r, t), (10 + 20 + 10) / 6.0, 1e-12);
  const std::vector<Mask> left(5, grey(255, 0));
  EXPECT_NEAR(*flicker(r, t, left), 0, 1e-12);
  const std::vector<Mask> right(5, grey(0, 255));
  EXPECT_NEAR(*flicker(r, t, right), 40 / 3.0, 1e-12);
  const std::vector<Mask> none(5, grey(0, 0));
  EXPECT_FALSE(flicker(r, t, none));
  EXPECT_FALSE(flicker(std::span(r).first(2), std::span(t).first(2)));
  // By frame, over two pixels; seen through a silhouette of frame 1 alone there is none once three frames are empty.
  using Values = std::vector<std::optional<double>>;
  const auto by_frame = [&](const std::vector<Mask>& masks) {
    Flicker running;
    for (size_t i = 0; i < 5; ++i) running.take(luma601(r[i]), luma601(t[i]), masks.empty() ? nullptr : &masks[i]);
    return running.by_frame();
  };
  EXPECT_EQ(by_frame({}), (Values{{}, {}, 5.0, 10.0, 5.0}));
  std::vector<Mask> once = none;
  once[1] = grey(0, 255);
  EXPECT_EQ(by_frame(once), (Values{{}, {}, 10.0, 20.0, {}}));
  Flicker running;
  for (size_t i = 0; i < 4; ++i) running.take(luma601(r[i]), luma601(t[i]), &right[i]);
  EXPECT_TRUE(std::isnan(running.map().data[0])) << "outside of the silhouettes";
  EXPECT_NEAR(running.map().data[1], 20, 1e-12);
  // The pop shows as a step into it and a step out of it, over two pixels.
  EXPECT_EQ(step_difference(r, t), (std::vector<double>{0, 5, 5, 0}));
}

TEST(Pseudocolour, RunsFromDarkBlueToRedInOrder) {
  const auto& colours = error_colours();
  EXPECT_GT(colours[0][2], 3 * colours[0][0]);  // blue
  EXPECT_LT(colours[0][2], 100);                // and dark
  EXPECT_GT(colours[255][0], 240);
  EXPECT_LT(colours[255][1] + colours[255][2], 60);
  double last = -1;
  for (const auto& c : colours) {
    const double luminance = 0.2126 * srgb_to_linear(c[0] / 255.0) + 0.7152 * srgb_to_linear(c[1] / 255.0) +
                             0.0722 * srgb_to_linear(c[2] / 255.0);
    EXPECT_GT(luminance, last - 2e-3);  // the rounding to 8 bits
    last = std::max(last, luminance);
  }
  for (size_t i = 16; i < colours.size(); i += 16) {
    const auto luminance = [&](size_t k) {
      return 0.2126 * srgb_to_linear(colours[k][0] / 255.0) + 0.7152 * srgb_to_linear(colours[k][1] / 255.0) +
             0.0722 * srgb_to_linear(colours[k][2] / 255.0);
    };
    EXPECT_GT(luminance(i), luminance(i - 16)) << i;
  }
  // Every level has a colour of its own.
  const std::set<std::array<uint8_t, 3>> distinct(colours.begin(), colours.end());
  EXPECT_EQ(distinct.size(), 256U);
}

TEST(Pseudocolour, PictureAndBar) {
  const Image8 levels = image<uint8_t>(3, 1, 1, {0, 128, 255});
  const Image8 picture = pseudocolour(levels);
  const auto& colours = error_colours();
  for (size_t i = 0; i < 3; ++i)
    for (size_t c = 0; c < 3; ++c) EXPECT_EQ(picture.data[3 * i + c], colours[levels.data[i]][c]);
  Image8 wide(640, 20, 3);
  std::fill(wide.data.begin(), wide.data.end(), uint8_t{9});
  const Image8 with_bar = with_colour_bar(wide, "caption");
  EXPECT_EQ(with_bar.width, 640);
  EXPECT_GT(with_bar.height, 60);
  for (int x = 0; x < 640; ++x) EXPECT_EQ(with_bar.at(x, 19)[0], 9);
  // Both ends of the bar are there, and there is ink below it.
  const auto holds = [&](const std::array<uint8_t, 3>& colour) {
    for (int y = 20; y < with_bar.height; ++y)
      for (int x = 0; x < 640; ++x)
        if (std::equal(colour.begin(), colour.end(), with_bar.at(x, y))) return true;
    return false;
  };
  EXPECT_TRUE(holds(colours[0]));
  EXPECT_TRUE(holds(colours[127]));
  EXPECT_TRUE(holds(colours[255]));
  EXPECT_TRUE(holds({40, 40, 40}));
  EXPECT_EQ(with_colour_bar(Image8(1, 1, 3), "c").width, 360);
  EXPECT_NE(with_colour_bar(Image8(1, 1, 3), "c", {0, 1}), with_colour_bar(Image8(1, 1, 3), "c")) << "other labels";
  const BarRange open = {0, 1, true};
  EXPECT_NE(with_colour_bar(Image8(1, 1, 3), "c", open), with_colour_bar(Image8(1, 1, 3), "c", {0, 1})) << ">= 1";
  // A caption that is wider than the bar takes two lines.
  const std::string half(30, 'w');
  const Image8 broken = with_colour_bar(Image8(1, 1, 3), half + "; " + half);
  EXPECT_EQ(broken.width, with_colour_bar(Image8(1, 1, 3), half).width);
  EXPECT_EQ(broken.height, with_colour_bar(Image8(1, 1, 3), half).height + 16);
}

TEST(Panel, WordsStandAboveThePictureAndAreBroken) {
  Image8 picture(40, 30, 3);
  std::fill(picture.data.begin(), picture.data.end(), uint8_t{200});
  EXPECT_EQ(with_words_above(picture, {}), picture);
  const std::vector<std::string> short_words = {"ab", "c"};
  const Image8 panel = with_words_above(picture, short_words, 100);
  EXPECT_EQ(panel.width, 40);
  ASSERT_EQ(panel.height, 30 + 2 * 16 + 4);
  for (int x = 0; x < 40; ++x) EXPECT_EQ(panel.at(x, panel.height - 30)[0], 200);
  int ink = 0;
  for (int y = 0; y < panel.height - 30; ++y)
    for (int x = 0; x < 40; ++x) ink += panel.at(x, y)[0] > 128 ? 1 : 0;
  EXPECT_GT(ink, 10);
  const std::vector<std::string> names = {"impostor:views=12,frames=8,texels=64, character 60 px"};
  const Image8 broken = with_words_above(picture, names, 150);
  EXPECT_LE(broken.width, 160);
  EXPECT_GE(broken.height, 30 + 3 * 16 + 4);
  EXPECT_EQ((broken.height - 30 - 4) % 16, 0);
  // What cannot be broken is not cut off.
  const std::vector<std::string> whole = {std::string(60, 'w')};
  EXPECT_GT(with_words_above(picture, whole, 150).width, 400);
}

}  // namespace
}  // namespace crowdbench::metrics
