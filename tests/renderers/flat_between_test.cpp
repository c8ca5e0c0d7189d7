// Flat impostors between stored frames, against the mesh at that moment.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "core/error.h"
#include "renderers/flat/flat.h"
#include "scene/mannequin/mannequin.h"
#include "tests/renderers/compare_captures.h"
#include "tests/renderers/gl_test_support.h"
#include "tests/support/sanitized.h"

namespace crowdbench::renderers {
namespace {

using testing::cast_of;
using testing::context;
using testing::different_ids;
using testing::frame_from;
using testing::iou;
using testing::make;
using testing::mean_colour_difference;
using testing::outline_pixels;
using testing::walker;
using FlatBetweenGl = testing::GlTest;

// Stored at 0, 60, ... degrees of azimuth; stored frames eight a cycle.
const std::string kBake = "flat:views=sphere-6x1,frames=8,texels=96";
std::string bake_of(const std::string& between) { return kBake + ",frames_between=" + between; }

struct Likeness {
  double overlap = 0;  // intersection over union of the silhouettes
  double colour = 0;   // mean difference, code values
};

// Means over views and steps between stored frames, at `share` of a step after the stored frame.
Likeness likeness(Representation& flat, Renderer& renderer, Representation& mesh, double share) {
  Likeness out;
  int count = 0;
  for (const double azimuth : {0.0, 60.0, 240.0})
    for (int step = 0; step < 8; step += 3) {
      const auto frame = frame_from(walker(), {.azimuth = azimuth, .phase = (step + share) / 8.0, .fov = 3});
      const Capture expected = renderer.capture(frame, mesh);
      const Capture shown = renderer.capture(frame, flat);
      out.overlap += iou(expected, shown);
      out.colour += mean_colour_difference(expected, shown);
      ++count;
    }
  return {out.overlap / count, out.colour / count};
}

TEST_F(FlatBetweenGl, MovedFramesAreNearerToTheMeshThanStoredOnes) {
  const auto mesh = make(walker(), "mesh");
  Renderer renderer(context(), walker());
  std::map<std::string, Likeness> half_way;
  for (const char* between : {"nearest", "blend", "move", "move_blend"}) {
    const auto flat = make(walker(), bake_of(between));
    for (const double share : {0.25, 0.5, 0.8}) {
      const Likeness found = likeness(*flat, renderer, *mesh, share);
      fmt::print("{} at {}: IoU {:.3f}, colours off by {:.1f}\n", between, share, found.overlap, found.colour);
      if (share == 0.5) half_way[between] = found;
    }
  }
  const double stored = likeness(*make(walker(), kBake), renderer, *mesh, 0).overlap;
  for (const char* moved : {"move", "move_blend"}) {
    EXPECT_GT(half_way[moved].overlap, half_way["nearest"].overlap + 0.1) << moved;
    EXPECT_GT(half_way[moved].overlap, half_way["blend"].overlap + 0.1) << moved;
    EXPECT_GT(half_way[moved].overlap, stored - 0.05) << moved << ": nearly as on stored frames";
    EXPECT_LT(half_way[moved].colour, 0.6 * half_way["blend"].colour) << moved;
  }
}

// On a stored frame the farther one counts for nothing and nothing moves.
TEST_F(FlatBetweenGl, StoredFramesAreShownAsTheyAre) {
  const auto plain = make(walker(), kBake);
  Renderer renderer(context(), walker());
  for (const char* between : {"blend", "move", "move_blend"}) {
    const auto flat = make(walker(), bake_of(between));
    for (const double phase : {0.0, 0.375}) {
      const auto frame = frame_from(walker(), {.azimuth = 60, .phase = phase});
      const Capture expected = renderer.capture(frame, *plain);
      const Capture shown = renderer.capture(frame, *flat);
      // Other corners: places are interpolated with other roundings.
      EXPECT_LE(different_ids(expected, shown), outline_pixels(expected) / 50) << between << " at " << phase;
      EXPECT_LT(mean_colour_difference(expected, shown), 0.3) << between << " at " << phase;
    }
    EXPECT_EQ(flat->shown_phase(0, 0, 0.3), 0.3);
  }
}

// The picture changes little where the nearer frame becomes the farther one.
TEST_F(FlatBetweenGl, NothingJumpsHalfWay) {
  Renderer renderer(context(), walker());
  const auto jump = [&](const char* between) {
    const auto flat = make(walker(), bake_of(between));
    double sum = 0;
    for (const double middle : {0.0625, 0.3125}) {
      const auto at = [&](double phase) {
        return renderer.capture(frame_from(walker(), {.azimuth = 60, .phase = phase}), *flat);
      };
      sum += mean_colour_difference(at(middle - 1e-3), at(middle + 1e-3));
    }
    return sum;
  };
  const double nearest = jump("nearest");
  EXPECT_GT(nearest, 10);
  EXPECT_LT(jump("move"), nearest / 3);
  EXPECT_LT(jump("move_blend"), nearest / 10);
}

// Each option of the tiles with each of the frames between: the mesh's picture, half-way.
TEST_F(FlatBetweenGl, GoesWithEveryOptionOfTheTiles) {
  const auto mesh = make(walker(), "mesh");
  Renderer renderer(context(), walker());
  const auto frame = frame_from(walker(), {.azimuth = 90, .phase = 0.1875, .fov = 3});
  const Capture expected = renderer.capture(frame, *mesh);
  for (const char* options : {",compress=bc", ",depth=nailboard", ",parallax=3", ",parallax=3,depth=nailboard",
                              ",quad=square", ",plane=facing", ",compress=bc,depth=nailboard"})
    for (const char* between : {"move", "move_blend"}) {
      const auto flat =
          make(walker(), "flat:views=sphere-4x1,frames=8,texels=96,frames_between=" + std::string(between) + options);
      EXPECT_GT(iou(expected, renderer.capture(frame, *flat)), 0.93) << between << options;
    }
  // Small figures are drawn by coarse levels, whose motions are their own; a single level has its own as well.
  const auto far = frame_from(walker(), {.azimuth = 90, .phase = 0.1875, .fov = 50});
  const Capture small = renderer.capture(far, *mesh);
  for (const char* texels : {"96", "24"}) {
    const auto flat =
        make(walker(), fmt::format("flat:views=sphere-4x1,frames=8,texels={},frames_between=move", texels));
    EXPECT_GT(iou(small, renderer.capture(far, *flat)), 0.8) << texels;
  }
}

// Mirrored grids show the other half of the cycle; a still pose has no frames between; several arrays cannot be.
TEST_F(FlatBetweenGl, MirroredGridsStillPosesAndRefusals) {
  const auto mesh = make(walker(), "mesh");
  Renderer renderer(context(), walker());
  const auto mirrored = make(walker(), "flat:views=sphere-7x1-mirrored,frames=8,texels=96,frames_between=move_blend");
  for (const double azimuth : {60.0, 240.0}) {
    const auto frame = frame_from(walker(), {.azimuth = azimuth, .phase = 0.1875, .fov = 3});
    EXPECT_GT(iou(renderer.capture(frame, *mesh), renderer.capture(frame, *mirrored)), 0.9) << azimuth;
  }
  scene::Cast still;
  still.characters = {walker().characters[0]};
  still.banks = {std::make_shared<const scene::PoseBank>(
      scene::PoseBank::exact(*still.characters[0], still.characters[0]->placement.default_clip, 0.2))};
  still.shares = {1.0};
  Renderer of_still(context(), still);
  const auto frame = frame_from(still, {.azimuth = 60, .phase = 0.7});
  EXPECT_GT(
      iou(of_still.capture(frame, *make(still, "mesh")), of_still.capture(frame, *make(still, bake_of("move_blend")))),
      0.93);
  for (const char* options : {",blend=3", ",shade=list", ",layers=1"})
    EXPECT_THROW(make(walker(), "flat:views=sphere-8x4,frames=2,texels=64,frames_between=move" + std::string(options)),
                 Error)
        << options;
}

}  // namespace
}  // namespace crowdbench::renderers
