// What ships in bench/scenarios can be asked for as it stands.
#include <gtest/gtest.h>

#include <filesystem>
#include <set>

#include "renderers/representation.h"
#include "scene/cast/load_cast.h"
#include "scene/crowd/crowd.h"
#include "scene/scenario/parse_scenario.h"
#include "scene/scenario/scenario.h"
#include "test_paths.h"

namespace crowdbench::bench {
namespace {

scene::Scenario shipped(const std::string& name) {
  return scene::load_scenario(std::filesystem::path(CROWDBENCH_SOURCE_DIR) / "bench/scenarios" / (name + ".toml"));
}

TEST(ShippedScenarios, NameRepresentationsThatExist) {
  int count = 0;
  for (const auto& entry : std::filesystem::directory_iterator(CROWDBENCH_SOURCE_DIR "/bench/scenarios")) {
    const scene::Scenario s = scene::load_scenario(entry.path());
    EXPECT_NO_THROW(renderers::parse_spec(s.representation)) << s.name;
    ++count;
  }
  EXPECT_GE(count, 8);
}

TEST(ShippedScenarios, ExperimentsSayWhatTheirNamesSay) {
  EXPECT_EQ(shipped("geometry_or_impostor").crowd.agents, 1000U);
  EXPECT_EQ(renderers::parse_spec(shipped("impostors_with_100_meshes").representation).text(),
            "hybrid(mesh,flat,nearest=100)");
  EXPECT_EQ(shipped("three_levels").crowd.agents, 95U + 532U + 16950U);
  for (const size_t types : {4U, 10U}) {
    scene::Scenario s = shipped("character_types_" + std::to_string(types));
    ASSERT_EQ(s.characters.size(), types);
    std::set<std::string> contents;
    for (scene::CharacterEntry& entry : s.characters) {
      EXPECT_EQ(entry.source, "mannequin:triangles=2200");
      entry.source = "mannequin:triangles=500";  // the same but for its weight on the test's time
    }
    for (const auto& character : scene::load_cast(s).characters) contents.insert(character->content_hash);
    EXPECT_EQ(contents.size(), types) << "no two types share a bake";
  }
}

}  // namespace
}  // namespace crowdbench::bench
