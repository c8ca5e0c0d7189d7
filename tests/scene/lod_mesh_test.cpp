#include "scene/pose/lod_mesh.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <set>

#include "scene/cast/open_character.h"
#include "scene/mannequin/mannequin.h"
#include "test_paths.h"
#include "tests/support/sanitized.h"

namespace crowdbench::scene {
namespace {

size_t triangles_of(const LodMesh& lod) { return lod.mesh.indices.size() / 3; }

PoseBank default_bank(const Character& character) { return {character, {character.placement.default_clip}}; }

struct Known {
  const char* file;  // of ../shared/characters; the mannequin where there is no dot
  size_t triangles;
  double rms;  // of the height, at most: just above what is reached
  double max;
};

class LodMeshOf : public ::testing::TestWithParam<Known> {
 protected:
  void SetUp() override {
    CROWDBENCH_SKIP_SANITIZED("LodMesh.MeetsEachKindOfRequest");
    const std::string name = GetParam().file;
    const auto path = std::filesystem::path(CROWDBENCH_SHARED_DIR) / "characters" / name;
    const bool shared = name.find('.') != std::string::npos;
    if (shared && !std::filesystem::exists(path)) GTEST_SKIP() << path << " is not here";
    character_ = open_character(shared ? path.string() : name, LoadOptions{});
  }
  Character character_;
};

TEST_P(LodMeshOf, MeetsItsBudgetAndItsError) {
  const PoseBank bank = default_bank(character_);
  const LodMesh lod = make_lod_mesh(character_, bank, {.triangles = GetParam().triangles});
  EXPECT_LE(triangles_of(lod), GetParam().triangles);
  EXPECT_GE(static_cast<double>(triangles_of(lod)), 0.98 * static_cast<double>(GetParam().triangles));
  EXPECT_TRUE(lod.why_more.empty()) << lod.why_more;
  const LodError error = lod_error(character_, lod.mesh, bank);
  const double height = character_.placement.height;
  EXPECT_LE(error.distance.rms / height, GetParam().rms);
  EXPECT_GE(error.distance.rms / height, 0.8 * GetParam().rms) << "it does better: move the bound";
  EXPECT_LE(error.distance.max / height, GetParam().max);
  std::set<int> before;
  std::set<int> after;
  for (const Primitive& p : character_.mesh.primitives) before.insert(p.material);
  for (const Primitive& p : lod.mesh.primitives)
    if (p.index_count > 0) after.insert(p.material);
  EXPECT_EQ(after, before) << "every material is still to be seen";
}

// Measured; the fox's and the robot's vertices are all split, where meshoptimizer removes nothing.
INSTANTIATE_TEST_SUITE_P(
    Characters, LodMeshOf,
    ::testing::Values(Known{"mannequin", 500, 0.0050, 0.026}, Known{"CesiumMan.glb", 500, 0.0024, 0.016},
                      Known{"Fox.glb", 250, 0.0080, 0.050}, Known{"Mannequiny.glb", 500, 0.0070, 0.035},
                      Known{"Robot.glb", 500, 0.0120, 0.050}, Known{"CyberpunkCharacter.glb", 500, 0.0085, 0.037}));

TEST(LodMesh, MeetsEachKindOfRequest) {
  const Character character = make_mannequin({.triangles = 2200});
  const PoseBank bank = default_bank(character);
  const double all = static_cast<double>(character.triangles());
  EXPECT_NEAR(static_cast<double>(triangles_of(make_lod_mesh(character, bank, {.ratio = 0.1}))), all / 10, 0.002 * all);
  EXPECT_EQ(make_lod_mesh(character, bank, {.ratio = 1}).mesh.indices, character.mesh.indices);
  EXPECT_EQ(make_lod_mesh(character, bank, {.triangles = 1'000'000}).mesh.indices, character.mesh.indices);
  const LodMesh near = make_lod_mesh(character, bank, {.error = 0.05});
  EXPECT_LE(lod_error(character, near.mesh, bank).distance.max, 0.05);
  EXPECT_LT(triangles_of(near), character.triangles() / 2);
  const LodMesh one = make_lod_mesh(character, bank, {.triangles = 1});
  EXPECT_GE(triangles_of(one), character.materials.size());
  EXPECT_FALSE(one.why_more.empty());
}

TEST(LodMesh, TakesTheBindPoseAndManyClips) {
  const Character character = make_mannequin({.triangles = 500});
  const PoseBank still(character, {-1});
  EXPECT_LE(triangles_of(make_lod_mesh(character, still, {.triangles = 200})), 200U);
  std::vector<int> all;
  for (size_t i = 0; i < character.clips.size(); ++i) all.push_back(static_cast<int>(i));
  const PoseBank bank(character, all);
  const LodMesh lod = make_lod_mesh(character, bank, {.triangles = 200});
  EXPECT_LE(triangles_of(lod), 200U);
  EXPECT_EQ(lod.mesh.indices, make_lod_mesh(character, bank, {.triangles = 200}).mesh.indices) << "the same every time";
  EXPECT_GE(lod_error(character, lod.mesh, bank).poses, all.size()) << "every clip is looked at";
  EXPECT_LT(lod_error(character, character.mesh, bank).distance.max, 1e-6) << "rounding of the samples' places";
}

TEST(LodMesh, IsNearerThanMeshoptimizerInTheOnePose) {
  const Character character = make_mannequin();
  const PoseBank bank = default_bank(character);
  const MeshoptimizerMesh alone = meshoptimizer_mesh(character, bank, 500);
  const LodMesh lod = make_lod_mesh(character, bank, {.triangles = 500});
  EXPECT_GT(alone.stated_error, 0);
  EXPECT_LT(lod_error(character, lod.mesh, bank).distance.max, lod_error(character, alone.mesh, bank).distance.max);
}

}  // namespace
}  // namespace crowdbench::scene
