// The commands that print facts, from outside: `pose` against the library's skinning (which scene's tests hold to
// oracles), `inspect` against the loaded character and a reloaded export, `bake` and its cache.
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "scene/cast/open_character.h"
#include "scene/gltf/gltf.h"
#include "scene/pose/pose.h"
#include "tests/support/driver.h"
#include "tests/support/scratch_folder.h"

namespace crowdbench::bench {
namespace {

using nlohmann::json;
using support::run_driver;

class Facts : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!support::driver_is_built()) GTEST_SKIP() << "the driver is not built";
  }

  json facts(const std::string& arguments) const {
    const support::Outcome outcome =
        run_driver("CROWDBENCH_CACHE_DIR='" + (folder_ / "cache").string() + "'", arguments + " --json", false);
    EXPECT_EQ(outcome.status, 0) << arguments;
    return json::parse(outcome.text, nullptr, false);
  }
  // One line, status 2, and the line says what is wrong.
  static void refuses(const std::string& arguments, const std::string& says) {
    SCOPED_TRACE(arguments);
    const support::Outcome outcome = run_driver("", arguments);
    EXPECT_EQ(outcome.status, 2) << outcome.text;
    EXPECT_NE(outcome.text.find(says), std::string::npos) << outcome.text;
    EXPECT_LE(std::count(outcome.text.begin(), outcome.text.end(), '\n'), 1) << outcome.text;
  }
  support::ScratchFolder folder_;
};
using FactsGl = Facts;

TEST_F(Facts, PosePrintsTheSkinnedVerticesAndTheirBounds) {
  scene::LoadOptions raw;
  raw.normalise.height = std::nullopt;
  const scene::Character character = scene::open_character("mannequin:triangles=500", raw);
  const json by_name = facts("pose mannequin:triangles=500 --clip run --time 0.2 --vertex 0 --vertex 17");
  const json by_index = facts("pose mannequin:triangles=500 --clip 1 --time 0.2 --vertex 0 --vertex 17");
  EXPECT_EQ(by_name, by_index);
  EXPECT_EQ(by_name.at("clip"), "run");
  EXPECT_EQ(by_name.at("clip_index"), 1);
  EXPECT_EQ(by_name.at("count"), character.mesh.file_vertex_count());
  ASSERT_EQ(by_name.at("samples").size(), 2U);
  const auto positions = scene::skin_positions(character.mesh, scene::joint_matrices(character, 1, 0.2));
  for (const size_t v : {size_t{0}, size_t{17}}) {
    const size_t drawn = character.mesh.file_vertices.empty() ? v : character.mesh.file_vertices[v];
    const glm::dvec3& expected = positions[drawn];
    for (int k = 0; k < 3; ++k) {
      const double value = by_name.at("samples").at(std::to_string(v)).at(k).get<double>();
      EXPECT_NEAR(value, expected[k], 1e-9) << v << " " << k;
      EXPECT_LE(by_name.at("bbox_min").at(k).get<double>(), value);
      EXPECT_GE(by_name.at("bbox_max").at(k).get<double>(), value);
    }
  }
  // Another time moves them; a time past the keys is the last key's.
  EXPECT_NE(facts("pose mannequin:triangles=500 --clip run --time 0.4 --vertex 17").at("samples").at("17"),
            by_name.at("samples").at("17"));
  EXPECT_EQ(facts("pose mannequin:triangles=500 --clip run --time 9").at("bbox_max"),
            facts("pose mannequin:triangles=500 --clip run --time 0.7").at("bbox_max"));
}

TEST_F(Facts, PoseWithoutAClipIsTheBindPose) {
  const json bind = facts("pose mannequin:triangles=500");
  EXPECT_TRUE(bind.at("clip").is_null());
  EXPECT_TRUE(bind.at("clip_index").is_null());
  EXPECT_EQ(bind.at("samples").size(), 1U) << "vertex 0 when none is named";
  // The mannequin's bind pose is its T-pose: as wide as a person's arms, not as a person's shoulders.
  const double width = bind.at("bbox_max").at(0).get<double>() - bind.at("bbox_min").at(0).get<double>();
  const json idle = facts("pose mannequin:triangles=500 --clip idle");
  EXPECT_GT(width, 1.5 * (idle.at("bbox_max").at(0).get<double>() - idle.at("bbox_min").at(0).get<double>()));
}

