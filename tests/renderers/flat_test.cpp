// Pictures of flat impostors against those of the mesh.
#include "renderers/flat/flat.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <initializer_list>

#include "core/error.h"
#include "scene/cast/cast.h"
#include "tests/renderers/compare_captures.h"
#include "tests/renderers/gl_test_support.h"

namespace crowdbench::renderers {
namespace {

using testing::add_agent;
using testing::cast_of;
using testing::context;
using testing::covered;
using testing::frame_from;
using testing::frame_of_one;
using testing::iou;
using testing::make;
using testing::walker;
using testing::worst_colour_difference;
using FlatGl = testing::GlTest;

TEST_F(FlatGl, LooksAsTheMeshAtEveryStoredViewOfEveryGrid) {
  const auto mesh = make(walker(), "mesh");
  Renderer renderer(context(), walker());
  struct Case {
    const char* grid;
    std::vector<std::pair<double, double>> views;  // azimuth, elevation, degrees
  };
  for (const auto& [grid, views] :
       std::initializer_list<Case>{{"sphere-6x4", {{0, 0}, {60, 0}, {120, 30}, {240, 60}, {300, 90}}},
                                   {"cube-3", {{0, 0}, {90, 0}, {33.690067, 0}, {180, 0}, {0, 90}}},
                                   {"hemi-5", {{0, 0}, {45, 0}, {270, 0}, {0, 90}}}}) {
    const auto flat = make(walker(), fmt::format("flat:views={},frames=2,texels=128", grid));
    for (const auto& [azimuth, elevation] : views)
      for (const double phase : {0.0, 0.5}) {
        // From afar: tiles are orthographic, and what is left over is theirs alone.
        const auto frame = frame_from(walker(), {.azimuth = azimuth, .elevation = elevation, .phase = phase, .fov = 3});
        const double agreement = iou(renderer.capture(frame, *mesh), renderer.capture(frame, *flat));
        EXPECT_GT(agreement, 0.93) << grid << " from " << azimuth << ", " << elevation << " at phase " << phase;
      }
  }
}

TEST_F(FlatGl, TurnsWithTheAgent) {
  const auto mesh = make(walker(), "mesh");
  const auto flat = make(walker(), "flat:views=sphere-6x4,frames=2,texels=128");
  Renderer renderer(context(), walker());
  // An agent turned by a sixth seen from 90 degrees is the view from 30 before turning; the sample at 60 - 60 = 0.
  const auto frame = frame_from(walker(), {.azimuth = 60, .elevation = 30, .heading = 1.0F / 6});
  EXPECT_GT(iou(renderer.capture(frame, *mesh), renderer.capture(frame, *flat)), 0.93);
}

TEST_F(FlatGl, ShowsTheNearestFrame) {
  const auto mesh = make(walker(), "mesh");
  const auto flat = make(walker(), "flat:views=sphere-4x1,frames=4,texels=128");
  Renderer renderer(context(), walker());
  const auto flat_at = [&](double phase) {
    return renderer.capture(frame_from(walker(), {.azimuth = 90, .phase = phase}), *flat).ids;
  };
  EXPECT_EQ(flat_at(0.13), flat_at(0.25));
  EXPECT_EQ(flat_at(0.12), flat_at(0.0));
  EXPECT_EQ(flat_at(0.88), flat_at(0.0)) << "the last half frame belongs to the first";
  EXPECT_NE(flat_at(0.25), flat_at(0.0));
  const auto quarter = frame_from(walker(), {.azimuth = 90, .phase = 0.25});
  EXPECT_GT(iou(renderer.capture(quarter, *mesh), renderer.capture(quarter, *flat)), 0.93);
}

TEST_F(FlatGl, AStillBankIsBakedExactly) {
  const auto character = walker().characters[0];
  scene::Cast still;
  still.characters = {character};
  still.banks = {std::make_shared<const scene::PoseBank>(
      scene::PoseBank::exact(*character, character->placement.default_clip, 0.2))};
  still.shares = {1.0};
  const auto mesh = make(still, "mesh");
  const auto flat = make(still, "flat:views=sphere-4x1,texels=128");
  Renderer renderer(context(), still);
  const auto frame = frame_from(still, {.azimuth = 90, .phase = 0.7});
  EXPECT_GT(iou(renderer.capture(frame, *mesh), renderer.capture(frame, *flat)), 0.93);
}

TEST_F(FlatGl, ACardIsShadedAsTheMeshShadesIt) {
  for (const glm::vec4& colour : {glm::vec4(0.5F, 0.25F, 0.1F, 1), glm::vec4(0.02F, 0.9F, 0.4F, 1)}) {
    const scene::Cast cast = cast_of(testing::card(1, 1, colour));
    const auto mesh = make(cast, "mesh");
    const auto flat = make(cast, "flat:views=sphere-1x1,texels=64");
    Renderer renderer(context(), cast);
    scene::Frame frame = frame_of_one(3, 0.5, 96, 96);
    scene::Outfit outfit;
    for (glm::vec4& c : outfit.colours) c = glm::vec4(0.7F, 1.0F, 0.3F, 1);
    frame.outfits.push_back(outfit);
    add_agent(frame, cast, {0, 0, 0}, 1);
    frame.agents[0][0].outfit = 1;
    const Capture a = renderer.capture(frame, *mesh);
    const Capture b = renderer.capture(frame, *flat);
    EXPECT_GT(iou(a, b), 0.95);
    EXPECT_LE(worst_colour_difference(a, b), 1) << "grey levels";
  }
}

TEST_F(FlatGl, TheFloorCoversTheSamePixels) {
  const auto flat = make(walker(), "flat:views=sphere-4x1,frames=2,texels=64");
  const auto floor = make(walker(), "flat:views=sphere-4x1,frames=2,texels=64,floor=1");
  Renderer renderer(context(), walker());
  const auto frame = frame_from(walker(), {});
  const Capture a = renderer.capture(frame, *flat);
  const Capture b = renderer.capture(frame, *floor);
  EXPECT_EQ(a.ids, b.ids);
  EXPECT_EQ(a.depth, b.depth);
  EXPECT_NE(a.colour, b.colour);
}

TEST_F(FlatGl, AListShowsTheStoredColours) {
  const std::string bake = "flat:views=sphere-4x1,frames=2,texels=64";
  const auto flat = make(walker(), bake);
  const auto list = make(walker(), bake + ",shade=list");
  Renderer renderer(context(), walker());
  scene::Frame frame = frame_from(walker(), {});
  const Capture lit = renderer.capture(frame, *flat);
  EXPECT_NE(renderer.capture(frame, *list).colour, lit.colour);
  // White clothes in light from everywhere: what is lit is the stored colour too.
  frame.light.ambient = 1;
  frame.light.diffuse = 0;
  for (scene::Outfit& outfit : frame.outfits) outfit.colours.fill(glm::vec4(1.0F));
  const Capture a = renderer.capture(frame, *flat);
  const Capture b = renderer.capture(frame, *list);
  EXPECT_EQ(a.colour, b.colour);
  EXPECT_EQ(a.ids, b.ids);
  EXPECT_EQ(a.depth, b.depth);
  for (const char* option : {",depth=nailboard", ",blend=3", ",floor=1"})
    EXPECT_THROW(make(walker(), bake + ",shade=list" + option), Error) << option;
}

TEST_F(FlatGl, ManyLayersAreSplitOverSeveralArrays) {
  for (const std::string options : {"", ",depth=nailboard", ",compress=bc"}) {
    const std::string spec = "flat:views=sphere-8x4,frames=2,texels=64" + options;
    const auto whole = make(walker(), spec);
    const auto split = make(walker(), spec + ",layers=1");
    EXPECT_EQ(split->footprint().texture_bytes, whole->footprint().texture_bytes);
    EXPECT_GT(split->footprint().buffer_bytes, whole->footprint().buffer_bytes) << "there is something to split";
    Renderer renderer(context(), walker());
    // Both kinds of outlines, all elevations: agents around the eye, from 2 m under it to 14.
    scene::Frame frame = frame_of_one(10, 1, 320, 240, 60);
    frame.camera.eye = {0, 4, 0};
    frame.camera.target = {0, 0, -8};
    frame.origin = frame.camera.eye;
    for (int i = 0; i < 60; ++i) {
      const double away = 2 + 0.4 * i;
      add_agent(frame, walker(), {away * 0.5 * std::sin(2.4 * i), -0.1 * (i % 5), -away}, static_cast<uint32_t>(i + 1),
                (i % 4) * 0.25, static_cast<float>(i % 8) / 8);
    }
    const Capture a = renderer.capture(frame, *whole);
    const Capture b = renderer.capture(frame, *split);
    ASSERT_GT(covered(a), 2000U);
    EXPECT_EQ(a.ids, b.ids) << spec;
    EXPECT_EQ(a.colour, b.colour) << spec;
    EXPECT_EQ(a.depth, b.depth) << spec;
  }
  EXPECT_THROW(make(walker(), "flat:views=sphere-8x4,frames=2,texels=64,blend=3,layers=1"), Error)
      << "a fragment reads three tiles of any layers";
}

TEST_F(FlatGl, ASquareQuadShowsTheSamePicture) {
  const auto trimmed = make(walker(), "flat:views=sphere-4x2,frames=1,texels=64");
  const auto square = make(walker(), "flat:views=sphere-4x2,frames=1,texels=64,quad=square");
  Renderer renderer(context(), walker());
  const auto frame = frame_from(walker(), {.azimuth = 90});
  EXPECT_GT(iou(renderer.capture(frame, *trimmed), renderer.capture(frame, *square)), 0.995);
  EXPECT_GT(square->footprint().texture_bytes, 2 * trimmed->footprint().texture_bytes);
}

}  // namespace
}  // namespace crowdbench::renderers
