#include "renderers/pseudo/pseudo.h"

#include <gtest/gtest.h>

#include <cmath>

#include "renderers/pseudo/pose_choice.h"
#include "renderers/pseudo/pose_error.h"
#include "scene/cast/cast.h"
#include "scene/mannequin/mannequin.h"
#include "tests/renderers/compare_captures.h"
#include "tests/renderers/gl_test_support.h"

namespace crowdbench::renderers {
namespace {

using testing::context;
using testing::different_ids;
using testing::fact;
using testing::GlTest;
using testing::make;
using testing::row_of_walkers;
using testing::walker;
using testing::worst_colour_difference;

TEST(PseudoChoice, EvenPosesAreTheNearestAndOnlyThoseShown) {
  const PoseChoice c = even_poses(std::vector<float>{0.29F, 0.31F, 0.95F, 0.05F, 0.3F}, 5);
  EXPECT_EQ(c.phases, (std::vector<double>{0.2, 0.4, 0.0}));
  EXPECT_EQ(c.of, (std::vector<uint32_t>{0, 1, 2, 2, 1})) << "0.95 is as near to the start as 0.05";
  EXPECT_EQ(nearest_even_phase(0.91, 5), 0.0);
  EXPECT_TRUE(even_poses({}, 5).phases.empty());
}

TEST(PseudoChoice, ClustersAreMeansOnTheCircle) {
  // Two groups, one of them across the end of the circle.
  const std::vector<float> phases = {0.5F, 0.96875F, 0.03125F, 0.5625F, 0.0F};
  const PoseChoice c = clustered_poses(phases, 2);
  ASSERT_EQ(c.phases.size(), 2U);
  EXPECT_EQ(c.of[0], c.of[3]);
  EXPECT_EQ(c.of[1], c.of[2]);
  EXPECT_EQ(c.of[1], c.of[4]);
  EXPECT_DOUBLE_EQ(c.phases[c.of[0]], 0.53125);
  EXPECT_DOUBLE_EQ(c.phases[c.of[1]], 0.0);
  // As many poses as there are phases: everybody's own, to the bit.
  const PoseChoice own = clustered_poses(phases, 5);
  for (size_t i = 0; i < phases.size(); ++i) EXPECT_EQ(own.phases[own.of[i]], static_cast<double>(phases[i]));
  const PoseChoice one = clustered_poses(std::vector<float>{0.3F, 0.3F, 0.3F}, 2);
  EXPECT_EQ(one.phases.size(), 1U);
  EXPECT_TRUE(clustered_poses({}, 3).of.empty());
}

double squared_error(const std::vector<float>& phases, const PoseChoice& c) {
  double sum = 0;
  for (size_t i = 0; i < phases.size(); ++i) {
    const double d = std::abs(static_cast<double>(phases[i]) - c.phases[c.of[i]]);
    sum += std::pow(std::min(d, 1 - d), 2);
  }
  return sum;
}

// Phases of a crowd that is not spread evenly: clusters fit it better than even poses do, and move with it.
TEST(PseudoChoice, ClustersFollowTheCrowd) {
  std::vector<float> phases;
  for (int i = 0; i < 200; ++i) {
    const double u = std::fmod(0.6180339887 * i, 1.0);
    phases.push_back(static_cast<float>(i % 4 == 0 ? u : 0.35 + 0.2 * u * u));
  }
  const PoseChoice clustered = clustered_poses(phases, 6);
  EXPECT_LE(clustered.phases.size(), 6U);
  EXPECT_LT(squared_error(phases, clustered), 0.75 * squared_error(phases, even_poses(phases, 6)));
  std::vector<float> later;
  for (const float p : phases) later.push_back(static_cast<float>(std::fmod(static_cast<double>(p) + 0.7, 1.0)));
  const PoseChoice moved = clustered_poses(later, 6);
  ASSERT_EQ(moved.phases.size(), clustered.phases.size());
  for (size_t i = 0; i < phases.size(); ++i) {
    const double by = moved.phases[moved.of[i]] - clustered.phases[clustered.of[i]];
    EXPECT_NEAR(by - std::floor(by), 0.7, 1e-5) << i;
  }
}

// Half the distance between poses is half the error, of a joint that turns evenly and of a walk.
TEST(PseudoError, FallsWithTheNumberOfPoses) {
  const scene::Cast cast = testing::cast_of(testing::two_bones());
  const auto error = [&](uint32_t poses) { return even_pose_error(*cast.characters[0], *cast.banks[0], poses); };
  EXPECT_GT(error(4).rms, 0.0);
  EXPECT_LT(error(4).rms, error(4).max);
  EXPECT_NEAR(error(16).rms / error(32).rms, 2.0, 0.1) << "twice the poses, half the error";
  const PoseError walk4 = even_pose_error(*walker().characters[0], *walker().banks[0], 4);
  const PoseError walk8 = even_pose_error(*walker().characters[0], *walker().banks[0], 8);
  EXPECT_NEAR(walk4.rms / walk8.rms, 2.0, 0.3);
}

class PseudoGl : public GlTest {};

Capture draw(const scene::Frame& frame, const std::string& spec) {
  Renderer renderer(context(), walker());
  return renderer.capture(frame, *make(walker(), spec));
}

// Agents whose phases are among the poses show the mesh: turned and placed after skinning, not before, and normals of
// 16 bits.
TEST_F(PseudoGl, InASharedPoseItIsTheMesh) {
  const scene::Frame frame = row_of_walkers({0.0, 0.25, 0.5, 0.75, 0.25, 0.0, 0.5, 0.5});
  const Capture mesh = draw(frame, "mesh");
  for (const char* spec : {"pseudo:poses=4", "pseudo:poses=4,choice=clustered"}) {
    const Capture test = draw(frame, spec);
    EXPECT_LE(different_ids(mesh, test), 4U) << spec;
    EXPECT_LE(worst_colour_difference(mesh, test), 3) << spec;
  }
}

TEST_F(PseudoGl, OthersShowTheNearestPose) {
  EXPECT_EQ(draw(row_of_walkers({0.29, 0.4, 0.91}), "pseudo:poses=5"),
            draw(row_of_walkers({0.2, 0.4, 0.0}), "pseudo:poses=5"));
  EXPECT_EQ(draw(row_of_walkers({0.28125, 0.34375}), "pseudo:poses=1,choice=clustered"),
            draw(row_of_walkers({0.3125, 0.3125}), "pseudo:poses=1,choice=clustered"));
  const auto even = make(walker(), "pseudo:poses=5");
  EXPECT_EQ(even->shown_phase(0, 0, 0.29), 0.2);
  EXPECT_EQ(make(walker(), "pseudo:choice=clustered")->shown_phase(0, 0, 0.29), 0.29);
}

TEST_F(PseudoGl, BytesAreThoseOfThePosesThatAFrameShows) {
  const auto one = make(walker(), "pseudo:poses=5");
  const uint64_t before = one->footprint().buffer_bytes;
  Renderer renderer(context(), walker());
  (void)renderer.capture(row_of_walkers({0.0, 0.2, 0.2}), *one);
  const uint64_t two = one->footprint().buffer_bytes - before;
  (void)renderer.capture(row_of_walkers({0.0, 0.2, 0.4, 0.6, 0.8, 0.8, 0.1}), *one);
  const uint64_t five = one->footprint().buffer_bytes - before;
  EXPECT_EQ(five * 2, two * 5);
  EXPECT_NEAR(fact(one->bake_info().facts, "pose_error_rms_mm"),
              1000 * even_pose_error(*walker().characters[0], *walker().banks[0], 5).rms, 1e-9);
}

}  // namespace
}  // namespace crowdbench::renderers
