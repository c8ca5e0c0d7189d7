// A figure asked for at so many pixels is so many rows tall in its picture, whoever it is and in whichever clip it
// stands.
#include <gtest/gtest.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <filesystem>
#include <string>
#include <vector>

#include "bench/experiments/quality.h"
#include "renderers/gl/context.h"
#include "scene/cast/open_character.h"
#include "test_paths.h"
#include "tests/support/sanitized.h"

namespace crowdbench::bench {
namespace {

constexpr double kHeight = 240;  // pixels

int rows_drawn(const ImageU32& ids) {
  int first = ids.height;
  int last = -1;
  for (int y = 0; y < ids.height; ++y)
    for (int x = 0; x < ids.width; ++x)
      if (*ids.at(x, y) != 0) {
        first = std::min(first, y);
        last = y;
      }
  return last - first + 1;
}

// Of colours, which supersampling thickens by what its samples meet beside a pixel's middle.
int rows_coloured(const Image8& picture) {
  int first = picture.height;
  int last = -1;
  for (int y = 0; y < picture.height; ++y)
    for (int x = 0; x < picture.width; ++x) {
      if (std::equal(picture.at(x, y), picture.at(x, y) + picture.channels, picture.at(0, 0))) continue;
      first = std::min(first, y);
      last = y;
    }
  return last - first + 1;
}

struct Standing {
  const char* file;  // of ../shared/characters; the mannequin where there is no dot
  const char* clip;
};

// Clips in which nobody reaches far towards the camera, which a lens shows larger, seen from the side.
class FigureHeight : public ::testing::TestWithParam<Standing> {};

TEST_P(FigureHeight, IsTheRowsOfItsPicture) {
  const std::string name = GetParam().file;
  const bool shared = name.find('.') != std::string::npos;
  const std::filesystem::path path = std::filesystem::path(CROWDBENCH_SHARED_DIR) / "characters" / name;
  if (shared && !std::filesystem::exists(path)) GTEST_SKIP() << path << " is not here";
  if (shared) CROWDBENCH_SKIP_SANITIZED("the mannequin");
  scene::CharacterEntry entry;
  entry.source = shared ? path.string() : name;
  entry.clips = {GetParam().clip};
  QualitySetup setup;
  setup.character = std::make_shared<const scene::Character>(scene::open_character(entry));
  setup.representations = {"mesh"};
  const int clip = scene::require_clip(*setup.character, GetParam().clip);
  const double start = setup.character->clips[static_cast<size_t>(clip)].start;
  setup.views = {{kHeight, 0, 0, clip, start}, {kHeight, 90, 0, clip, start}};
  gl::Context context;
  std::vector<int> rows;
  compute_quality(context, setup, [&](const QualityRow&, const QualityPictures& pictures) {
    rows.push_back(rows_drawn(pictures.reference.ids));
  });
  ASSERT_EQ(rows.size(), 2U);
  for (const int drawn : rows) EXPECT_NEAR(drawn, kHeight, 0.02 * kHeight) << name << " " << GetParam().clip;
}

// Of all 81 clips of the shared characters that stand upright, those whose tips are thinner than a pixel: at 100 rows
// with one sample a pixel nine rows of a blade fall between samples, and three of a sword. With nine a pixel both are
// met from 105 rows on; below, the blade's end shows no 255th of a pixel.
class ThinTips : public ::testing::TestWithParam<Standing> {};

TEST_P(ThinTips, AreDrawnToTheirEndsWhereSamplesAreDense) {
  const std::filesystem::path path = std::filesystem::path(CROWDBENCH_SHARED_DIR) / "characters" / GetParam().file;
  if (!std::filesystem::exists(path)) GTEST_SKIP() << path << " is not here";
  CROWDBENCH_SKIP_SANITIZED("FigureHeight of the mannequin");
  scene::CharacterEntry entry;
  entry.source = path.string();
  entry.clips = {GetParam().clip};
  QualitySetup setup;
  setup.character = std::make_shared<const scene::Character>(scene::open_character(entry));
  setup.representations = {"mesh"};
  setup.rows = 200;
  setup.antialiasing.supersample = 3;
  const int clip = scene::require_clip(*setup.character, GetParam().clip);
  constexpr double kRows = 110;
  setup.views = {{kRows, 0, 0, clip, setup.character->clips[static_cast<size_t>(clip)].start}};
  gl::Context context;
  int rows = 0;
  compute_quality(context, setup, [&](const QualityRow&, const QualityPictures& pictures) {
    rows = rows_coloured(pictures.reference.colour);
  });
  EXPECT_NEAR(rows, kRows, 0.02 * kRows);
}

std::string standing_name(const ::testing::TestParamInfo<Standing>& test) {
  std::string name = std::string(test.param.file) + "_" + test.param.clip;
  for (char& c : name)
    if (std::isalnum(static_cast<unsigned char>(c)) == 0) c = '_';
  return name;
}

INSTANTIATE_TEST_SUITE_P(Characters, ThinTips,
                         ::testing::Values(Standing{"CyberpunkCharacter.glb", "CharacterArmature|Gun_Shoot"},
                                           Standing{"KayKitKnight.glb", "Walking_A"}),
                         standing_name);

INSTANTIATE_TEST_SUITE_P(
    Characters, FigureHeight,
    ::testing::Values(Standing{"mannequin", "walk"}, Standing{"mannequin", "idle"}, Standing{"mannequin", "run"},
                      Standing{"mannequin", "wave"}, Standing{"KayKitKnight.glb", "Walking_A"},
                      Standing{"KayKitKnight.glb", "Idle"}, Standing{"KayKitKnight.glb", "Running_A"},
                      Standing{"QuaterniusKnight.glb", "HumanArmature|Walking"},
                      Standing{"QuaterniusKnight.glb", "HumanArmature|Idle"}, Standing{"Robot.glb", "Robot_Walking"},
                      Standing{"Robot.glb", "Robot_Idle"}, Standing{"CesiumMan.glb", "0"},
                      Standing{"RiggedFigure.glb", "0"}, Standing{"Mannequiny.glb", "walk"},
                      Standing{"Mannequiny.glb", "idle"}, Standing{"greenman.glb", "1_idle"},
                      Standing{"greenman.glb", "2_move"}, Standing{"Fox.glb", "Survey"}, Standing{"Fox.glb", "Walk"},
                      Standing{"CyberpunkCharacter.glb", "CharacterArmature|Walk"},
                      Standing{"CyberpunkCharacter.glb", "CharacterArmature|Idle_Neutral"}),
    standing_name);

}  // namespace
}  // namespace crowdbench::bench