TEST_F(Facts, PoseRefusesWhatIsNotThere) {
  refuses("pose mannequin --vertex 100000", "past the last vertex");
  refuses("pose mannequin --clip wlak", "wlak");
  refuses("pose mannequin --clip 9", "9");
  refuses("pose mannequin --time nan", "--time");
  refuses("pose nowhere.glb", "nowhere.glb");
}

TEST_F(Facts, InspectAgreesWithTheCharacterAndWithItsOwnExport) {
  const std::string saved = (folder_ / "m.glb").string();
  const json built_in = facts("inspect mannequin:triangles=500 --out '" + saved + "'");
  const json loaded = facts("inspect '" + saved + "'");
  const scene::Character character = scene::open_character("mannequin:triangles=500", {});
  EXPECT_EQ(built_in.at("triangles"), character.triangles());
  EXPECT_EQ(built_in.at("joints"), 20);
  EXPECT_NEAR(built_in.at("height").get<double>(), 1.75, 1e-6);
  ASSERT_EQ(built_in.at("clips").size(), 4U);
  EXPECT_EQ(built_in.at("clips").at(0).at("name"), "walk");
  EXPECT_NEAR(built_in.at("clips").at(0).at("seconds").get<double>(), 1.06, 1e-9);
  for (const char* key : {"triangles", "joints", "vertices", "influences"})
    EXPECT_EQ(loaded.at(key), built_in.at(key)) << key;
  ASSERT_EQ(loaded.at("clips").size(), 4U);
  for (size_t c = 0; c < 4; ++c) {
    EXPECT_EQ(loaded.at("clips").at(c).at("name"), built_in.at("clips").at(c).at("name"));
    EXPECT_NEAR(loaded.at("clips").at(c).at("seconds").get<double>(),
                built_in.at("clips").at(c).at("seconds").get<double>(), 1e-6);
  }
  // The export moves as the original does: floats in a file against the generator's doubles.
  const json a = facts("pose mannequin:triangles=500 --clip walk --time 0.3 --vertex 40").at("samples").at("40");
  const json b = facts("pose '" + saved + "' --clip walk --time 0.3 --vertex 40").at("samples").at("40");
  for (int k = 0; k < 3; ++k) EXPECT_NEAR(a.at(k).get<double>(), b.at(k).get<double>(), 1e-5);
}

TEST_F(Facts, InspectRefusesAndLeavesNothingHalfWritten) {
  refuses("inspect '" + (folder_ / "none.glb").string() + "'", "none.glb");
  refuses("inspect mannequin --out /proc/nowhere/m.glb", "/proc/nowhere");
  refuses("inspect mannequin:triangles=lots", "triangles");
}

TEST_F(FactsGl, BakeTellsBytesAndReadsItsCacheTheSecondTime) {
  const std::string what =
      "bake --representation flat:views=sphere-8x3,texels=32,frames=2 --character mannequin:triangles=500";
  const json first = facts(what);
  EXPECT_FALSE(first.at("cached").get<bool>());
  EXPECT_EQ(first.at("facts").at("views"), 24.0);
  EXPECT_EQ(first.at("facts").at("tiles"), 48.0);
  EXPECT_GT(first.at("texture_bytes").get<uint64_t>(), 0U);
  EXPECT_EQ(first.at("gpu_bytes"),
            first.at("texture_bytes").get<uint64_t>() + first.at("buffer_bytes").get<uint64_t>());
  EXPECT_GT(first.at("disk_bytes").get<uint64_t>(), 0U);
  uint64_t on_disk = 0;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder_ / "cache"))
    if (entry.is_regular_file()) on_disk += entry.file_size();
  EXPECT_EQ(on_disk, first.at("disk_bytes").get<uint64_t>());

  const json second = facts(what);
  EXPECT_TRUE(second.at("cached").get<bool>());
  EXPECT_EQ(second.at("cache_key"), first.at("cache_key"));
  EXPECT_EQ(second.at("texture_bytes"), first.at("texture_bytes"));
  EXPECT_FALSE(facts(what + " --force").at("cached").get<bool>());
  EXPECT_NE(facts("bake --representation flat:views=sphere-8x3,texels=32,frames=3 --character mannequin:triangles=500")
                .at("cache_key"),
            first.at("cache_key"));
}

