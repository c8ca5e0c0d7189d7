// Popping: in a crowd whose switches are known all of them and no others, and through the driver's command.
#include "bench/experiments/popping.h"

#include <gtest/gtest.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <tuple>

#include "bench/commands/command_line.h"
#include "bench/commands/commands.h"
#include "core/error.h"
#include "core/files.h"
#include "core/image_io.h"
#include "renderers/frame/capture.h"
#include "scene/cast/load_cast.h"
#include "scene/crowd/crowd.h"
#include "test_paths.h"
#include "tests/support/sanitized.h"
#include "tests/support/scratch_folder.h"

namespace crowdbench::bench {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

const std::string kFlat = "flat:views=sphere-8x3,frames=4,texels=32";

// An eye that rises over a crowd that steps on the spot.
class PoppingGl : public ::testing::Test {
 protected:
  void SetUp() override {
    scenario_.characters[0].source = "mannequin:triangles=500";
    scenario_.crowd.agents = 40;
    scenario_.width = 240;
    scenario_.height = 160;
    scene::CameraKey start = scenario_.camera.keys[0];
    scene::CameraKey end = start;
    start.camera.eye = {0, 2, 6};
    end.time = 1;
    end.camera.eye = {0, 3, 10};
    scenario_.camera.keys = {start, end};
    cast_ = scene::load_cast(scenario_);
    staged_ = stage_scenario(scenario_, cast_, context_);
    request_.frames = 24;
    request_.view = {&metrics::default_display(), true, scenario_.tick_rate};
    request_.use_cache = false;
  }
  scene::Frame frame_at(uint64_t tick) const {
    return scene::make_frame(scenario_, cast_, staged_.crowd,
                             scenario_.camera.at(static_cast<double>(tick) / scenario_.tick_rate), tick);
  }
  PoppingResult measure(const std::string& representation) {
    request_.representation = renderers::parse_spec(representation);
    return measure_popping(context_, cast_, staged_, request_);
  }

