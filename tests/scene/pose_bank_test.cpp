#include "scene/pose/pose_bank.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "scene/mannequin/mannequin.h"
#include "scene/pose/normalise.h"
#include "scene/pose/pose.h"
#include "tests/scene/tiny_character.h"

namespace crowdbench::scene {
namespace {

// A root that climbs from y = 0 to 4 and back, and a still pose.
Character climber() {
  Character c = tiny_character();
  c.clips = {
      one_channel("walk", {0, Target::translation, Interpolation::linear, {0, 0.5, 1}, {0, 0, 0, 0, 4, 0, 0, 0, 0}}),
      one_channel("pose", {0, Target::translation, Interpolation::linear, {0.3}, {0, 7, 0}})};
  normalise(c, {std::nullopt});
  return c;
}

float height_of(const PoseBank& bank, const PoseSample& sample) { return bank.palette(sample)[0].rows[1].w; }

TEST(PoseBank, SamplesDivideALoopExactly) {
  const PoseBank bank(climber(), {0, 1}, 4.0);
  ASSERT_EQ(bank.clips().size(), 2u);
  EXPECT_EQ(bank.clips()[0].samples, 4u);
  EXPECT_EQ(bank.clips()[1].first_sample, 4u);
  EXPECT_EQ(bank.clips()[1].samples, 1u);
  EXPECT_EQ(bank.joints(), 2);
  EXPECT_EQ(bank.matrices().size(), 5u * 2u);
  EXPECT_EQ(bank.bank_clip(1), 1);
  EXPECT_EQ(bank.bank_clip(2), -1);
  EXPECT_FLOAT_EQ(bank.matrices()[2].rows[1].w, 2.0F);  // joint 0 at a quarter of the cycle
  // 1.06 s at 30 Hz is 31.8 samples: 32 of 33.1 ms.
  EXPECT_EQ(PoseBank(make_mannequin({.triangles = 500}), {0}).clips()[0].samples, 32u);
}

TEST(PoseBank, APhaseBetweenSamplesIsTheirBlendAndTheLastBlendsIntoTheFirst) {
  const PoseBank bank(climber(), {0, 1}, 4.0);
  const PoseSample middle = bank.sample(0, 0.375);
  EXPECT_EQ(middle.a, 1u);
  EXPECT_EQ(middle.b, 2u);
  EXPECT_FLOAT_EQ(middle.blend, 0.5F);
  EXPECT_FLOAT_EQ(height_of(bank, middle), 3.0F);
  const PoseSample last = bank.sample(0, 0.9375);
  EXPECT_EQ(last.a, 3u);
  EXPECT_EQ(last.b, 0u);
  EXPECT_FLOAT_EQ(height_of(bank, last), 0.25F * 2.0F);
  EXPECT_EQ(bank.sample(0, 2.375).a, 1u);
  EXPECT_EQ(bank.sample(0, -0.625).a, 1u);
  EXPECT_EQ(bank.sample(0, -1e-30).a, 0u);
  const PoseSample still = bank.sample(1, 0.6);
  EXPECT_EQ(still.a, 4u);
  EXPECT_EQ(still.b, 4u);
  EXPECT_EQ(still.blend, 0.0F);
}

TEST(PoseBank, ExactHoldsOneMomentAndFramesAreOnTheCurves) {
  const Character c = climber();
  EXPECT_FLOAT_EQ(height_of(PoseBank::exact(c, 0, 0.3), {}), 2.4F);
  EXPECT_FLOAT_EQ(height_of(PoseBank::exact(c, 1, 0.0, true), {}), 7.0F);
  EXPECT_FLOAT_EQ(height_of(PoseBank::exact(c, -1, 0.0), {}), 0.0F);
  const PoseBank frames = PoseBank::frames(c, {0, 1}, {5, 5});
  EXPECT_EQ(frames.clips()[0].samples, 5u);
  EXPECT_EQ(frames.clips()[1].samples, 1u);
  EXPECT_FLOAT_EQ(height_of(frames, {1, 1, 0.0F}), 1.6F);  // phase 1/5
}

TEST(PoseBank, BoundsHoldEverySample) {
  const PoseBank bank(climber(), {0}, 4.0);
  EXPECT_FLOAT_EQ(bank.bounds_min().y, 0.0F);
  EXPECT_FLOAT_EQ(bank.bounds_max().y, 6.0F);  // 4 up, 2 tall
  EXPECT_FLOAT_EQ(bank.bounds_max().z, 0.5F);
}

// How far the 30 Hz bank's blend is from the curves, over all vertices and phases between samples; metres.
TEST(PoseBank, StaysNearTheCurvesAtThirtyHertz) {
  const Character c = make_mannequin({.triangles = 2200});
  // Measured 11.1, 15.3, 0.002 and 5.3 mm (feet between samples where they leave the ground or lift fastest; the idle
  // clip's keys fall on samples); bounds a little above.
  const double bounds[] = {0.0125, 0.0170, 0.000005, 0.0060};
  const PoseBank bank(c, {0, 1, 2, 3});
  for (int clip = 0; clip < 4; ++clip) {
    double worst = 0.0;
    for (uint32_t i = 0; i < bank.clips()[static_cast<size_t>(clip)].samples; ++i) {
      const double phase = (i + 0.5) / bank.clips()[static_cast<size_t>(clip)].samples;
      const auto truth = skin_positions(c.mesh, model_matrices(c, clip, phase));
      std::vector<glm::dmat4> blended;
      for (const Mat3x4& m : bank.palette(bank.sample(clip, phase))) {
        blended.emplace_back(glm::transpose(
            glm::dmat4(glm::dvec4(m.rows[0]), glm::dvec4(m.rows[1]), glm::dvec4(m.rows[2]), glm::dvec4(0, 0, 0, 1))));
      }
      const auto posed = skin_positions(c.mesh, blended);
      for (size_t v = 0; v < posed.size(); ++v) worst = std::max(worst, glm::distance(posed[v], truth[v]));
    }
    RecordProperty(c.clips[static_cast<size_t>(clip)].name, std::to_string(worst));
    EXPECT_LT(worst, bounds[clip]) << c.clips[static_cast<size_t>(clip)].name;
    EXPECT_GT(worst, 0.1 * bounds[clip]) << "a bound this far off tests nothing";
  }
}

}  // namespace
}  // namespace crowdbench::scene
