// What each agent scores over distance: on hand-made stages, and through the driver's command.
#include "bench/experiments/distance.h"

#include <gtest/gtest.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <string>

#include "bench/commands/command_line.h"
#include "bench/commands/commands.h"
#include "bench/experiments/distance_rows.h"
#include "core/error.h"
#include "core/files.h"
#include "metrics/agents.h"
#include "renderers/gl/context.h"
#include "reports/page/libraries.h"
#include "scene/cast/load_cast.h"
#include "tests/support/scratch_folder.h"

namespace crowdbench::bench {
namespace {

using nlohmann::json;

PixelBox box(int left, int top, int right, int bottom) { return {left, top, right, bottom, true}; }

TEST(DistanceGroups, BoxesThatOverlapAreNeverTogether) {
  const std::vector<PixelBox> boxes = {box(0, 0, 10, 10), box(5, 5, 15, 15), box(10, 0, 20, 5),
                                       PixelBox{},        box(12, 0, 14, 9), box(0, 10, 5, 20)};
  EXPECT_EQ(disjoint_groups(boxes), (std::vector<std::vector<size_t>>{{0, 2, 5}, {1}, {4}}));
  EXPECT_TRUE(disjoint_groups({}).empty());
}

// Agents on the ground before an eye at the origin that looks along -z, at 1 m height.
class DistanceGl : public ::testing::Test {
 protected:
  void SetUp() override {
    scenario_.characters[0].source = "mannequin:triangles=500";
    cast_ = scene::load_cast(scenario_);
    frame_.width = 320;
    frame_.height = 240;
    frame_.camera.eye = {0, 1, 0};
    frame_.camera.target = {0, 1, -1};
    frame_.origin = frame_.camera.eye;
    frame_.outfits.resize(1);
    for (glm::vec4& colour : frame_.outfits[0].colours) colour = glm::vec4(1.0F);
    frame_.agents.resize(1);
    renderer_ = std::make_unique<renderers::Renderer>(context_, cast_);
    mesh_ = renderers::make_representation({context_, cast_}, renderers::reference_spec());
  }
  void stand(double x, double z) {
    scene::FrameAgent agent;
    agent.position = glm::vec3(x, -1.0, z);
    agent.pose = cast_.banks[0]->sample(0, 0.1);
    agent.id = static_cast<uint32_t>(frame_.agents[0].size()) + 1;
    frame_.agents[0].push_back(agent);
  }
  std::vector<AgentView> views(const renderers::Capture& drawn, double least_visible = 0.75) {
    return view_agents(context_, *renderer_, *mesh_, frame_, cast_, drawn.ids, least_visible);
  }
  static const metrics::Score* score(std::string_view name) {
    for (const metrics::Score* s : metrics::scores())
      if (s->name == name) return s;
    throw std::logic_error("no such score");
  }

