// projection=cube: maps that a box's faces have as the sides of a cube map, against solids whose distances are known,
// and what is drawn of them.
#include "renderers/relief/relief_cube.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <memory>
#include <string>

#include "compare_captures.h"
#include "core/error.h"
#include "gl_test_support.h"
#include "renderers/relief/relief_bake.h"
#include "renderers/relief/relief_gaps.h"
#include "renderers/relief/relief_surface.h"
#include "scene/cast/cast.h"
#include "scene/cast/open_character.h"
#include "scene/mannequin/mannequin.h"
#include "solids.h"
#include "test_paths.h"

namespace crowdbench::renderers {
namespace {

using testing::cast_of;
using testing::fact;
using testing::make;

double stored(const ReliefModel& m, int face, size_t texel, size_t which) {
  return m.depth_map(0, face)[2 * texel + which] / 65535.0;
}

// Every ray from the middle of a box leaves it where its largest coordinate is the box's half edge, whatever the edges;
// the skin shows its inner side there, so that all from the middle on is body.
TEST(ReliefCube, ABoxIsFullToItsFacesHalfATexelIn) {
  scene::Character c = testing::box({1.0F, 2.0F, 0.5F});
  for (scene::Material& m : c.materials) m.double_sided = false;
  const ReliefModel m = bake_relief(c, {.map_size = 32, .cube = true});
  ASSERT_EQ(m.boxes.size(), 1U);
  EXPECT_EQ(m.depth.size(), size_t{6 * 32 * 32 * 2});
  EXPECT_TRUE(m.extent.empty());
  for (int face = 0; face < 6; ++face) {
    for (size_t texel = 0; texel < 32 * 32; ++texel) {
      EXPECT_EQ(stored(m, face, texel, 0), 0.0) << face << " " << texel;
      EXPECT_NEAR(stored(m, face, texel, 1), 1.0 - 1.0 / 32, 1e-4) << face << " " << texel;
      const uint8_t* normal = ReliefModel::face(m.normal, m.boxes[0], face / 2, face % 2) + 4 * texel;
      // Shared corners have mean normals: outward, in some direction.
      EXPECT_EQ(normal[face / 2] > 127, face % 2 == 1) << "outward " << face << " " << texel;
    }
  }
}

// Of skin with two sides no inside is known: from the nearest to the farthest, here one surface.
TEST(ReliefCube, ASheetIsThin) {
  scene::Character c = testing::box({1, 1, 1});
  for (scene::Material& m : c.materials) m.double_sided = true;
  const ReliefModel m = bake_relief(c, {.map_size = 16, .cube = true});
  for (int face = 0; face < 6; ++face)
    for (size_t texel = 0; texel < 16 * 16; ++texel)
      EXPECT_NEAR(stored(m, face, texel, 0), 1.0 - 1.0 / 16, 1e-4) << face << " " << texel;
}

// A sphere lies at R / sqrt(u^2 + v^2 + 1) of the way to a face's point (u, v).
TEST(ReliefCube, SphereLiesWhereItsRaysMeetIt) {
  constexpr size_t kSide = 64;
  const ReliefModel m = bake_relief(testing::sphere(0.5, 96), {.map_size = kSide, .cube = true});
  double worst = 0;
  for (int face = 0; face < 6; ++face)
    for (size_t texel = 0; texel < kSide * kSide; ++texel) {
      const double u = 2.0 * (static_cast<double>(texel % kSide) + 0.5) / kSide - 1;
      const double v = 2.0 * (static_cast<double>(texel / kSide) + 0.5) / kSide - 1;
      const double expected = (1.0 - 1.0 / kSide) / std::sqrt(u * u + v * v + 1);
      worst = std::max(worst, std::abs(stored(m, face, texel, 1) - expected));
    }
  // A facet's middle lies 1 - cos(180/96 degrees) inside; where the surface stands aslant a texel reaches to where it
  // passes into the next, half a texel's rise.
  EXPECT_LT(worst, 0.0006 + 0.5 / kSide);
}

class ReliefCubeGl : public testing::GlTest {
 protected:
  static scene::Character mannequin() { return scene::make_mannequin({.triangles = 2200}); }
};

// A box's place in the pictures has 6 n x 1.5 n texels of depths, colours and normals.
TEST_F(ReliefCubeGl, SixMapsOfDepthsAndNoBounds) {
  const scene::Cast cast = cast_of(testing::two_bones());
  const auto relief = make(cast, "relief:map=64,merge=0,capture=bind,projection=cube");
  const auto& facts = relief->bake_info().facts;
  EXPECT_EQ(fact(facts, "bounds_bytes"), 0);
  EXPECT_EQ(fact(facts, "depth_bytes"), fact(facts, "colour_bytes"));
  EXPECT_EQ(fact(relief->bake_info().items[0].facts, "bytes"), 9.0 * 64 * 64 * 12);
}

TEST_F(ReliefCubeGl, WhatItCannotBeJoinedWithIsNamed) {
  const scene::Cast cast = cast_of(testing::two_bones());
  for (const char* option : {"bend=1", "search=linear", "search=cone"}) {
    try {
      (void)make(cast, std::string("relief:projection=cube,") + option);
      ADD_FAILURE() << option << " was taken";
    } catch (const Error& e) {
      EXPECT_NE(std::string(e.what()).find("projection"), std::string::npos) << e.what();
    }
  }
  EXPECT_NO_THROW((void)make(cast, "relief:map=32,capture=bind,projection=cube,bend=rigid"));
}

scene::Frame frame_at(const scene::Cast& cast, double metres) {
  scene::Frame frame = testing::frame_of_one(metres, 0.85, 320, 320, 25);
  testing::add_agent(frame, cast, {0, 0, 0}, 1, 0.3, 0.7F);
  return frame;
}

// Near by and far away, by the nearest tier and by merged boxes: about as whole as the same boxes seen along their
// axes, which open at joints too.
TEST_F(ReliefCubeGl, TheMannequinHasNoTears) {
  const scene::Cast cast = cast_of(mannequin(), 10.0);
  const auto mesh = make(cast, "mesh");
  const auto cube = make(cast, "relief:map=64,capture=bind,projection=cube");
  const auto box = make(cast, "relief:map=64,capture=bind,bend=rigid");
  Renderer renderer(testing::context(), cast);
  for (const double metres : {5.0, 12.0, 40.0}) {
    const scene::Frame frame = frame_at(cast, metres);
    const Capture shown = renderer.capture(frame, *mesh);
    const testing::Difference d = testing::difference(shown, renderer.capture(frame, *cube));
    const testing::Difference along_axes = testing::difference(shown, renderer.capture(frame, *box));
    ASSERT_GT(d.pixels, 100) << metres;
    EXPECT_GT(d.iou, metres > 20 ? 0.93 : 0.97) << metres;
    EXPECT_LE(d.holes, along_axes.holes + d.inside / 500) << metres;
    EXPECT_LE(d.strays, d.pixels / 500) << metres;
  }
}

TEST_F(ReliefCubeGl, ASharedCharacterIsWhole) {
  const std::filesystem::path file = std::filesystem::path(CROWDBENCH_SHARED_DIR) / "characters/Mannequiny.glb";
  if (!std::filesystem::exists(file)) GTEST_SKIP() << "needs shared/characters/Mannequiny.glb";
  const scene::Cast cast = cast_of(scene::open_character(file.string()), 4.0);
  const scene::Frame frame = frame_at(cast, 5);
  Renderer renderer(testing::context(), cast);
  const testing::Difference d =
      testing::difference(renderer.capture(frame, *make(cast, "mesh")),
                          renderer.capture(frame, *make(cast, "relief:map=64,capture=bind,projection=cube")));
  ASSERT_GT(d.pixels, 1000);
  EXPECT_GT(d.iou, 0.95);
  EXPECT_LE(d.holes, d.inside / 200);
  EXPECT_LE(d.strays, d.pixels / 100);
}

}  // namespace
}  // namespace crowdbench::renderers
