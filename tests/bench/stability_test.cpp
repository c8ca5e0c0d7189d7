// The battery itself: that its small form holds, that each kind of fault that it looks for makes it fail, and that what
// it prints says so.
#include "bench/stability/stability.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <set>

#include "bench/commands/stability_output.h"
#include "bench/stability/fixture.h"
#include "bench/stability/odd_characters.h"
#include "bench/stability/odd_gltf.h"
#include "bench/stability/surface.h"
#include "core/error.h"
#include "renderers/frame/frame_resources.h"
#include "tests/support/sanitized.h"
#include "tests/support/scratch_folder.h"

namespace crowdbench::bench {
namespace {

class StabilityGl : public ::testing::Test {
 protected:
  void SetUp() override { ::setenv("CROWDBENCH_CACHE_DIR", folder_.path().c_str(), 1); }
  void TearDown() override { ::unsetenv("CROWDBENCH_CACHE_DIR"); }
  support::ScratchFolder folder_;
};

// Draws agents as another does, a hand's breadth beside; or leaves out one of every `leave_out`, where that is not 0.
class Wrong : public renderers::Representation {
 public:
  Wrong(renderers::Representation& right, float aside, uint32_t leave_out)
      : right_(right), aside_(aside), leave_out_(leave_out) {}
  void draw(const scene::Frame& frame, const renderers::FrameResources& resources, const renderers::AgentLists& agents,
            const renderers::Pass& pass) override {
    scene::Frame moved = frame;
    // Only far from the origin, as a transform that is not camera-relative would.
    if (std::abs(frame.origin.x) > 1e4)
      for (scene::FrameAgent& agent : moved.agents[0]) agent.position.x += aside_;
    resources.update_agents(moved);
    renderers::AgentLists some = agents;
    if (leave_out_ > 0) std::erase_if(some[0], [this](uint32_t i) { return i % leave_out_ == leave_out_ / 2 - 1; });
    right_.draw(moved, resources, some, pass);
  }
  renderers::Footprint footprint() const override { return right_.footprint(); }
  uint64_t triangles(size_t character) const override { return right_.triangles(character); }

