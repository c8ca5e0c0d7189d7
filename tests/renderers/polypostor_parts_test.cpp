#include "renderers/polypostor/polypostor_parts.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <numeric>
#include <set>
#include <span>

#include "core/error.h"
#include "scene/gltf/gltf.h"
#include "scene/mannequin/mannequin.h"
#include "test_paths.h"
#include "tests/renderers/gl_test_support.h"

namespace crowdbench::renderers {
namespace {

namespace fs = std::filesystem;
using testing::card;
using testing::card_of_two_joints;

TEST(PolypostorParts, AreThoseOfABodyWithoutReadingANameOnce) {
  for (const int joints : {20, 53}) {
    scene::Character body = scene::make_mannequin({.triangles = 2200, .joints = joints});
    const BodyParts parts = find_parts(body);
    EXPECT_EQ(parts.fine.count, 14) << "trunk, head, three of each limb";
    EXPECT_EQ(parts.coarse.count, 10) << "hands and feet go with what carries them";
    for (scene::Joint& j : body.skeleton.joints) j.name = "x";
    for (scene::Node& n : body.skeleton.nodes) n.name = "x";
    const BodyParts nameless = find_parts(body);
    EXPECT_EQ(nameless.fine.part_of, parts.fine.part_of);
    EXPECT_EQ(nameless.coarse.part_of, parts.coarse.part_of);
    // All of the surface belongs somewhere, and what is around joints to two.
    const CutCharacter cut = cut_at_parts(body, parts.fine);
    const auto area = [](const scene::Mesh& mesh, const std::vector<uint32_t>& triangles) {
      double sum = 0;
      for (const uint32_t t : triangles) {
        const auto corner = [&](uint32_t k) { return glm::dvec3(mesh.positions[mesh.indices[3 * t + k]]); };
        sum += 0.5 * glm::length(glm::cross(corner(1) - corner(0), corner(2) - corner(0)));
      }
      return sum;
    };
    std::vector<uint32_t> all(body.triangles());
    std::iota(all.begin(), all.end(), 0U);
    const double whole = area(body.mesh, all);
    double sum = 0;
    for (const auto& of_part : cut.triangles) {
      EXPECT_FALSE(of_part.empty());
      EXPECT_TRUE(std::is_sorted(of_part.begin(), of_part.end()));
      sum += area(cut.character->mesh, of_part);
    }
    EXPECT_GT(sum, 1.03 * whole);
    EXPECT_LT(sum, 1.3 * whole);
  }
}

TEST(PolypostorParts, AreCutWhereTheirWeightEnds) {
  // The upper joint's part ends at 0.3, the lower one's at 0.7.
  scene::Character c = card_of_two_joints();
  for (size_t v = 0; v < 4; ++v) c.mesh.uvs[v] = {c.mesh.positions[v].x, 10 * c.mesh.positions[v].y};
  const CutCharacter cut = cut_at_parts(c, {{0, 1}, 2});
  const scene::Mesh& mesh = cut.character->mesh;
  for (size_t part = 0; part < 2; ++part) {
    float low = 1;
    float high = 0;
    double area = 0;
    for (const uint32_t t : cut.triangles[part]) {
      std::array<glm::vec3, 3> p;
      for (uint32_t k = 0; k < 3; ++k) {
        const uint32_t v = mesh.indices[3 * t + k];
        p[k] = mesh.positions[v];
        low = std::min(low, p[k].y);
        high = std::max(high, p[k].y);
        EXPECT_NEAR(mesh.uvs[v].y, 10 * p[k].y, 1e-5) << "everything is interpolated";
        float upper = 0;
        for (int i = 0; i < 4; ++i) upper += mesh.joints[v][i] == 1 ? mesh.weights[v][i] : 0.0F;
        EXPECT_NEAR(upper, p[k].y, 1e-6);
      }
      const float twice = glm::cross(p[1] - p[0], p[2] - p[0]).z;
      EXPECT_GT(twice, 0) << "faces the same way";
      area += 0.5 * static_cast<double>(twice);
    }
    EXPECT_NEAR(low, part == 0 ? 0 : kBorderWeight, 1e-6);
    EXPECT_NEAR(high, part == 0 ? 1 - kBorderWeight : 1, 1e-6);
    EXPECT_NEAR(area, 1.4, 1e-5);
  }
  ASSERT_EQ(mesh.primitives.size(), 1U);
  EXPECT_EQ(mesh.primitives[0].vertex_count, mesh.positions.size());
  EXPECT_EQ(mesh.primitives[0].index_count, mesh.indices.size());
}

// The same card, its upper edge turned about the lower one by a right angle: a corner at 0.3 of the edge would be
// carried by t (1 - t) times what the two ends' matrices differ by over the edge beside it.
TEST(PolypostorParts, ATriangleIsNotCutWhereTheCutWouldLeaveTheSurface) {
  const scene::Character c = card_of_two_joints();
  const scene::Mat3x4 still{{{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}}};
  const scene::Mat3x4 turned{{{1, 0, 0, 0}, {0, 0, -1, 0}, {0, 1, 0, 0}}};
  const std::vector<std::vector<scene::Mat3x4>> poses = {{still, still}, {still, turned}};
  const PartMap map{{0, 1}, 2};
  // Upright edges: (A - B)(a - b) is (0, 1, 0) less (0, 0, 1), of length sqrt 2. The diagonal's sideways share cancels.
  const double leaves = 0.3 * 0.7 * std::sqrt(2.0);
  const auto count = [&](double metres) {
    const CutCharacter cut = cut_at_parts(c, map, {poses, metres});
    return std::array{cut.triangles[0].size(), cut.triangles[1].size(), cut.character->mesh.positions.size()};
  };
  const auto all_cut = count(leaves + 0.001);
  EXPECT_GT(all_cut[2], 4U);
  const auto none_cut = count(leaves - 0.001);
  EXPECT_EQ(none_cut[2], 4U) << "no corner is made";
  // Each triangle's middle is a third or two thirds of the way up: both parts have both.
  EXPECT_EQ(none_cut[0], 2U);
  EXPECT_EQ(none_cut[1], 2U);
  const auto in_rest = cut_at_parts(c, map, {std::span(poses).first(1), 0.001});
  EXPECT_EQ(in_rest.character->mesh.positions.size(), all_cut[2]) << "where both joints do the same nothing leaves";
}

TEST(PolypostorParts, ManyThatShareATriangleLeaveItToOne) {
  scene::Character c = card(1, 1);
  for (int j = 1; j < 4; ++j) {
    c.skeleton.nodes.push_back(c.skeleton.nodes[0]);
    c.skeleton.nodes.back().parent = 0;
    c.skeleton.joints.push_back(c.skeleton.joints[0]);
    c.skeleton.joints.back().node = j;
  }
  for (size_t v = 0; v < 4; ++v) {
    c.mesh.joints[v] = {0, 1, 2, 3};
    c.mesh.weights[v] = {0.24F, 0.24F, 0.28F, 0.24F};
  }
  const CutCharacter cut = cut_at_parts(c, {{0, 1, 2, 3}, 4});
  for (const size_t part : {0U, 1U, 3U}) EXPECT_TRUE(cut.triangles[part].empty());
  EXPECT_EQ(cut.triangles[2].size(), 2U);
}

TEST(PolypostorParts, AreFoundInForeignSkeletons) {
  const fs::path folder = fs::path(CROWDBENCH_SHARED_DIR) / "characters";
  if (!fs::exists(folder)) GTEST_SKIP() << "needs " << folder;
  for (const char* file : {"CesiumMan", "KayKitKnight", "Mannequiny", "QuaterniusKnight", "RiggedFigure", "Robot"}) {
    const scene::Character c = scene::load_character((folder / (std::string(file) + ".glb")).string());
    const BodyParts parts = find_parts(c);
    EXPECT_GE(parts.fine.count, 8) << file;
    EXPECT_LE(parts.fine.count, 20) << file;
    EXPECT_LE(parts.coarse.count, parts.fine.count) << file;
    std::set<int> used(parts.fine.part_of.begin(), parts.fine.part_of.end());
    EXPECT_EQ(*used.rbegin(), parts.fine.count - 1) << file;
  }
}

TEST(PolypostorParts, CanBeCutByHand) {
  scene::Character c = testing::two_bones();
  const std::string upper = c.skeleton.joints[1].name;
  for (const std::string& cut : {upper, std::string("1")}) {
    const BodyParts parts = cut_parts(c, cut, "here");
    EXPECT_EQ(parts.fine.count, 2);
    EXPECT_NE(parts.fine.part_of[0], parts.fine.part_of[1]);
  }
  EXPECT_EQ(cut_parts(c, "0", "here").fine.count, 1);
  EXPECT_THROW((void)cut_parts(c, upper + "y", "here"), Error);
  EXPECT_THROW((void)cut_parts(c, "2", "here"), Error);
}

}  // namespace
}  // namespace crowdbench::renderers
