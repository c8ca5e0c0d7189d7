// The mesh with levels of detail in the commands that measure: each takes it as one representation, and says of all its
// levels what they are.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <set>

#include "tests/support/driver.h"
#include "tests/support/sanitized.h"
#include "tests/support/scratch_folder.h"

namespace crowdbench::bench {
namespace {

using nlohmann::json;

constexpr const char* kLods = "mesh:lods=400/250";

class MeshLodsCommandsGl : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!support::driver_is_built()) GTEST_SKIP() << "the driver is not built";
    CROWDBENCH_SKIP_SANITIZED("MeshLodsGl");
  }
  // What it prints as JSON; it must succeed.
  json facts(const std::string& arguments) const {
    const support::Outcome outcome =
        support::run_driver("cd '" + (folder_ / "").string() + "' && CROWDBENCH_CACHE_DIR=cache ",
                            arguments + " --character mannequin:triangles=500 --json", false);
    EXPECT_EQ(outcome.status, 0) << arguments;
    json parsed = json::parse(outcome.text, nullptr, false);
    EXPECT_FALSE(parsed.is_discarded()) << arguments << "\n" << outcome.text;
    return parsed;
  }
  // Two levels, fine to coarse, with their errors.
  static void expect_levels(const json& levels) {
    ASSERT_EQ(levels.size(), 2U) << levels.dump();
    EXPECT_GT(levels[0].at("triangles").get<int>(), levels[1].at("triangles").get<int>());
    EXPECT_LT(levels[0].at("max_m").get<double>(), levels[1].at("max_m").get<double>());
  }

  support::ScratchFolder folder_;
};

TEST_F(MeshLodsCommandsGl, AreScoredTimedAndTuned) {
  const std::string lods = kLods;
  // Tall figures are the whole mesh to the bit, small ones are not.
  const json rows = facts("quality --representation " + lods + " --height-px 400,24").at("rows");
  ASSERT_EQ(rows.size(), 2U);
  for (const json& row : rows) {
    EXPECT_EQ(row.at("representation"), lods);
    EXPECT_EQ(row.at("mae").get<double>() == 0, row.at("height_px") == 400) << row.dump();
  }

  const std::string crowd = " --agents 4 --size 160x120";
  const json ratio = facts("ratio --of " + lods + " --to mesh --pairs 20" + crowd);
  EXPECT_TRUE(ratio.at("valid").get<bool>());
  expect_levels(ratio.at("levels").at(lods));

  const json bench = facts("bench --representation " + lods +
                           " --agents 4 --occupancy 0 --size 160x120 --rounds 10 --no-floors --out r.sqlite");
  std::set<std::string> measured;
  for (const json& row : bench.at("measurements")) {
    EXPECT_EQ(row.at("status"), "valid") << row.dump();
    measured.insert(row.at("representation").get<std::string>());
  }
  EXPECT_EQ(measured, (std::set<std::string>{"mesh", lods}));
  expect_levels(bench.at("levels").at(lods));

  const json tuned = facts("tune --representation " + lods + crowd +
                           " --heights 2 --moments 1 --azimuth-deg 0 --elevation-deg 0 --rounds 4 --threshold mae=255 "
                           "--promise-seeds 0");
  ASSERT_EQ(tuned.at("characters")[0].at("candidates").size(), 2U);
  // Whatever is chosen can be drawn as it is written.
  const json drawn =
      facts("ratio --of '" + tuned.at("representation").get<std::string>() + "' --to mesh --pairs 20" + crowd);
  EXPECT_TRUE(drawn.at("valid").get<bool>());
  const json nested = facts("ratio --of 'hybrid(mesh," + lods + ",distance=6)' --to mesh --pairs 20" + crowd);
  EXPECT_TRUE(nested.at("valid").get<bool>());
}

}  // namespace
}  // namespace crowdbench::bench