 private:
  renderers::Representation& right_;
  float aside_;
  uint32_t leave_out_;  // even
};

const StabilityCase& case_named(const std::vector<StabilityCase>& cases, std::string_view name) {
  for (const StabilityCase& one : cases)
    if (one.name == name) return one;
  ADD_FAILURE() << "no case " << name;
  return cases.front();
}

TEST(Stability, CasesHaveNamesOfTheirOwnAndSayWhereTheirBoundsComeFrom) {
  std::set<std::string_view> names;
  std::set<std::string_view> groups;
  for (const StabilityCase& one : stability_cases()) {
    EXPECT_TRUE(names.insert(one.name).second) << one.name;
    groups.insert(one.group);
    EXPECT_FALSE(one.asked.empty() || one.unit.empty() || one.bound_from.empty()) << one.name;
    EXPECT_NE(one.measure, nullptr) << one.name;
  }
  EXPECT_GT(names.size(), 20U);
  EXPECT_GT(groups.size(), 5U);
  for (const std::string_view name : names) EXPECT_FALSE(groups.contains(name)) << name;
}

TEST(Stability, CasesAreChosenByNameAndByGroup) {
  StabilityRequest request;
  request.cases = {"world_1e3", "time"};
  std::set<std::string_view> names;
  for (const StabilityCase& one : chosen_cases(request)) names.insert(one.name);
  EXPECT_TRUE(names.contains("world_1e3") && names.contains("time_wrap"));
  EXPECT_FALSE(names.contains("world_1e5"));
  request.cases = {"sizes"};
  request.small = true;
  for (const StabilityCase& one : chosen_cases(request)) EXPECT_TRUE(one.small && !one.full) << one.name;
  request.cases = {"agents_1000000"};
  EXPECT_EQ(chosen_cases(request).size(), 1U) << "by its own name a case is run in any form";
  request.cases = {"wrold"};
  EXPECT_THROW(chosen_cases(request), Error);
}

TEST(Stability, AValueThatIsNoNumberDoesNotHold) {
  Found found;
  found.bound = 1;
  EXPECT_FALSE(holds(found));
  found.measured = 1;
  EXPECT_TRUE(holds(found));
  found.measured = INFINITY;
  EXPECT_FALSE(holds(found));
}

TEST(Stability, StepsAreHeldToWhatEdgesAllow) {
  Image8 a(8, 8, 3);
  for (int y = 0; y < 8; ++y)
    for (int x = 4; x < 8; ++x)
      for (int c = 0; c < 3; ++c) a.at(x, y)[c] = 200;  // one upright edge
  Image8 b = a;
  b.at(3, 2)[0] = 200;
  const StepChange change = step_change(a, b);
  EXPECT_EQ(change.edges, 8U);
  EXPECT_EQ(change.changed, 1U);
  EXPECT_EQ(change.x, 3);
  EXPECT_EQ(change.y, 2);
  EXPECT_EQ(step_bound(0, 1), 3);
  EXPECT_EQ(step_bound(8, 0.25), std::floor(4 + 6 * 2.0 + 3));
  EXPECT_EQ(largest_difference(a, b).measured, 200);
  EXPECT_EQ(enlarged(b, 3, 2).width, 17 * 16);
}

TEST(Stability, LargeCharactersAreAsLargeAsTheySay) {
  CROWDBENCH_SKIP_SANITIZED("Stability.OddCharactersAndFilesAreWhatTheySay");
  const auto& all = large_characters();
  ASSERT_EQ(all.size(), 2U);
  EXPECT_EQ(all[0].make().triangles(), 300'312U);
  const scene::Character wall = all[1].make();
  EXPECT_EQ(wall.triangles(), 12U * 5000);
  EXPECT_EQ(wall.skeleton.joints.size(), 5000U);
}

TEST(Stability, OddCharactersAndFilesAreWhatTheySay) {
  std::set<std::string_view> names;
  for (const OddCharacter& odd : odd_characters()) {
    EXPECT_TRUE(names.insert(odd.name).second);
    const scene::Cast cast = odd_cast(odd);
    EXPECT_GT(cast.characters[0]->triangles(), 0U) << odd.name;
  }
  size_t refused = 0;
  for (const OddGltf& odd : odd_gltfs()) refused += odd.refused ? 1U : 0U;
  EXPECT_GT(refused, 5U);
  EXPECT_LT(refused, odd_gltfs().size() - 5);
}

TEST_F(StabilityGl, TheSmallFormHoldsForTheReference) {
  StabilityRequest request;
  request.small = true;
  request.representations = {renderers::reference_spec()};
  gl::Context context;
  const std::vector<StabilityCase> cases = chosen_cases(request);
  const std::vector<StabilityRow> rows = run_stability(context, request, cases);
  EXPECT_GE(rows.size(), cases.size());
  EXPECT_GT(cases.size(), 20U);
  for (const StabilityRow& row : rows)
    EXPECT_TRUE(row.pass()) << row.asked.name << ": " << row.found.measured << " over " << row.found.bound << ", "
                            << row.found.place << ' ' << row.found.got << ' ' << row.error;
}

TEST_F(StabilityGl, PlantedFaultsFail) {
  gl::Context context;
  Fixture fixture(context, true, false, false);
  const std::vector<StabilityCase> cases = stability_cases();
  const StabilityCase& far = case_named(cases, "world_1e5");
  const StabilityCase& surface = case_named(cases, "eye_above");
  EXPECT_TRUE(holds(far.measure(fixture)));
  EXPECT_TRUE(holds(surface.measure(fixture)));
  fixture.replace(std::make_unique<Wrong>(fixture.mesh(), 0.1F, 0));
  const Found moved = far.measure(fixture);
  EXPECT_FALSE(holds(moved)) << "agents moved far from the origin";
  EXPECT_FALSE(moved.place.empty() || moved.expected.empty() || moved.got.empty() || moved.before.empty());
  fixture.replace(std::make_unique<Wrong>(fixture.mesh(), 0.0F, 2));
  EXPECT_FALSE(holds(surface.measure(fixture))) << "nobody is drawn";
}

TEST_F(StabilityGl, TheTruthFindsWhoIsNotDrawn) {
  gl::Context context;
  Fixture fixture(context, true, false, false);
  const std::vector<StabilityCase> cases = stability_cases();
  const StabilityCase& cameras = case_named(cases, "truth_cameras");
  const Found right = cameras.measure(fixture);
  EXPECT_TRUE(holds(right)) << right.place;
  EXPECT_NE(right.note.find("pixels covered"), std::string::npos);
  fixture.replace(std::make_unique<Wrong>(fixture.mesh(), 0.0F, 8));
  const Found wrong = cameras.measure(fixture);
  EXPECT_GT(wrong.measured, 10);
  EXPECT_FALSE(wrong.place.empty() || wrong.expected.empty() || wrong.got.empty() || wrong.before.empty());
}

// The usual depth buffer makes fewer errors than the others; who is not drawn at all is beyond what a step allows.
TEST_F(StabilityGl, DepthBuffersAreAsGoodAsTheirStepsAndNoBetter) {
  gl::Context context;
  Fixture fixture(context, true, false, false);
  const std::vector<StabilityCase> cases = stability_cases();
  const StabilityCase& usual = case_named(cases, "depth_32f_reversed_100mm_inf");
  const StabilityCase& coarse = case_named(cases, "depth_16_straight_100mm_inf");
  const Found few = usual.measure(fixture);
  const Found many = coarse.measure(fixture);
  EXPECT_TRUE(holds(few)) << few.place << few.note;
  EXPECT_TRUE(holds(many)) << many.place << many.note;
  EXPECT_LT(few.bound, many.bound / 2);
  EXPECT_LT(few.measured, many.measured / 100);
  EXPECT_GT(many.measured, 0.05);
  EXPECT_TRUE(holds(case_named(cases, "depth_default").measure(fixture)));
  fixture.replace(std::make_unique<Wrong>(fixture.mesh(), 0.0F, 2));
  const Found missing = usual.measure(fixture);
  EXPECT_FALSE(holds(missing));
  EXPECT_FALSE(missing.place.empty() || missing.expected.empty() || missing.got.empty());
}

TEST_F(StabilityGl, AWrongBoundAndAnErrorAreRowsThatFail) {
  StabilityRequest request;
  request.small = true;
  request.representations = {renderers::reference_spec()};
  StabilityCase wrong = case_named(stability_cases(), "time_wrap");
  wrong.measure = [](Fixture&) {
    Found found;
    found.measured = 2;
    found.bound = 1;
    return found;
  };
  StabilityCase broken = wrong;
  broken.name = "broken";
  broken.measure = [](Fixture&) -> Found { throw Error("somewhere", "it cannot be measured", "try"); };
  StabilityReport report;
  gl::Context context;
  report.rows = run_stability(context, request, {wrong, broken});
  ASSERT_EQ(report.rows.size(), 2U);
  EXPECT_EQ(failed(report), 2U);
  EXPECT_NE(stability_text(report).find("2 of 2 rows FAIL"), std::string::npos);
  EXPECT_NE(stability_text(report).find("it cannot be measured"), std::string::npos);
  EXPECT_NE(stability_markdown(report).find("**fails**"), std::string::npos);
  const Json json = stability_json(report);
  const Json& row = json.at("cases").elements().front();
  EXPECT_EQ(row.at("case").text(), "time_wrap");
  EXPECT_EQ(row.at("measured").number(), 2);
  EXPECT_EQ(row.at("bound").number(), 1);
  EXPECT_FALSE(row.at("pass").truth());
  EXPECT_TRUE(row.at("representation").is_null()) << "asked once";
  EXPECT_TRUE(json.at("cases").elements().back().at("measured").is_null());
}

}  // namespace
}  // namespace crowdbench::bench
