// `render`, `ratio` and `bench` from outside: each prints the stage that it shows or measures, and of one scenario all
// print the same bytes.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <set>

#include "core/files.h"
#include "tests/support/driver.h"
#include "tests/support/sanitized.h"
#include "tests/support/scratch_folder.h"

namespace crowdbench::bench {
namespace {

using Json = nlohmann::ordered_json;  // keeps the order in which the members were printed

class StageAgreesGl : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!support::driver_is_built()) GTEST_SKIP() << "the driver is not built";
  }
  Json print(const std::string& arguments) {
    const support::Outcome outcome =
        support::run_driver("CROWDBENCH_CACHE_DIR='" + (folder_ / "cache").string() + "'", arguments, false);
    EXPECT_EQ(outcome.status, 0) << arguments;
    Json parsed = Json::parse(outcome.text, nullptr, false);
    EXPECT_TRUE(parsed.is_object()) << arguments << "\n" << outcome.text;
    return parsed;
  }
  support::ScratchFolder folder_;
};

// Some have more triangles than a draft, so that a search by another policy ends elsewhere; not all, so that it is
// quick.
TEST_F(StageAgreesGl, OneScenarioStandsAtOneCameraInEveryCommand) {
  CROWDBENCH_SKIP_SANITIZED("the tests of each command");
  write_file(folder_ / "s.toml", R"(
[[character]]
source = "mannequin:triangles=500"
share = 0.9
[[character]]
source = "mannequin:triangles=2200"
share = 0.1
)");
  const std::string common =
      fmt::format(" '{}' --size 96x72 --seed 3 --device software --json", (folder_ / "s.toml").string());
  const size_t points = support::kSanitized ? 1 : 4;
  const char* const axes =
      support::kSanitized ? "--agents 250 --occupancy 0.15" : "--agents 250,1000 --occupancy 0.15,0.9";
  const Json bench =
      print(fmt::format("bench{} {} --representation mesh --rounds 10 --time-limit 0.001 --no-floors "
                        "--budget-ms 60000 --out '{}'",
                        common, axes, (folder_ / "r.sqlite").string()));
  ASSERT_EQ(bench.at("stages").size(), points);
  std::set<std::string> seen;
  for (const Json& point : bench.at("stages")) {
    const auto agents = point.at("agents").get<uint32_t>();
    const auto occupancy = point.at("requested_occupancy").get<double>();
    SCOPED_TRACE(fmt::format("{} agents at {}", agents, occupancy));
    const std::string scenario = fmt::format("{} --agents {} --occupancy {}", common, agents, occupancy);
    const std::string stage = point.at("stage").dump();
    const Json render = print("render" + scenario);
    const Json ratio = print("ratio" + scenario + " --of mesh --to mesh:floor=1 --pairs 20");
    EXPECT_EQ(render.at("stage").dump(), stage);
    EXPECT_EQ(ratio.at("stage").dump(), stage);

    // And it is the scenario that was asked for.
    const Json& facts = point.at("stage");
    EXPECT_EQ(facts.at("width"), 96);
    EXPECT_EQ(facts.at("height"), 72);
    EXPECT_EQ(facts.at("seed"), 3);
    EXPECT_EQ(facts.at("crowd").at("agents"), agents);
    EXPECT_EQ(facts.at("requested_occupancy"), occupancy);
    EXPECT_NEAR(facts.at("achieved_occupancy").get<double>(), occupancy, 0.01);
    EXPECT_FALSE(facts.at("unreachable").get<bool>());
    EXPECT_NEAR(facts.at("covered_px").get<double>(), occupancy * 96 * 72, 0.01 * 96 * 72);
    EXPECT_GE(facts.at("touched_px"), facts.at("covered_px"));
    EXPECT_EQ(facts.at("camera").at("eye").size(), 3U);
    EXPECT_GT(facts.at("crowd").at("spacing").get<double>(), 0.69);
    EXPECT_LT(facts.at("crowd").at("stage_near"), facts.at("crowd").at("stage_far"));
    uint32_t counted = 0;
    for (const char* where : {"wholly", "partly", "off"})
      counted += facts.at("agents_on_screen").at(where).get<uint32_t>();
    EXPECT_EQ(counted, agents);
    seen.insert(facts.at("camera").dump());
  }
  EXPECT_EQ(seen.size(), points) << "each point has a camera of its own";
}

TEST_F(StageAgreesGl, OneAgentAloneHasNoStage) {
  EXPECT_EQ(support::run_driver("", "render --single --json --out x.png").status, 2);
}

}  // namespace
}  // namespace crowdbench::bench