// A driver without S3TC, as Mesa pretends to be one on demand: RGBA8, and one line that says so.
TEST_F(FactsGl, CompressionFallsBackWhereTheDriverLacksIt) {
  const std::string common = "bake --representation flat:views=sphere-4x1,texels=32,frames=1";
  const std::string cast = " --character mannequin:triangles=500 --character mannequin:triangles=2200 --no-cache";
  const std::string without = "MESA_EXTENSION_OVERRIDE=-GL_EXT_texture_compression_s3tc";
  const json plain = facts(common + cast);
  const json compressed = facts(common + ",compress=bc" + cast);
  if (plain.at("renderer").get<std::string>().find("llvmpipe") == std::string::npos)
    GTEST_SKIP() << "only Mesa hides an extension on demand";
  EXPECT_EQ(compressed.at("facts").at("compressed"), 1);
  EXPECT_LT(compressed.at("texture_bytes").get<uint64_t>(), plain.at("texture_bytes").get<uint64_t>() / 2);
  const support::Outcome fallen = run_driver(without, common + ",compress=bc" + cast + " --json", false);
  ASSERT_EQ(fallen.status, 0);
  const json facts_of = json::parse(fallen.text);
  EXPECT_EQ(facts_of.at("facts").at("compressed"), 0);
  EXPECT_EQ(facts_of.at("texture_bytes"), plain.at("texture_bytes"));
  EXPECT_EQ(facts_of.at("cache_key"), plain.at("cache_key"));
  const support::Outcome said = run_driver(without, common + ",compress=bc" + cast + "");
  size_t warnings = 0;
  for (size_t at = said.text.find("lacks"); at != std::string::npos; at = said.text.find("lacks", at + 1)) ++warnings;
  EXPECT_EQ(warnings, 1U) << "once, however many characters: " << said.text;
  EXPECT_NE(said.text.find("GL_EXT_texture_compression_s3tc"), std::string::npos) << said.text;
}

TEST_F(FactsGl, BakeRefusesWhatCannotBe) {
  refuses("bake --representation flatt", "flat");
  refuses("bake --representation flat:texels=lots", "texels");
  refuses("bake --representation flat --clip no_such", "no_such");
  refuses("bake --representation flat --bake-budget 1 --character mannequin:triangles=500", "budget");
}

TEST_F(FactsGl, FlickerTellsJumpsFromMotion) {
  std::string times;
  for (int i = 0; i < 10; ++i) times += (i > 0 ? "," : "") + std::to_string(1.06 * i / 10);
  const json flicker = facts("quality --character mannequin:triangles=500 --flicker --height-px 60 --rows 120 --time " +
                             times + " --representation polypostor:views=sphere-4x1,frames=5,texels=64 " +
                             "--representation flat:views=sphere-4x1,frames=5,texels=64")
                           .at("flicker");
  ASSERT_EQ(flicker.size(), 2U);
  std::vector<double> scores;
  for (const json& row : flicker) {
    EXPECT_EQ(row.at("frames"), 10);
    scores.push_back(row.at("flicker").get<double>());
  }
  EXPECT_LT(scores[0], scores[1]) << "at twice the stored rate, corners that move flicker less than frames that jump";
  refuses("quality --representation mesh --flicker --exact-pose", "exact pose");
}

}  // namespace
}  // namespace crowdbench::bench
