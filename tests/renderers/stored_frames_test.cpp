#include "renderers/impostor/tiles/stored_frames.h"

#include <gtest/gtest.h>

#include "core/error.h"
#include "core/hash.h"
#include "scene/mannequin/mannequin.h"
#include "scene/pose/hidden.h"
#include "scene/pose/pose.h"
#include "tests/renderers/gl_test_support.h"

namespace crowdbench::renderers {
namespace {

struct Walker {
  scene::Character character = scene::make_mannequin({.triangles = 500, .joints = 20, .normalise = {}});
  int walk = scene::require_clip(character, "walk");
  int idle = scene::require_clip(character, "idle");
  std::shared_ptr<const scene::PoseBank> bank =
      std::make_shared<const scene::PoseBank>(character, std::vector<int>{walk, idle, -1});
};

TEST(FrameCount, IsByClipOrByTheSecond) {
  EXPECT_EQ((FrameCount{10, 0}).of(600), 10);
  EXPECT_EQ((FrameCount{10, 4}).of(600), 2400);
  EXPECT_EQ((FrameCount{10, 4}).of(1.5), 6);
  EXPECT_EQ((FrameCount{10, 4}).of(1.51), 7);
  EXPECT_EQ((FrameCount{10, 4}).of(0.01), 1);
}

TEST(StoredFrames, EachClipHasItsOwnNumberOnTheCurves) {
  const Walker w;
  const double walk = scene::cycle_seconds(w.character, w.walk);
  const double idle = scene::cycle_seconds(w.character, w.idle);
  const FrameCount count{10, 8};
  const StoredFrames frames = stored_frames(w.character, w.bank, count);
  ASSERT_EQ(frames.clips.size(), 3U);
  EXPECT_EQ(frames.clips[0].frames, static_cast<uint32_t>(count.of(walk)));
  EXPECT_EQ(frames.clips[1].frames, static_cast<uint32_t>(count.of(idle)));
  EXPECT_EQ(frames.clips[2].frames, 1U);
  EXPECT_NE(frames.clips[0].frames, frames.clips[1].frames);
  EXPECT_EQ(frames.size(), frames.clips[0].frames + frames.clips[1].frames + 1);
  EXPECT_EQ(most_frames(frames), count.of(idle));
  // The third frame of the second clip is its pose at that phase.
  const auto stored = scene::shown_positions(w.character.mesh, frames.palette(frames.clips[1].first_frame + 2));
  const auto posed = scene::skin_positions(
      w.character.mesh, scene::model_matrices(w.character, w.idle, 2.0 / static_cast<double>(frames.clips[1].frames)));
  for (size_t v = 0; v < stored.size(); ++v) EXPECT_LT(glm::length(glm::dvec3(stored[v]) - posed[v]), 1e-5);
}

TEST(StoredFrames, MoreThanTheLimitAreRefusedWithWhatWouldFit) {
  Walker w;
  scene::Clip& walk = w.character.clips[static_cast<size_t>(w.walk)];
  for (scene::Channel& channel : walk.channels)
    for (double& time : channel.times) time *= 600;
  walk.end *= 600;
  const auto bank = std::make_shared<const scene::PoseBank>(w.character, std::vector<int>{w.walk}, 1.0);
  try {
    stored_frames(w.character, bank, {10, 60});
    FAIL();
  } catch (const Error& error) {
    EXPECT_NE(error.wrong.find("the limit is 4096"), std::string::npos) << error.wrong;
    EXPECT_NE(error.advice.find("give fps = "), std::string::npos) << error.advice;
  }
  EXPECT_EQ(stored_frames(w.character, bank, {10, 0}).size(), 10U);
}

TEST(StoredFrames, FewForTheMotionAreSaid) {
  const Walker w;
  const std::string text = coarse_frames_text(w.character, *w.bank, {10, 0});
  EXPECT_NE(text.find("10 stored frames of clip 'idle' (3.2 s) are 3.1 a second"), std::string::npos) << text;
  EXPECT_NE(text.find("fps=4 stores 13"), std::string::npos) << text;
  EXPECT_EQ(coarse_frames_text(w.character, *w.bank, {13, 0}), "");
  EXPECT_EQ(coarse_frames_text(w.character, *w.bank, {1, 4}), "");
  const scene::PoseBank still(w.character, {-1});
  EXPECT_EQ(coarse_frames_text(w.character, still, {1, 0}), "");
}

// Whoever shows a clip in few poses says so, once a process: the walk of a second in three.
class CoarsePosesGl : public testing::GlTest,
                      public ::testing::WithParamInterface<std::pair<const char*, const char*>> {};

TEST_P(CoarsePosesGl, AreSaidWhereThereAreFewerThanFourASecond) {
  const auto& [spec, helps] = GetParam();
  ::testing::internal::CaptureStderr();
  testing::make(testing::walker(), std::string(spec) + "8");
  EXPECT_EQ(::testing::internal::GetCapturedStderr().find("a second of motion"), std::string::npos);
  ::testing::internal::CaptureStderr();
  testing::make(testing::walker(), std::string(spec) + "3");
  const std::string text = ::testing::internal::GetCapturedStderr();
  EXPECT_NE(text.find("3 stored frames of clip 'walk'"), std::string::npos) << text;
  EXPECT_NE(text.find(helps), std::string::npos) << text;
}

INSTANTIATE_TEST_SUITE_P(Poses, CoarsePosesGl,
                         ::testing::Values(std::pair{"rigid:poses=", "raise poses"},
                                           std::pair{"pseudo:poses=", " shows 4"},
                                           std::pair{"posecache:keys=", "leave keys out"}),
                         [](const auto& test) {
                           const std::string spec = test.param.first;
                           return spec.substr(0, spec.find(':'));
                         });

TEST(StoredFrames, TheirNumberIsPartOfABakesKey) {
  const Walker w;
  const auto key = [&](const FrameCount& count) {
    Sha256 hash;
    hash_poses(hash, *w.bank, count);
    return hash.hex();
  };
  EXPECT_NE(key({10, 0}), key({11, 0}));
  EXPECT_NE(key({10, 0}), key({10, 4}));
  EXPECT_NE(key({10, 5}), key({10, 4}));
}

}  // namespace
}  // namespace crowdbench::renderers
