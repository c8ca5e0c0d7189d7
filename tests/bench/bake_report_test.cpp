// `bake --report`: the source's published sizes, from the command that claims to reproduce them.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "renderers/representation.h"
#include "tests/support/driver.h"
#include "tests/support/sanitized.h"
#include "tests/support/scratch_folder.h"

namespace crowdbench::bench {
namespace {

using nlohmann::json;

json report(const std::string& arguments) {
  const support::Outcome out =
      support::run_driver("", "bake --representation " + arguments + " --no-cache --report --json", false);
  EXPECT_EQ(out.status, 0) << arguments;
  return json::parse(out.text, nullptr, false);
}

// 53 joints x 6 faces x 2 maps x 128 x 128 texels x 4 bytes. A few of the joints own no triangle: no box, no bytes.
TEST(BakeReportGl, NominalBytesOfTheSource) {
  if (!support::driver_is_built()) GTEST_SKIP() << "the driver is not built";
  const json out = report("relief:capture=bind,merge=0,bend=rigid --character mannequin:joints=53,triangles=500");
  ASSERT_TRUE(out.is_object());
  EXPECT_EQ(out.value("nominal_bytes", json()).dump(), "41680896") << "a whole number";
  EXPECT_LT(out.at("boxes").get<int>(), 53);
  EXPECT_GT(out.at("actual_bytes").get<int64_t>(), 0);
  EXPECT_EQ(out.at("facts").at("nominal_bytes"), out.at("nominal_bytes"));
}

// One frame of 136 views on 1024 x 1024 texels: 7 MiB as RGBA and RGB, 1.5 MiB as blocks.
TEST(BakeReportGl, AFrameOfViewsAsTheSourceCountsIt) {
  CROWDBENCH_SKIP_SANITIZED("NominalBytesOfTheSource");
  if (!support::driver_is_built()) GTEST_SKIP() << "the driver is not built";
  const json out = report("flat:texels=85,frames=1 --character mannequin:triangles=500");
  ASSERT_TRUE(out.is_object());
  EXPECT_EQ(out.at("views"), 136);
  EXPECT_EQ(out.at("nominal_page"), 1024);
  EXPECT_EQ(out.at("nominal_frame_bytes").dump(), "7340032") << "a whole number";
  EXPECT_EQ(out.at("nominal_frame_compressed_bytes").dump(), "1572864");
  // Squares, trimmed tiles and blocks, each of what the driver holds.
  const auto bytes = [](const std::string& how) {
    return report("flat:texels=85,frames=1" + how + " --character mannequin:triangles=500")
        .at("texture_bytes")
        .get<uint64_t>();
  };
  const uint64_t trimmed = out.at("texture_bytes").get<uint64_t>();
  EXPECT_GT(bytes(",quad=square"), 2 * trimmed);
  EXPECT_LT(bytes(",compress=bc"), trimmed / 2);
}

// What a scenario shows, of a representation that stores views; others are refused by name.
TEST(BakeReportGl, RequiredByKeepsAPartOrIsRefused) {
  if (!support::driver_is_built()) GTEST_SKIP() << "the driver is not built";
  const support::ScratchFolder folder;
  const std::filesystem::path scenario = folder.path() / "few.toml";
  std::ofstream(scenario) << "[crowd]\nagents = 3\n[[character]]\nsource = \"mannequin:triangles=500\"\n";
  const std::string by = " --required-by '" + scenario.string() + "' --no-cache --json";
  for (const char* spec : {"flat:texels=32,frames=2", "polypostor:views=sphere-8x4,texels=32,frames=2"}) {
    const support::Outcome out = support::run_driver("", std::string("bake --representation ") + spec + by, false);
    ASSERT_EQ(out.status, 0) << out.text;
    const json required = json::parse(out.text, nullptr, false).at("required_by");
    EXPECT_EQ(required.at("ticks"), 301);
    const json kept = required.at("kept").at(0);
    EXPECT_GT(kept.at("kept").get<int>(), 0) << spec;
    EXPECT_LT(kept.at("kept").get<int>(), kept.at("whole").get<int>()) << spec;
    EXPECT_LT(kept.at("kept_bytes").get<int64_t>(), kept.at("whole_bytes").get<int64_t>()) << spec;
    EXPECT_LE(kept.at("kept_bytes"), json::parse(out.text).at("gpu_bytes")) << spec;
  }
  const support::Outcome refused = support::run_driver("", "bake --representation relief" + by);
  EXPECT_EQ(refused.status, 2);
  EXPECT_NE(refused.text.find("'relief' stores no views that could be left out"), std::string::npos) << refused.text;
  EXPECT_NE(refused.text.find("flat or polypostor"), std::string::npos) << refused.text;
  for (const std::string name : {"layered", "perjoint"}) {
    const support::Outcome whole = support::run_driver("", "bake --representation " + name + by);
    EXPECT_NE(whole.text.find("'" + name + "' keeps all of its views"), std::string::npos) << whole.text;
  }
}

TEST(BakeReportGl, PolypostorsAreAudited) {
  CROWDBENCH_SKIP_SANITIZED("BakeReportGl.RequiredByKeepsAPartOrIsRefused");
  if (!support::driver_is_built()) GTEST_SKIP() << "the driver is not built";
  const support::Outcome out =
      support::run_driver("",
                          "bake --representation polypostor:views=sphere-6x2,texels=32,frames=2 --character "
                          "mannequin:triangles=500 --audit --json",
                          false);
  ASSERT_EQ(out.status, 0) << out.text;
  const json audit = json::parse(out.text, nullptr, false).at("characters").at(0).at("audit");
  EXPECT_EQ(audit.at("views"), 12);
  EXPECT_EQ(audit.at("smooth"), false);
}

// What a type can do is printed as it says itself, for people and as JSON.
TEST(BakeReport, RepresentationsAreListedWithWhatTheyCanDo) {
  if (!support::driver_is_built()) GTEST_SKIP() << "the driver is not built";
  const json listed = json::parse(support::run_driver("", "info --representations --json", false).text, nullptr, false);
  const std::string said = support::run_driver("", "info --representations", false).text;
  const auto& types = renderers::representation_types();
  ASSERT_EQ(listed.size(), types.size());
  for (size_t i = 0; i < types.size(); ++i) {
    EXPECT_EQ(listed[i].at("name"), types[i].name);
    EXPECT_EQ(listed[i].at("reference"), types[i].reference);
    EXPECT_EQ(listed[i].at("stores_views"), types[i].view_sampling != nullptr);
    EXPECT_EQ(listed[i].at("required_by"), types[i].required_by);
    EXPECT_EQ(listed[i].at("floor"), types[i].floor);
    EXPECT_EQ(listed[i].at("example"), example_spec(types[i]));
    EXPECT_EQ(listed[i].at("debug_views").get<std::vector<std::string>>(), debug_views(types[i]));
    EXPECT_NE(said.find(types[i].floor), std::string::npos) << types[i].name;
  }
  EXPECT_NE(said.find("the reference of all comparisons"), std::string::npos);
}

// A full disk, as a limit on the size of files: the bake goes on uncached, with one warning, and leaves nothing behind.
TEST(BakeReportGl, AFullDiskIsReportedAndTheRunGoesOn) {
  CROWDBENCH_SKIP_SANITIZED("FactsGl.BakeTellsBytes..., Files.AFailedWriteKeepsTheOldFileAndLeavesNothingBehind");
  if (!support::driver_is_built()) GTEST_SKIP() << "the driver is not built";
  const support::ScratchFolder folder;
  const std::string bake =
      "bake --representation relief:map=32,capture=bind,merge=0 --character mannequin:triangles=500 --json";
  const std::string cache = "CROWDBENCH_CACHE_DIR='" + folder.path().string() + "'";
  // 16 blocks of 512 bytes; the bake is larger. The signal that comes with the limit is ignored, so that writing fails.
  const std::string full = "trap '' XFSZ; ulimit -f 16; MESA_SHADER_CACHE_DISABLE=1 " + cache;
  const support::Outcome out = support::run_driver(full, bake, false);
  ASSERT_EQ(out.status, 0) << out.text;
  const json facts = json::parse(out.text, nullptr, false);
  ASSERT_TRUE(facts.is_object());
  EXPECT_EQ(facts.at("disk_bytes"), 0);
  EXPECT_EQ(facts.at("cached"), false);
  EXPECT_GT(facts.at("texture_bytes").get<int64_t>(), 100'000);
  size_t left = 0;
  std::error_code absent;
  for (const auto& file : std::filesystem::recursive_directory_iterator(folder.path(), absent))
    left += file.is_regular_file();
  EXPECT_EQ(left, 0U) << "pieces of files";
  // Standard error alone: one line.
  const support::Outcome said = support::run_driver(full, bake + " 2>&1 >/dev/null | cat");
  EXPECT_NE(said.text.find("warning: bakes are not kept"), std::string::npos) << said.text;
  EXPECT_EQ(std::count(said.text.begin(), said.text.end(), '\n'), 1) << said.text;
  // With room it is stored, and read.
  EXPECT_EQ(json::parse(support::run_driver(cache, bake, false).text).at("cached"), false);
  EXPECT_EQ(json::parse(support::run_driver(cache, bake, false).text).at("cached"), true);
  // A folder that nobody may write to, not even root.
  const support::Outcome locked = support::run_driver("CROWDBENCH_CACHE_DIR=/proc/crowdbench", bake, false);
  ASSERT_EQ(locked.status, 0);
  EXPECT_EQ(json::parse(locked.text).at("disk_bytes"), 0);
}

}  // namespace
}  // namespace crowdbench::bench
