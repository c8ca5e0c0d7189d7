// The outside characters: counts as measured by others, poses as computed by an independent skinner.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "scene/gltf/gltf.h"
#include "scene/pose/pose.h"
#include "test_paths.h"
#include "tests/scene/posed_height.h"
#include "tests/support/sanitized.h"

namespace crowdbench::scene {
namespace {

const std::filesystem::path kCharacters = std::filesystem::path(CROWDBENCH_SHARED_DIR) / "characters";

struct Expected {
  const char* file;
  size_t triangles, vertices, joints, rigid, primitives, materials, clips, images;
  bool colours;
  friend void PrintTo(const Expected& e, std::ostream* out) { *out << e.file; }
};

class GltfShared : public testing::TestWithParam<Expected> {};

TEST_P(GltfShared, HasTheCountsOfItsManifest) {
  const Expected& e = GetParam();
  if (!std::filesystem::exists(kCharacters / e.file)) GTEST_SKIP() << "needs shared/characters/" << e.file;
  const Character c = load_character(kCharacters / e.file);
  EXPECT_EQ(c.file_triangles, e.triangles);
  EXPECT_EQ(c.file_vertices, e.vertices);
  const auto rigid = static_cast<size_t>(
      std::count_if(c.skeleton.joints.begin(), c.skeleton.joints.end(), [](const Joint& j) { return j.rigid; }));
  EXPECT_EQ(c.skeleton.joints.size() - rigid, e.joints);
  EXPECT_EQ(rigid, e.rigid);
  EXPECT_EQ(c.mesh.primitives.size(), e.primitives);
  EXPECT_EQ(c.materials.size(), e.materials);
  EXPECT_EQ(c.clips.size(), e.clips);
  EXPECT_EQ(c.images.size(), e.images);
  EXPECT_EQ(!c.mesh.colours.empty(), e.colours);
  EXPECT_EQ(c.file_max_influences, 4);
  EXPECT_NEAR(c.placement.height, 1.75, 1e-9);
  for (const glm::vec4& w : c.mesh.weights) ASSERT_NEAR(w.x + w.y + w.z + w.w, 1.0F, 1e-6F);
  for (const glm::vec3& n : c.mesh.normals) ASSERT_NEAR(glm::length(n), 1.0F, 1e-5F);
}

INSTANTIATE_TEST_SUITE_P(Files, GltfShared,
                         testing::Values(Expected{"RiggedFigure.glb", 256, 370, 19, 0, 1, 1, 1, 0, false},
                                         Expected{"QuaterniusKnight.glb", 956, 2058, 31, 0, 3, 3, 12, 0, false},
                                         Expected{"Robot.glb", 3238, 7218, 43, 0, 19, 3, 14, 0, false},
                                         Expected{"CesiumMan.glb", 4672, 3273, 19, 0, 1, 1, 1, 1, false},
                                         Expected{"KayKitKnight.glb", 6952, 7024, 41, 9, 15, 1, 76, 1, false},
                                         Expected{"Mannequiny.glb", 13932, 10366, 45, 0, 3, 3, 11, 0, true}),
                         [](const auto& test) { return std::filesystem::path(test.param.file).stem().string(); });

// Metres a second of clips in place: walks, runs and strafes go, blows and falls do not.
TEST(GltfSharedSpeeds, AreOfWhatSteps) {
  struct Speed {
    const char* clip;
    double of;
  };
  const std::pair<const char*, std::vector<Speed>> files[] = {
      {"CesiumMan.glb", {{"0", 1.090}}},
      {"QuaterniusKnight.glb", {{"HumanArmature|Walking", 1.091}, {"HumanArmature|Run", 4.144}}},
      {"Robot.glb", {{"Robot_Walking", 1.758}, {"Robot_Running", 5.318}}},
      {"Mannequiny.glb", {{"walk", 1.618}, {"run", 6.672}}},
      {"KayKitKnight.glb",
       {{"Walking_A", 0.422},
        {"Walking_Backwards", 0.431},
        {"Running_B", 1.548},
        {"Running_Strafe_Left", 2.541},
        {"1H_Melee_Attack_Stab", 0},
        {"Death_B", 0},
        {"Hit_A", 0},
        {"Sit_Chair_StandUp", 0}}}};
  for (const auto& [file, speeds] : files) {
    if (!std::filesystem::exists(kCharacters / file)) GTEST_SKIP() << "needs shared/characters/" << file;
    const Character c = load_character(kCharacters / file);
    for (const Speed& speed : speeds)
      EXPECT_NEAR(c.motion.at(static_cast<size_t>(require_clip(c, speed.clip))).ground_speed, speed.of, 6e-4)
          << file << " " << speed.clip;
  }
}

TEST(GltfSharedPoses, AgreeWithAnIndependentSkinner) {
  const std::filesystem::path golden = kCharacters / "golden_pose.json";
  if (!std::filesystem::exists(golden)) GTEST_SKIP() << "needs shared/characters/golden_pose.json";
  std::ifstream stream(golden);
  const nlohmann::json poses = nlohmann::json::parse(stream).at("poses");
  LoadOptions options;
  options.normalise.height = std::nullopt;
  options.undrawn = true;
  std::string file;
  Character c;
  size_t checked = 0;
  for (const auto& pose : poses) {
    if (pose.at("file") != file) {
      file = pose.at("file");
      c = load_character(kCharacters / file, options);
    }
    SCOPED_TRACE(file + " " + pose.dump().substr(0, 120));
    const auto positions = skin_positions(c.mesh, joint_matrices(c, pose.at("clip_index"), pose.at("t")));
    ASSERT_EQ(pose.at("verts").get<size_t>(), c.mesh.file_vertex_count());
    const double height = pose.at("bbox_max")[1].get<double>() - pose.at("bbox_min")[1].get<double>();
    for (const auto& [index, expected] : pose.at("samples").items()) {
      size_t v = std::stoul(index);
      if (!c.mesh.file_vertices.empty()) v = c.mesh.file_vertices[v];
      for (int axis = 0; axis < 3; ++axis)
        EXPECT_NEAR(positions[v][axis], expected[static_cast<size_t>(axis)].get<double>(), 1e-5 + 1e-5 * height);
      ++checked;
    }
  }
  EXPECT_EQ(checked, 262U);  // vertices, over 44 poses
}

// A figure drawn in any clip that stands upright is as tall as asked when that clip is the one in use.
TEST(GltfSharedHeights, AreThoseOfTheClipInUse) {
  CROWDBENCH_SKIP_SANITIZED("GltfSharedPoses.AgreeWithAnIndependentSkinner");
  if (!std::filesystem::exists(kCharacters)) GTEST_SKIP() << "needs shared/characters";
  size_t checked = 0;
  for (const auto& entry : std::filesystem::directory_iterator(kCharacters)) {
    if (entry.path().extension() != ".glb") continue;
    const Character plain = load_character(entry.path());
    // Some clips of every file: loading it again for all of them takes minutes.
    const size_t step = std::max<size_t>(1, plain.clips.size() / 6);
    for (size_t clip = 0; clip < plain.clips.size(); clip += step) {
      if (test::posed_height(plain, static_cast<int>(clip)) < 0.78 * 1.75) continue;  // lies, sits or crouches
      LoadOptions options;
      options.normalise.clips = {std::to_string(clip)};
      const Character c = load_character(entry.path(), options);
      EXPECT_NEAR(test::posed_height(c, static_cast<int>(clip)), 1.75, 0.001) << entry.path() << " clip " << clip;
      ++checked;
    }
  }
  EXPECT_GT(checked, 20U);
}

}  // namespace
}  // namespace crowdbench::scene
