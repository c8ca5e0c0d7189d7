#include "bench/experiments/switch_distance.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "core/error.h"
#include "scene/mannequin/mannequin.h"

namespace crowdbench::bench {
namespace {

constexpr double kRadians = std::numbers::pi / 180;

TEST(SwitchDistance, IsTheGeometryOfTheLens) {
  // At 90 degrees the tangent is 1: a pixel of 480 rows at 3.6 m covers 2 * 3.6 / 480 = 15 mm.
  EXPECT_NEAR(derive_switch_depth(1, 0.015, 480, 90 * kRadians), 3.6, 1e-12);
  EXPECT_NEAR(derive_switch_depth(2, 0.015, 480, 90 * kRadians), 1.8, 1e-12) << "magnified texels are near ones";
  EXPECT_NEAR(derive_switch_depth(0.5, 0.015, 480, 90 * kRadians), 7.2, 1e-12);
}

TEST(SwitchDistance, EngineUnitsByHand) {
  // A box of 1 x 2 x 2 m (diagonal 3), 10 m away, 90 degrees tall: the view is 20 m tall there.
  const EngineSizes wide = engine_sizes({1, 2, 2}, 10, 90 * kRadians, 2);
  EXPECT_NEAR(wide.unity_height, 0.1, 1e-12) << "2 of 20 m";
  EXPECT_NEAR(wide.unreal_size, 0.15, 1e-12) << "the sphere's 3 of 20 m";
  EXPECT_EQ(wide.godot_metres, 10);
  // Half as wide as tall: Unreal takes the larger of the two factors, now the horizontal one.
  EXPECT_NEAR(engine_sizes({1, 2, 2}, 10, 90 * kRadians, 0.5).unreal_size, 0.3, 1e-12);
}

TEST(SwitchDistance, FootprintOfAKnownMap) {
  // u = 0.5 x + 0.1 y, v = -0.2 y: a step along x crosses 0.5 texels, one along y hypot(0.1, 0.2).
  ImageF texels(20, 16, 4);
  ImageU32 ids(20, 16, 1);
  for (int y = 0; y < 16; ++y)
    for (int x = 0; x < 20; ++x) {
      texels.at(x, y)[0] = 7.0F + 0.5F * static_cast<float>(x) + 0.1F * static_cast<float>(y);
      texels.at(x, y)[1] = -0.2F * static_cast<float>(y);
      ids.at(x, y)[0] = 1;
    }
  auto found = fit_texel_footprint(texels, ids, 10, 8, 5);
  ASSERT_TRUE(found);
  EXPECT_NEAR(found->across_x, 2.0, 1e-4);
  EXPECT_NEAR(found->across_y, 1 / std::hypot(0.1, 0.2), 1e-4);
  for (uint32_t& id : ids.data) id = 0;
  EXPECT_FALSE(fit_texel_footprint(texels, ids, 10, 8, 5)) << "nothing is drawn there";
  for (int x = 0; x < 20; ++x) ids.at(x, 8)[0] = 1;
  EXPECT_FALSE(fit_texel_footprint(texels, ids, 10, 8, 12)) << "one row says nothing about the other direction";
}

class SwitchDistanceGl : public ::testing::Test {
 protected:
  SwitchRequest request() {
    SwitchRequest r;
    r.character = std::make_shared<const scene::Character>(scene::make_mannequin({.triangles = 500}));
    r.representation = renderers::parse_spec("flat:views=sphere-4x2,frames=1,texels=64");
    r.clip = r.character->placement.default_clip;
    r.use_cache = false;
    return r;
  }
  gl::Context context_{gl::ContextOptions{}};
};

// The bound is 2 %: the fitted plane passes within centimetres of the capture centre, which is what is left.
constexpr double kBound = 0.02;

TEST_F(SwitchDistanceGl, DerivedAndMeasuredAgreeOnAndOffTheAxis) {
  struct View {
    double azimuth, elevation, off_axis, fov, scale;
    int width, height;
  };
  const View views[] = {{0, 0, 0, 35, 1, 640, 480},   {0, 0, 20, 35, 1, 640, 480},     {90, 0, 30, 60, 1, 640, 480},
                        {0, 90, 15, 35, 1, 640, 480}, {180, 0, 12, 60, 1.3, 300, 500}, {0, 0, 40, 50, 0.8, 900, 400}};
  for (const View& v : views) {
    SwitchRequest r = request();
    r.azimuth_deg = v.azimuth;
    r.elevation_deg = v.elevation;
    r.off_axis_deg = v.off_axis;
    r.fov_y_deg = v.fov;
    r.scale = v.scale;
    r.width = v.width;
    r.height = v.height;
    const SwitchReport report = measure_switch_distance(context_, r);
    ASSERT_EQ(report.rows.size(), 3U);
    for (const SwitchRow& row : report.rows) {
      SCOPED_TRACE(::testing::Message() << "ratio " << row.ratio << ", azimuth " << v.azimuth << ", elevation "
                                        << v.elevation << ", off axis " << v.off_axis << ", " << v.width << "x"
                                        << v.height);
      ASSERT_TRUE(row.measured_depth && row.measured_stretch);
      EXPECT_NEAR(*row.measured_depth / row.depth, 1, kBound);
      EXPECT_NEAR(*row.measured_stretch / row.stretch, 1, kBound);
    }
  }
}

// Dobbyn et al. 2005 print an inverse tangent where the half of the picture's height over the distance is a tangent,
// and their last equation, for the distance, inverted: it grows with the ratio, although texels that span more pixels
// are nearer. Neither survives the pictures.
TEST_F(SwitchDistanceGl, ThePrintedEquationsDoNot) {
  SwitchRequest r = request();
  r.fov_y_deg = 60;
  const SwitchReport report = measure_switch_distance(context_, r);
  const double half = r.fov_y_deg * kRadians / 2;
  for (const SwitchRow& row : report.rows) {
    ASSERT_TRUE(row.measured_depth);
    const double by_inverse_tangent = report.texel * r.height / (2 * row.ratio * std::atan(half));
    EXPECT_GT(by_inverse_tangent / *row.measured_depth, 1.15) << "tan 30 degrees is 0.577, atan of it in radians 0.482";
    const double inverted = report.texel * r.height * row.ratio / (2 * std::tan(half));
    // Right at ratio 1 alone; elsewhere off by the ratio's square.
    EXPECT_NEAR(inverted / *row.measured_depth, row.ratio * row.ratio, 0.02 * row.ratio * row.ratio);
  }
  // Euclidean distance in place of depth: 41 % off at 45 degrees.
  r.off_axis_deg = 45;
  r.fov_y_deg = 80;
  r.ratios = {1};
  const SwitchReport off = measure_switch_distance(context_, r);
  ASSERT_TRUE(off.rows[0].measured_depth);
  EXPECT_NEAR(*off.rows[0].measured_depth / off.rows[0].depth, 1, kBound);
  EXPECT_NEAR(off.rows[0].distance / *off.rows[0].measured_depth, std::sqrt(2.0), kBound * std::sqrt(2.0));
}

TEST_F(SwitchDistanceGl, WhatShowsNoTexelsIsDerivedAndNotMeasured) {
  SwitchRequest r = request();
  r.representation = renderers::parse_spec("polypostor:views=sphere-4x1,frames=2,texels=32");
  r.ratios = {2};
  const SwitchReport report = measure_switch_distance(context_, r);
  EXPECT_FALSE(report.measured);
  ASSERT_EQ(report.rows.size(), 1U);
  EXPECT_FALSE(report.rows[0].measured_depth);
  EXPECT_FALSE(report.rows[0].measured_stretch);
  EXPECT_GT(report.texel, 0);
  EXPECT_DOUBLE_EQ(report.rows[0].depth,
                   derive_switch_depth(2, report.texel * r.scale, r.height, r.fov_y_deg * std::numbers::pi / 180));
}

TEST_F(SwitchDistanceGl, RefusesWhatItCannotMeasure) {
  SwitchRequest r = request();
  r.off_axis_deg = 60;
  EXPECT_THROW(measure_switch_distance(context_, r), Error) << "outside the picture";
  r = request();
  r.representation = renderers::parse_spec("mesh");
  EXPECT_THROW(measure_switch_distance(context_, r), Error) << "a mesh has no texels";
  r = request();
  r.ratios = {0.02};  // a figure of two pixels
  const SwitchReport report = measure_switch_distance(context_, r);
  EXPECT_FALSE(report.rows[0].measured_depth) << "not available is no number";
  EXPECT_GT(report.rows[0].depth, 100);
}

}  // namespace
}  // namespace crowdbench::bench