  gl::Context context_;
  scene::Scenario scenario_;
  scene::Cast cast_;
  Staged staged_;
  PoppingRequest request_;
};

using Known = std::set<std::tuple<uint64_t, uint32_t, bool>>;  // tick, agent, whether it turns far

// From where the agents stand: who crosses 8 m from one frame to the next.
TEST_F(PoppingGl, FindsAllSwitchesAndNoOthers) {
  Known expected;
  std::map<uint32_t, bool> before;
  for (uint64_t tick = 0; tick < request_.frames; ++tick) {
    std::map<uint32_t, bool> now;
    const scene::Frame frame = frame_at(tick);
    for (const scene::FrameAgent& agent : frame.agents[0]) now[agent.id] = glm::length(agent.position) > 8;
    for (const auto& [id, far] : now)
      if (before.contains(id) && before[id] != far) expected.emplace(tick, id, far);
    before = now;
  }
  ASSERT_GE(expected.size(), 8U) << "or the scenario shows nothing";
  request_.pictures = 3;
  const PoppingResult result = measure("hybrid(mesh,(" + kFlat + "),distance=8)");
  EXPECT_EQ(result.components, (std::vector<std::string>{"mesh", kFlat}));
  Known found;
  for (const Switch& s : result.switches) {
    found.emplace(s.tick, s.id, s.to == 1);
    EXPECT_EQ(s.steps, 1U);
    EXPECT_TRUE(s.complete);
    EXPECT_NE(s.from, s.to);
    EXPECT_NEAR(s.distance, 8, 0.3);
  }
  EXPECT_EQ(found, expected);
  EXPECT_EQ(found.size(), result.switches.size());
  // The most visible first, and the pictures are theirs.
  const size_t seen = seen_switches(result.switches);
  ASSERT_GE(seen, 4U);
  for (size_t i = 1; i < seen; ++i) EXPECT_LE(*result.switches[i - 1].values[0], *result.switches[i].values[0]);
  EXPECT_LT(*result.switches[0].values[0], 10);
  for (size_t i = 0; i < result.switches.size(); ++i) EXPECT_EQ(result.switches[i].pictures.kept(), i < 3) << i;
  const SwitchPictures& pictures = result.switches[0].pictures;
  EXPECT_EQ(pictures.with.width, pictures.box.width);
  EXPECT_NE(pictures.with.data, pictures.without.data);
}

// An eye that goes back and forth, so that an agent may turn far, near and far again: what switches is worked out here
// from where the agents stand and the rule of renderers/hybrid/README.md alone. A fade changes how a switch looks, not
// when it begins; one that turns back before it is over is the same switch.
TEST_F(PoppingGl, HysteresisAndFadesSwitchWhereTheRuleSays) {
  CROWDBENCH_SKIP_SANITIZED("PoppingCommandGl.SweepsOptionsAndWritesTheWorst");
  scenario_.crowd.agents = 30;
  scenario_.width = 120;
  scenario_.height = 80;
  scene::CameraKey key = scenario_.camera.keys[0];
  key.camera.target = {0, 0.5, 0};
  key.camera.fov_y = 1.5;  // nobody is ever out of the picture, which would let an agent begin anew
  scenario_.camera.keys.clear();
  for (const auto& [time, z] : {std::pair{0.0, 9.0}, {0.25, 12.0}, {0.5, 8.5}, {0.8, 13.0}}) {
    key.time = time;
    key.camera.eye = {0, 4, z};
    scenario_.camera.keys.push_back(key);
  }
  staged_ = stage_scenario(scenario_, cast_, context_);
  constexpr double kDistance = 11;
  struct Agent {
    bool far = false;
    std::optional<uint64_t> begun;
    uint64_t over = 0;  // the last tick of its fade
  };
  using Begun = std::set<std::pair<uint64_t, uint32_t>>;
  const auto by_rule = [&](double hysteresis, uint64_t fade) {
    Begun out;
    std::map<uint32_t, Agent> agents;
    for (uint64_t tick = 0; tick < request_.frames; ++tick) {
      const scene::Frame frame = frame_at(tick);
      for (const scene::FrameAgent& shown : frame.agents[0]) {
        Agent& agent = agents[shown.id];
        const double d = glm::length(shown.position);
        const bool now = tick == 0   ? d > kDistance
                         : agent.far ? d >= kDistance / (1 + hysteresis)
                                     : d > kDistance * (1 + hysteresis);
        if (tick > 0 && now != agent.far) {
          if (agent.begun && tick <= agent.over) {
            agent.over = 2 * tick - *agent.begun;
          } else {
            out.emplace(tick, shown.id);
            agent.begun = tick;
            agent.over = tick + fade;
          }
        }
        agent.far = now;
      }
    }
    return out;
  };
  const size_t without = by_rule(0, 0).size();
  EXPECT_GT(without, by_rule(0.04, 0).size()) << "or hysteresis has nothing to do";
  EXPECT_GT(by_rule(0.04, 0).size(), by_rule(0.15, 0).size());
  EXPECT_GT(without, by_rule(0, 6).size()) << "or no fade turns back";
  EXPECT_GE(by_rule(0.15, 6).size(), 5U);
  for (const auto& [hysteresis, fade] : {std::pair<double, uint64_t>{0, 0}, {0.15, 0}, {0, 6}, {0.04, 2}}) {
    SCOPED_TRACE(fmt::format("hysteresis {}, fade {}", hysteresis, fade));
    const PoppingResult result =
        measure(fmt::format("hybrid(mesh,({}),distance={},hysteresis={},fade={})", kFlat, kDistance, hysteresis, fade));
    Begun found;
    for (const Switch& s : result.switches) found.emplace(s.tick, s.id);
    EXPECT_EQ(found, by_rule(hysteresis, fade));
    EXPECT_EQ(found.size(), result.switches.size()) << "none twice";
  }
}

// Agents held together are those held one by one, by the frames themselves.
TEST_F(PoppingGl, ScoresTheFrameAgainstTheFrameWithoutTheSwitch) {
  CROWDBENCH_SKIP_SANITIZED("PoppingCommandGl.SweepsOptionsAndWritesTheWorst");
  const std::string spec = "hybrid(mesh,(" + kFlat + "),distance=8)";
  // Several agents a frame, and room between them.
  scenario_.tick_rate = 6;
  scenario_.width = 720;
  scenario_.height = 480;
  staged_ = stage_scenario(scenario_, cast_, context_);
  request_.frames = 7;
  request_.view.fps = scenario_.tick_rate;
  const PoppingResult result = measure(spec);
  const auto hybrid =
      renderers::make_representation({.context = context_, .cast = cast_, .use_cache = false}, request_.representation);
  renderers::Renderer renderer(context_, cast_);
  size_t checked = 0;
  for (const Switch& s : result.switches) {
    if (s.pixels == 0) continue;
    const renderers::Capture before = renderer.capture(frame_at(s.tick - 1), *hybrid);
    const scene::Frame frame = frame_at(s.tick);
    const renderers::Capture drawn = renderer.capture(frame, *hybrid);
    std::vector<renderers::AgentShares> shares = hybrid->shares(frame, renderers::all_agents(frame));
    for (renderers::AgentShares& agent : shares)
      if (agent.id == s.id) std::swap(agent.shares[0], agent.shares[1]);
    hybrid->hold(shares);
    const renderers::Capture held = renderer.capture(frame, *hybrid);
    hybrid->hold({});
    // The frame without the switch differs at that agent's pixels and nowhere else.
    for (size_t i = 0; i < held.ids.data.size(); ++i) {
      if (held.ids.data[i] == s.id || drawn.ids.data[i] == s.id) continue;
      for (size_t c = 0; c < 4; ++c) ASSERT_EQ(held.colour.data[4 * i + c], drawn.colour.data[4 * i + c]);
    }
    const metrics::Pop pop =
        metrics::score_pop({&before.colour, &drawn.colour, &held.colour, &drawn.ids, &held.ids}, s.id, request_.view)
            .value();
    EXPECT_EQ(pop.values, s.values) << s.tick << " " << s.id;
    EXPECT_EQ(pop.pixels, s.pixels);
    ++checked;
  }
  EXPECT_GE(checked, 4U);
  EXPECT_LT(result.drawings, request_.frames + result.switches.size()) << "some are held together";
}

TEST_F(PoppingGl, NothingIsSeenOfASwitchBetweenEquals) {
  const PoppingResult result = measure("hybrid(mesh,mesh,distance=8)");
  ASSERT_GE(seen_switches(result.switches), 4U);
  for (const Switch& s : result.switches)
    for (size_t k = 0; s.pixels > 0 && k < s.values.size(); ++k)
      EXPECT_EQ(s.values[k], metrics::pop_scores()[k].equal) << metrics::pop_scores()[k].name;
}

TEST_F(PoppingGl, ACrossFadeIsOneSwitchAndShowsLess) {
  CROWDBENCH_SKIP_SANITIZED("PoppingCommandGl.SweepsOptionsAndWritesTheWorst");
  const PoppingResult cut = measure("hybrid(mesh,(" + kFlat + "),distance=8)");
  const PoppingResult fade = measure("hybrid(mesh,(" + kFlat + "),distance=8,fade=5)");
  const auto keys = [](const PoppingResult& result) {
    std::set<std::pair<uint64_t, uint32_t>> out;
    for (const Switch& s : result.switches) out.emplace(s.tick, s.id);
    return out;
  };
  EXPECT_EQ(keys(fade), keys(cut)) << "the same agents at the same ticks";
  size_t complete = 0;
  for (const Switch& s : fade.switches) {
    if (!s.complete) {
      EXPECT_GT(s.tick + 6, request_.frames) << "only what goes on behind the last frame, or leaves the view";
      continue;
    }
    EXPECT_EQ(s.steps, 6U) << "five frames of both, and the one in which the old one goes";
    EXPECT_GE(s.worst_tick, s.tick);
    EXPECT_LT(s.worst_tick, s.tick + 6);
    ++complete;
  }
  EXPECT_GE(complete, 3U);
  const auto scores = metrics::pop_scores();
  for (const size_t k : {0U, 1U, 2U}) {
    const double of_cut = pop_quantiles(cut.switches, k).value().median;
    const double of_fade = pop_quantiles(fade.switches, k).value().median;
    EXPECT_TRUE(metrics::is_worse(scores[k], of_cut, of_fade)) << scores[k].name << " " << of_cut << " " << of_fade;
  }
  // A later start sees the same switches: what comes before is played, and what began before is left out.
  request_.tick = 6;
  request_.frames = 10;
  std::set<std::pair<uint64_t, uint32_t>> expected;
  for (const auto& [tick, id] : keys(fade))
    if (tick > 6 && tick < 16) expected.emplace(tick, id);
  EXPECT_FALSE(expected.empty());
  EXPECT_EQ(keys(measure("hybrid(mesh,(" + kFlat + "),distance=8,fade=5)")), expected);
}

TEST_F(PoppingGl, RefusesWhatNeverSwitches) { EXPECT_THROW((void)measure("mesh"), Error); }

TEST(PopQuantiles, AreOfTheSwitchesThatAreSeen) {
  std::vector<Switch> switches(4);
  for (size_t i = 0; i < 3; ++i) {
    switches[i].pixels = 10;
    switches[i].values = {9.0 + 0.25 * static_cast<double>(i), 0.1 * static_cast<double>(i)};
  }
  switches[3].values = {1.0, 1.0};
  EXPECT_EQ(seen_switches(switches), 3U);
  const PopQuantiles jod = pop_quantiles(switches, 0).value();
  EXPECT_DOUBLE_EQ(jod.median, 9.25);
  EXPECT_DOUBLE_EQ(jod.tail, 9.025);
  EXPECT_DOUBLE_EQ(jod.worst, 9);
  const PopQuantiles rising = pop_quantiles(switches, 1).value();
  EXPECT_DOUBLE_EQ(rising.tail, 0.19);
  EXPECT_DOUBLE_EQ(rising.worst, 0.2);
  EXPECT_FALSE(pop_quantiles({switches[3]}, 0));
}

// ---- the command

json printed(std::vector<std::string> arguments) {
  CLI::App app;
  Run run;
  Command program(app);
  add_popping(program, run);
  arguments.insert(arguments.begin(), "popping");
  arguments.emplace_back("--json");
  std::reverse(arguments.begin(), arguments.end());
  app.parse(arguments);
  ::testing::internal::CaptureStdout();
  ::testing::internal::CaptureStderr();
  std::string fault;
  try {
    EXPECT_EQ(run(), 0);
  } catch (const Error& error) {
    fault = error.what();
  }
  std::fflush(stdout);
  ::testing::internal::GetCapturedStderr();
  const std::string text = ::testing::internal::GetCapturedStdout();
  if (!fault.empty()) return {{"error", fault}};
  return json::parse(text);
}

const std::vector<std::string> kWalk = {
    "--agents", "30", "--size", "160x120", "--character", "mannequin:triangles=500", "--frames", "12", "--no-cache"};

std::vector<std::string> with(std::vector<std::string> more) {
  more.insert(more.end(), kWalk.begin(), kWalk.end());
  return more;
}

TEST(PoppingCommandGl, SweepsOptionsAndWritesTheWorst) {
  support::ScratchFolder folder;
  write_file(folder / "moving.toml",
             "[[camera.key]]\ntime = 0.0\neye = [0.0, 2.0, 6.0]\n[[camera.key]]\ntime = 1.0\neye = [0.0, 3.0, 10.0]\n");
  const std::string scenario = (folder / "moving.toml").string();
  const std::string pops = (folder / "pops").string();
  const std::vector<std::string> arguments =
      with({scenario, "--representation", "hybrid(mesh,(" + kFlat + "),distance=8)", "--sweep", "fade=0,3", "--sweep",
            "hysteresis=0,0.5", "--out", pops, "--worst", "2"});
  const json out = printed(arguments);
  ASSERT_FALSE(out.contains("error")) << out;
  ASSERT_EQ(out.at("runs").size(), 4U);
  EXPECT_EQ(out.at("ticks"), json({0, 11}));
  EXPECT_EQ(out.at("runs")[2].at("setting"), json({{"fade", "3"}, {"hysteresis", "0"}}));
  const json& cut = out.at("runs")[0];
  EXPECT_GE(cut.at("seen").get<int>(), 3);
  EXPECT_EQ(cut.at("list").size(), cut.at("switches"));
  EXPECT_LT(out.at("runs")[1].at("switches"), cut.at("switches")) << "half as far again, few get there";
  const auto worst = [&](size_t run, const char* name) {
    return out.at("runs")[run].at("quantiles").at(name).at("worst").get<double>();
  };
  EXPECT_LT(worst(0, "pop_cvvdp"), worst(2, "pop_cvvdp")) << "a fade is seen less";
  EXPECT_GT(worst(0, "pop_luma"), worst(2, "pop_luma"));
  EXPECT_GT(cut.at("quantiles").at("pop_luma").at("p95").get<double>(), 0);
  size_t switches = 0;
  for (const json& run : out.at("runs")) switches += std::min<size_t>(2, run.at("seen").get<size_t>());
  EXPECT_EQ(out.at("pictures").size(), 3 * switches);
  for (const json& file : out.at("pictures")) {
    const Image8 picture = decode_png(read_file(file.get<std::string>()), "a picture");
    EXPECT_GT(picture.width, 64);
  }
  EXPECT_EQ(printed(arguments), out) << "the same again";
}

TEST(PoppingCommandGl, LooksAtTheScenariosDisplay) {
  support::ScratchFolder folder;
  const std::string path =
      "[[camera.key]]\ntime = 0.0\neye = [0.0, 2.0, 6.0]\n[[camera.key]]\ntime = 1.0\neye = [0.0, 3.0, 10.0]\n";
  write_file(folder / "own.toml", "display = \"standard_hmd\"\n" + path);
  write_file(folder / "none.toml", path);
  const auto seen = [&](const char* scenario, std::vector<std::string> more) {
    more.insert(more.end(),
                {(folder / scenario).string(), "--representation", "hybrid(mesh,(" + kFlat + "),distance=8)"});
    return printed(with(more));
  };
  const json own = seen("own.toml", {});
  ASSERT_FALSE(own.contains("error")) << own;
  EXPECT_EQ(own.at("display").at("name"), "standard_hmd");
  EXPECT_EQ(own.at("display").at("given"), true);
  EXPECT_EQ(own.at("runs"), seen("none.toml", {"--display", "standard_hmd"}).at("runs"));
  EXPECT_NE(own.at("runs"), seen("none.toml", {}).at("runs"));
}

TEST(PoppingCommand, FindsTheFrameOfASequence) {
  const fs::path shared = fs::path(CROWDBENCH_SHARED_DIR) / "ground-truth" / "sequence";
  if (!fs::exists(shared)) GTEST_SKIP() << "needs the shared ground-truth folder";
  support::ScratchFolder folder;
  for (const std::string side : {"test", "ref"}) {
    fs::create_directories(folder / side);
    for (const auto& entry : fs::directory_iterator(shared))
      if (const std::string name = entry.path().filename().string(); name.starts_with(side))
        fs::copy_file(entry.path(), folder / side / name);
    const json out = printed({"--sequence", (folder / side).string()});
    ASSERT_FALSE(out.contains("error")) << out;
    EXPECT_EQ(out.at("frames"), 16);
    EXPECT_EQ(out.at("found"), side == "test" ? json({8}) : json::array());
    EXPECT_EQ(out.at("jumps").size(), 15U);
  }
}

TEST(PoppingCommand, SaysWhatIsWrong) {
  const auto says = [](const std::vector<std::string>& arguments, const char* text) {
    const json out = printed(arguments);
    ASSERT_TRUE(out.contains("error")) << out;
    EXPECT_NE(out.at("error").get<std::string>().find(text), std::string::npos) << out;
  };
  const std::string hybrid = "hybrid(mesh,mesh)";
  says({"--representation", "mesh"}, "--representation: the agents of 'mesh' never switch");
  says({}, "the agents of 'mesh' never switch");
  says({"--representation", hybrid, "--sweep", "fade"}, "--sweep: 'fade' is not an option with values");
  says({"--representation", hybrid, "--sweep", "fade=1,,2"}, "--sweep: 'fade=1,,2' is not an option with values");
  says({"--representation", hybrid, "--sweep", "fad=1"}, "did you mean 'fade'?");
  says({"--representation", hybrid, "--display", "standard_8k"}, "--display");
  support::ScratchFolder folder;
  says({"--sequence", (folder / "none").string()}, "none");
  fs::create_directories(folder / "one");
  write_png(folder / "one" / "a.png", Image8(16, 16, 3));
  says({"--sequence", (folder / "one").string()}, "has 1 frames");
}

}  // namespace
}  // namespace crowdbench::bench
