// Levels of detail in a file: by MSFT_lod and by name. One is drawn, the others are there to be asked for.
#include <gtest/gtest.h>

#include <algorithm>

#include "core/error.h"
#include "gltf_builder.h"

namespace crowdbench::scene {
namespace {

using nlohmann::json;
using test::bending_card;
using test::Builder;
using test::load;

// Mesh 1: the card with one triangle; mesh 2: another with none of its upper edge.
Builder card_of_levels() {
  Builder b = bending_card();
  for (const std::vector<uint16_t>& corners : {std::vector<uint16_t>{0, 1, 2}, {0, 1, 3}}) {
    json mesh = b.doc["meshes"][0];
    mesh["primitives"][0]["indices"] = b.accessor<uint16_t>(corners, "SCALAR");
    b.doc["meshes"].push_back(mesh);
  }
  return b;
}

void add_node(Builder& b, const std::string& name, int mesh, bool in_scene) {
  b.doc["nodes"].push_back({{"name", name}, {"mesh", mesh}, {"skin", 0}});
  if (in_scene) b.doc["scenes"][0]["nodes"].push_back(b.doc["nodes"].size() - 1);
}

size_t notes(const Character& c) {
  return static_cast<size_t>(std::ranges::count_if(
      c.warnings, [](const std::string& w) { return w.find("levels of detail") != std::string::npos; }));
}

TEST(GltfLevels, AreReadByName) {
  Builder b = card_of_levels();
  const std::vector<std::pair<std::string, std::string>> pairs = {
      {"Body_LOD0", "Body_LOD1"}, {"body.lod0", "Body.LOD1"}, {"LOD_0", "LOD_1"}, {"Body LOD1", "Body LOD3"}};
  add_node(b, "", 1, true);
  for (const auto& [fine, coarse] : pairs) {
    b.doc["nodes"][0]["name"] = fine;
    b.doc["nodes"][3]["name"] = coarse;
    const Character c = load(b);
    EXPECT_EQ(c.triangles(), 2U) << fine;
    ASSERT_EQ(c.levels.size(), 1U) << fine;
    EXPECT_EQ(c.levels[0].indices.size(), 3U) << fine;
    EXPECT_EQ(c.levels[0].positions.size(), c.levels[0].weights.size());
    EXPECT_EQ(c.skeleton.joints.size(), 2U) << "one skin";
    EXPECT_EQ(notes(c), 1U);
  }
}

TEST(GltfLevels, OtherNamesAreNone) {
  Builder b = card_of_levels();
  add_node(b, "", 1, true);
  const std::vector<std::pair<std::string, std::string>> pairs = {
      {"Body_LOD0", "Head_LOD1"}, {"Body_LOD0", "Body"}, {"Body0", "Body1"}, {"Explode0", "Explode1"}};
  for (const auto& [first, second] : pairs) {
    b.doc["nodes"][0]["name"] = first;
    b.doc["nodes"][3]["name"] = second;
    const Character c = load(b);
    EXPECT_EQ(c.triangles(), 3U) << first;
    EXPECT_TRUE(c.levels.empty()) << first;
    EXPECT_EQ(notes(c), 0U);
  }
}

TEST(GltfLevels, ThoseOfMsftLodNeedNotBeInTheScene) {
  Builder b = card_of_levels();
  add_node(b, "", 1, false);
  add_node(b, "", 2, false);
  b.doc["nodes"][0]["extensions"]["MSFT_lod"]["ids"] = {3, 4};
  b.doc["extensionsUsed"] = {"MSFT_lod"};
  const Character c = load(b);
  EXPECT_EQ(c.triangles(), 2U);
  ASSERT_EQ(c.levels.size(), 2U);
  EXPECT_EQ(c.levels[0].indices.size(), 3U);
  EXPECT_NE(c.levels[0].positions, c.levels[1].positions);
  EXPECT_EQ(c.warnings.size(), 1U) << "the extension is read";
  Builder plain = bending_card();
  EXPECT_EQ(c.placement.height, load(plain).placement.height);
}

TEST(GltfLevels, WhatHasFewerIsDrawnInItsCoarsest) {
  Builder b = card_of_levels();
  add_node(b, "Body_LOD1", 1, true);
  add_node(b, "Body_LOD2", 1, true);
  add_node(b, "Hat", 2, true);
  add_node(b, "Bag_LOD0", 0, true);
  add_node(b, "Bag_LOD1", 1, true);
  b.doc["nodes"][0]["name"] = "Body_LOD0";
  const Character c = load(b);
  EXPECT_EQ(c.triangles(), 2U + 1 + 2);
  ASSERT_EQ(c.levels.size(), 2U);
  EXPECT_EQ(c.levels[0].indices.size(), 3U * 3);
  EXPECT_EQ(c.levels[1].indices.size(), 3U * 3);
  LoadOptions without = test::as_is();
  without.hide = {"Body_LOD0"};
  EXPECT_EQ(load(b, without).triangles(), 1U + 1 + 2) << "the next one takes its place";
}

// A rigid mesh of a level hangs where the finest one does.
TEST(GltfLevels, StandWhereTheFinestOneStands) {
  Builder b = card_of_levels();
  b.doc["nodes"].push_back({{"mesh", 0}});
  b.doc["nodes"].push_back({{"mesh", 1}});
  b.doc["nodes"][2]["children"] = {3};
  b.doc["nodes"][3]["extensions"]["MSFT_lod"]["ids"] = {4};
  b.doc["extensionsUsed"] = {"MSFT_lod"};
  const Character c = load(b);
  ASSERT_EQ(c.levels.size(), 1U);
  const Joint& joint = c.skeleton.joints[c.levels[0].joints.back()[0]];
  EXPECT_TRUE(joint.rigid);
  EXPECT_EQ(c.skeleton.nodes[static_cast<size_t>(joint.node)].parent, c.skeleton.joints[1].node) << "on the arm";
}

TEST(GltfLevels, FaultsAreRefusedAndKnotsUndone) {
  Builder b = card_of_levels();
  b.doc["extensionsUsed"] = {"MSFT_lod"};
  add_node(b, "", 1, false);
  json& lod = b.doc["nodes"][0]["extensions"]["MSFT_lod"];
  for (const json& bad : {json{{"ids", 3}}, json{{"ids", {9}}}, json{{"ids", {0}}}, json{{"ids", {3, 3}}},
                          json{{"ids", {-1}}}, json::object()}) {
    lod = bad;
    EXPECT_THROW(load(b), Error) << bad.dump();
  }
  // The coarser one holds the finer one.
  lod = {{"ids", {3}}};
  b.doc["nodes"][3]["children"] = {0};
  b.doc["scenes"][0]["nodes"] = {3, 1};
  EXPECT_EQ(load(b).triangles(), 2U);
  b.doc["scenes"][0]["nodes"] = {1};
  EXPECT_THROW(load(b), Error) << "nothing is in the scene";
}

}  // namespace
}  // namespace crowdbench::scene