  gl::Context context_;
  scene::Scenario scenario_;
  scene::Cast cast_;
  scene::Frame frame_;
  std::unique_ptr<renderers::Renderer> renderer_;
  std::unique_ptr<renderers::Representation> mesh_;
};

TEST_F(DistanceGl, HiddenAndCutOffAgentsAreKeptApart) {
  stand(-1.5, -6);   // free
  stand(1.0, -5);    // hides the next
  stand(1.1, -6);    // behind it
  stand(4.0, -7.5);  // its bounds reach over the edge
  stand(0.0, 0.5);   // behind the eye
  stand(-0.3, -20);  // free, far away
  const renderers::Capture drawn = renderer_->capture(frame_, *mesh_);
  const std::vector<AgentView> seen = views(drawn);
  ASSERT_EQ(seen.size(), 6U);
  EXPECT_EQ(seen[0].state, AgentState::counted);
  EXPECT_EQ(seen[0].visible_px, seen[0].alone_px) << "nothing stands before it";
  EXPECT_EQ(seen[1].state, AgentState::counted);
  EXPECT_EQ(seen[1].visible_px, seen[1].alone_px);
  EXPECT_EQ(seen[2].state, AgentState::occluded);
  EXPECT_GT(seen[2].alone_px, seen[2].visible_px);
  EXPECT_EQ(seen[3].state, AgentState::cut_off);
  EXPECT_GT(seen[3].visible_px, 0U);
  EXPECT_EQ(seen[4].state, AgentState::cut_off);
  EXPECT_EQ(seen[5].state, AgentState::counted);
  // The same agent drawn alone covers what was said.
  scene::Frame alone = frame_;
  alone.agents[0] = {frame_.agents[0][2]};
  const renderers::Capture one = renderer_->capture(alone, *mesh_);
  EXPECT_EQ(seen[2].alone_px, static_cast<uint64_t>(std::count_if(one.ids.data.begin(), one.ids.data.end(),
                                                                  [](uint32_t id) { return id != 0; })));
  const double share = static_cast<double>(seen[2].visible_px) / static_cast<double>(seen[2].alone_px);
  EXPECT_EQ(views(drawn, 0.99 * share)[2].state, AgentState::counted) << "the share decides";
  // Distances and heights: 1.75 m at its depth, of 240 rows over the field of view.
  EXPECT_NEAR(seen[0].distance, std::hypot(1.5, 6.0), 0.15);
  EXPECT_NEAR(seen[5].depth, 20, 0.2);
  EXPECT_NEAR(seen[5].height_px, 1.75 * 240 / (2 * seen[5].depth * std::tan(frame_.camera.fov_y / 2)), 0.1);
}

TEST_F(DistanceGl, AnErrorPlantedInOneAgentIsThatAgents) {
  stand(-1.2, -5);
  stand(0.0, -8);
  stand(2.0, -12);
  const renderers::Capture reference = renderer_->capture(frame_, *mesh_);
  renderers::Capture test = reference;
  // The second agent, ten code values darker or brighter in every channel.
  for (size_t i = 0; i < test.ids.data.size(); ++i)
    if (test.ids.data[i] == 2)
      for (size_t c = 0; c < 3; ++c) {
        uint8_t& v = test.colour.data[4 * i + c];
        v = static_cast<uint8_t>(v >= 128 ? v - 10 : v + 10);
      }
  for (size_t i = 0; i < test.ids.data.size(); ++i)
    if (test.ids.data[i] == 3) test.depth.data[i] += 0.25F;
  DistanceRequest request;
  request.scores = {score("mae"), score("depth_mae")};
  const std::vector<AgentValues> values = score_views(views(reference), request, reference, test);
  ASSERT_EQ(values.size(), 3U);
  EXPECT_EQ(values[0], (AgentValues{0.0, 0.0}));
  EXPECT_EQ(values[1], (AgentValues{10.0, 0.0}));
  EXPECT_EQ(values[2][0], 0.0);
  EXPECT_NEAR(values[2][1].value(), 0.25, 1e-5);
}

// ---- rows

// Two agents in one frame, drawn by two representations, and one curve with a threshold.
TEST(DistanceRows, AComparisonAnAgentAndRepresentationAndTheirCurves) {
  DistanceRequest request;
  request.reference = renderers::reference_spec();
  request.representations = {renderers::default_impostor(), renderers::reference_spec()};
  request.scores = {metrics::scores()[0]};
  DistanceResult result;
  result.texels = {{0.0}, {0.0}};
  result.agents.resize(2);
  result.agents[0].view.id = 1;
  result.agents[0].view.tick = 30;
  result.agents[0].view.distance = 4.5;
  result.agents[0].view.visible_px = 60;
  result.agents[0].view.alone_px = 80;
  result.agents[0].values = {{0.5}, {std::nullopt}};
  result.agents[1].view.id = 9;
  result.agents[1].values = {{0.25}, {1.0}};
  DistanceCurve curve;
  curve.representation = 1;
  curve.curve.points = 2;
  curve.curve.agents = 2;
  curve.curve.bins = {{1, 5, 4.5, 0.5, 0.25, 0.75, 2, 2}};
  curve.thresholds = {{0.5, {Reached::never, std::nullopt, 4.5, std::nullopt}}};
  const StoreContents rows = distance_rows({"cast", 100, 0.15, 3}, request, result, {curve, curve}, 6);
  ASSERT_EQ(rows.comparisons.size(), 4U);
  EXPECT_EQ(rows.comparisons[0].kind, "agent_in_crowd");
  EXPECT_EQ(rows.comparisons[0].run, 6);
  EXPECT_EQ(rows.comparisons[0].representation, renderers::default_impostor().text());
  EXPECT_EQ(rows.comparisons[1].reference, renderers::reference_spec().text());
  EXPECT_EQ(rows.comparisons[0].agent, 0U) << "an id is the agent's index + 1";
  EXPECT_EQ(rows.comparisons[2].agent, 8U);
  EXPECT_EQ(rows.comparisons[0].tick, 30U);
  EXPECT_EQ(rows.comparisons[0].distance, 4.5);
  EXPECT_EQ(rows.comparisons[0].visible_px, 60U);
  EXPECT_EQ(rows.comparisons[0].alone_px, 80U);
  EXPECT_EQ(rows.comparisons[0].pixels_per_texel, std::nullopt) << "there are no texels";
  EXPECT_EQ(rows.comparisons[0].agents, 100U);
  EXPECT_EQ(rows.comparisons[0].requested_occupancy, 0.15);
  EXPECT_EQ(rows.comparisons[0].scores.at(0).value, 0.5);
  EXPECT_EQ(rows.comparisons[1].scores.at(0).value, std::nullopt);
  EXPECT_FALSE(rows.comparisons[1].scores.at(0).reason.empty());
  ASSERT_EQ(rows.curves.size(), 2U);
  EXPECT_EQ(rows.curves[1].id, 2) << "numbered from 1";
  EXPECT_EQ(rows.curves[1].against, "distance_m");
  EXPECT_EQ(rows.curves[0].bins.at(0).median, 0.5);
  EXPECT_EQ(rows.curves[0].bins.at(0).high, 0.75);
  ASSERT_EQ(rows.thresholds.size(), 2U);
  EXPECT_EQ(rows.thresholds[1].curve, 2);
  EXPECT_EQ(rows.thresholds[1].status, reached_name(Reached::never));
  EXPECT_EQ(rows.thresholds[1].low, 4.5);
  EXPECT_TRUE(rows.cause_ranges.empty()) << "nobody asked for causes";

  // Into a file that has curves already: thresholds follow theirs.
  const support::ScratchFolder folder;
  {
    StoreWriter store(folder / "r.sqlite");
    RunRow run;
    run.headline = "cpu";
    run.id = store.write(run);
    const StoreContents of_run = distance_rows({"cast", 100, 0.15, 3}, request, result, {curve, curve}, run.id);
    write_distance_rows(store, of_run);
    write_distance_rows(store, of_run);
  }
  const StoreContents kept = read_store(folder / "r.sqlite");
  EXPECT_EQ(kept.comparisons.size(), 8U);
  ASSERT_EQ(kept.curves.size(), 4U);
  ASSERT_EQ(kept.thresholds.size(), 4U);
  for (size_t i = 0; i < 4; ++i) EXPECT_EQ(kept.thresholds[i].curve, kept.curves[i].id);
}

// ---- the command

json printed(std::vector<std::string> arguments) {
  CLI::App app;
  Run run;
  Command program(app);
  add_distance(program, run);
  for (const char* common : {"--size", "320x240", "--character", "mannequin:triangles=500", "--json"})
    arguments.emplace_back(common);
  arguments.insert(arguments.begin(), "distance");
  std::reverse(arguments.begin(), arguments.end());
  app.parse(arguments);
  ::testing::internal::CaptureStdout();
  ::testing::internal::CaptureStderr();
  std::string fault;
  int status = -1;
  try {
    status = run();
  } catch (const Error& error) {
    fault = error.what();
  }
  std::fflush(stdout);
  ::testing::internal::GetCapturedStderr();
  const std::string text = ::testing::internal::GetCapturedStdout();
  if (!fault.empty()) return {{"error", fault}};
  EXPECT_EQ(status, 0);
  json out = json::parse(text);
  out["bytes"] = text;
  return out;
}

const json& curve_of(const json& out, const std::string& representation, const std::string& score,
                     const std::string& against) {
  for (const json& curve : out.at("curves"))
    if (curve.at("representation") == representation && curve.at("score") == score && curve.at("against") == against)
      return curve;
  throw std::logic_error("no such curve");
}

constexpr const char* kImpostor = "flat:views=sphere-8x3,texels=32,frames=2";

TEST(DistanceCommandGl, TheMeshAgainstItselfIsBestEverywhere) {
  const json out =
      printed({"--agents", "12", "--occupancy", "0.1", "--representation", "mesh", "--threshold", "mae=1"});
  ASSERT_FALSE(out.contains("error")) << out;
  EXPECT_GE(out.at("scores").size(), 8U);
  const json& agents = out.at("agents");
  EXPECT_EQ(agents.at("scenario"), 12);
  EXPECT_EQ(agents.at("counted").get<int>() + agents.at("occluded").get<int>() + agents.at("cut_off").get<int>() +
                agents.at("no_pixel").get<int>() + agents.at("out_of_view").get<int>(),
            12);
  ASSERT_GE(agents.at("counted").get<int>(), 5);
  for (const json& curve : out.at("curves")) {
    SCOPED_TRACE(curve.at("score"));
    EXPECT_NE(curve.at("against"), "pixels_per_texel") << "the mesh has no texels";
    EXPECT_TRUE(curve.at("rank_correlation").is_null());
    const json best = [&]() -> json {
      for (const metrics::Score* score : metrics::scores())
        if (score->name == curve.at("score"))
          return std::isinf(metrics::best_value(*score)) ? json("inf") : json(metrics::best_value(*score));
      return nullptr;
    }();
    for (const json& bin : curve.at("bins"))
      for (const char* key : {"median", "low", "high"}) {
        if (best.is_number())
          EXPECT_NEAR(bin.at(key).get<double>(), best.get<double>(), 1e-4);
        else
          EXPECT_EQ(bin.at(key), best);
      }
  }
  EXPECT_EQ(curve_of(out, "mesh", "mae", "distance_m").at("thresholds")[0].at("status"), "everywhere");
}

TEST(DistanceCommandGl, AnImpostorComesNearerToTheMeshFartherAway) {
  support::ScratchFolder folder;
  const std::vector<std::string> arguments = {"--agents",
                                              "40",
                                              "--occupancy",
                                              "0.15",
                                              "--frames",
                                              "3",
                                              "--representation",
                                              std::string("mesh,") + kImpostor,
                                              "--scores",
                                              "cvvdp,silhouette_hausdorff_px,depth_mae",
                                              "--out",
                                              (folder / "agents.csv").string()};
  const json out = printed(arguments);
  ASSERT_FALSE(out.contains("error")) << out;
  EXPECT_EQ(out.at("ticks"), json({0, 10, 20}));
  EXPECT_EQ(out.at("rows").size() + out.at("agents").at("out_of_view").get<size_t>(), 120U);
  const std::string impostor = out.at("representations")[1];
  const json& jod = curve_of(out, impostor, "cvvdp", "distance_m");
  EXPECT_GT(jod.at("rank_correlation").get<double>(), 0.2) << "smaller on the screen: less to be seen";
  EXPECT_LT(curve_of(out, impostor, "silhouette_hausdorff_px", "distance_m").at("rank_correlation").get<double>(),
            -0.2);
  EXPECT_GT(curve_of(out, impostor, "cvvdp", "pixels_per_texel").at("rank_correlation").get<double>(), 0.2)
      << "by ratio and by height it is the order from near to far too";
  EXPECT_GT(jod.at("points").get<size_t>(), jod.at("agents").get<size_t>()) << "several frames of an agent";
  for (const json& curve : out.at("curves"))
    if (curve.at("representation") == impostor)
      for (const json& bin : curve.at("bins")) {
        EXPECT_LE(bin.at("low"), bin.at("median"));
        EXPECT_LE(bin.at("median"), bin.at("high"));
      }
  // Every agent of every frame, drawn by each of the two, under one head.
  const std::string csv = read_text(folder / "agents.csv");
  EXPECT_EQ(static_cast<size_t>(std::count(csv.begin(), csv.end(), '\n')), 1 + 2 * out.at("rows").size());
  EXPECT_NE(csv.find("\n\"" + impostor + "\",20,"), std::string::npos) << csv.substr(0, 400);
  EXPECT_EQ(printed(arguments).at("bytes"), out.at("bytes"));
  EXPECT_EQ(read_text(folder / "agents.csv"), csv);
}

TEST(DistanceCommandGl, WritesAPageOfCharts) {
  try {
    reports::chart_libraries();
  } catch (const Error&) {
    GTEST_SKIP() << "npm packages of the chart library absent at configure time";
  }
  support::ScratchFolder folder;
  const std::string page = (folder / "page.html").string();
  printed({"--agents", "12", "--occupancy", "0.1", "--representation", kImpostor, "--scores", "mae", "--threshold",
           "ssim_union=0.5", "--chart", page});
  const std::string html = read_text(page);
  for (const char* text : {"Mean absolute error, code values by distance from the eye", "by height",
                           "by pixels a texel", "data-plot=\"chart-6\"", "or better than</th>", "0.5</td>"})
    EXPECT_NE(html.find(text), std::string::npos) << text;
}

TEST(DistanceCommand, RefusesScoresThatAnAgentDoesNotHave) {
  const auto says = [](const std::vector<std::string>& arguments, const char* text) {
    const json out = printed(arguments);
    ASSERT_TRUE(out.contains("error"));
    EXPECT_NE(out.at("error").get<std::string>().find(text), std::string::npos) << out;
  };
  says({"--representation", "mesh", "--scores", "flicker"}, "--scores: flicker does not exist for one agent");
  says({"--representation", "mesh", "--scores", "mea"}, "did you mean 'mae'?");
  says({"--representation", "mesh", "--threshold", "mae"}, "--threshold: 'mae' is not a bound");
  says({"--representation", "mesh", "--display", "standard_8k"}, "--display");
}

}  // namespace
}  // namespace crowdbench::bench
