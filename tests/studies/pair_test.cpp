#include "studies/stimuli/pair.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <nlohmann/json.hpp>

#include "core/error.h"
#include "core/hash.h"
#include "renderers/frame/capture.h"
#include "scene/cast/load_cast.h"
#include "scene/scenario/scenario_writer.h"

namespace crowdbench::studies {
namespace {
namespace fs = std::filesystem;

class PairGl : public testing::Test {
 protected:
  fs::path folder = fs::temp_directory_path() / ("crowdbench-pair-" + std::to_string(::getpid()));
  void SetUp() override { fs::create_directories(folder); }
  void TearDown() override { fs::remove_all(folder); }

  static PairRequest request(const scene::Scenario& scenario, const scene::Cast& cast) {
    PairRequest r;
    r.scenario = scenario;
    r.crowd = scene::make_crowd(scenario, cast, scene::stage_view(scenario));
    r.a = renderers::parse_spec("mesh");
    r.b = renderers::parse_spec("mesh:floor=1");  // stands still: easy to tell from the other
    r.frames = 4;
    return r;
  }
  static scene::Scenario small_scenario() {
    scene::Scenario scenario;
    scenario.width = 95;  // odd on purpose
    scenario.height = 70;
    scenario.crowd.agents = 9;
    scenario.characters[0].source = "mannequin:triangles=500";
    scenario.ground = true;
    return scenario;
  }
};

TEST_F(PairGl, HalvesAreWhatTheManifestSays) {
  const scene::Scenario scenario = small_scenario();
  const scene::Cast cast = scene::load_cast(scenario);
  gl::Context context;
  PairRequest r = request(scenario, cast);
  r.clip.master = true;
  const Pair pair = export_pair(context, cast, r, folder / "p.mp4");
  ASSERT_TRUE(pair.clip.accurate);
  EXPECT_EQ(pair.a_on_top, first_on_top(scenario.seed));

  const auto json = nlohmann::json::parse(read_text(folder / "p.json"));
  EXPECT_EQ(json["clip"], "p.mp4");
  EXPECT_EQ(json["sha256"], sha256_hex(read_text(folder / "p.mp4")));
  EXPECT_EQ(json["top"]["representation"], pair.a_on_top ? "mesh" : "mesh:floor=1");
  EXPECT_EQ(json["bottom"]["representation"], pair.a_on_top ? "mesh:floor=1" : "mesh");
  EXPECT_EQ(json["top"]["configuration"], pair.a_on_top ? "a" : "b");
  EXPECT_EQ(json["seed"], 1);
  EXPECT_EQ(json["agents"], 9);
  EXPECT_EQ(json["bar"]["height"], 8);
  EXPECT_EQ(json["bar"]["colour"], "#000000");
  EXPECT_EQ(json["scenario"]["sha256"], sha256_hex(scene::to_toml(scenario)));
  EXPECT_EQ(json["renderer"]["name"], context.renderer());
  EXPECT_EQ(json["video"]["frames"], 4);
  EXPECT_EQ(json["video"]["width"], 96);
  EXPECT_EQ(json["video"]["height"], 148);
  ASSERT_EQ(json["video"]["frame_sha256"].size(), 4U);

  // Frame 3 of the master against the two captures, put together by hand.
  renderers::Renderer renderer(context, cast);
  const auto a = renderers::make_representation({context, cast}, r.a);
  const auto b = renderers::make_representation({context, cast}, r.b);
  const auto capture = [&](renderers::Representation& representation) {
    return renderer.capture(scene::make_frame(scenario, cast, r.crowd, scenario.camera.at(0.1), 3), representation)
        .colour;
  };
  const Image8 of_a = capture(*a);
  const Image8 of_b = capture(*b);
  ASSERT_NE(of_a, of_b);
  ClipReader reader(folder / "p.master.mp4");
  ClipReader::Frame frame;
  for (int i = 0; i < 4; ++i) ASSERT_TRUE(reader.next(frame));
  const Image8& top = pair.a_on_top ? of_a : of_b;
  const Image8& bottom = pair.a_on_top ? of_b : of_a;
  for (int y = 0; y < 148; ++y) {
    for (int x = 0; x < 96; ++x) {
      const uint8_t black[3] = {0, 0, 0};
      const uint8_t* expected = x == 95 ? black : y < 70 ? top.at(x, y) : y < 78 ? black : bottom.at(x, y - 78);
      ASSERT_TRUE(std::equal(expected, expected + 3, frame.rgb.at(x, y))) << x << ", " << y;
    }
  }
}

TEST_F(PairGl, SameRequestSameBytesAndTheSeedChoosesTheSide) {
  scene::Scenario scenario = small_scenario();
  const scene::Cast cast = scene::load_cast(scenario);
  gl::Context context;
  for (const char* sub : {"one", "two"}) fs::create_directories(folder / sub);
  export_pair(context, cast, request(scenario, cast), folder / "one" / "p.mp4");
  export_pair(context, cast, request(scenario, cast), folder / "two" / "p.mp4");
  EXPECT_EQ(read_text(folder / "one" / "p.mp4"), read_text(folder / "two" / "p.mp4"));
  EXPECT_EQ(read_text(folder / "one" / "p.json"), read_text(folder / "two" / "p.json"));
  scenario.seed = 2;
  ASSERT_NE(first_on_top(1), first_on_top(2));
  const Pair other = export_pair(context, cast, request(scenario, cast), folder / "three.mp4");
  EXPECT_EQ(other.a_on_top, first_on_top(2));
}

TEST_F(PairGl, TicksMustDivideIntoFrames) {
  scene::Scenario scenario = small_scenario();
  scenario.tick_rate = 50;
  const scene::Cast cast = scene::load_cast(scenario);
  gl::Context context;
  EXPECT_THROW(export_pair(context, cast, request(scenario, cast), folder / "p.mp4"), Error);
  EXPECT_TRUE(fs::is_empty(folder));
  // 25 frames a second do: every other tick.
  PairRequest r = request(scenario, cast);
  r.clip.fps = 25;
  const Pair pair = export_pair(context, cast, r, folder / "p.mp4");
  EXPECT_EQ(pair.clip.fps, 25);
  EXPECT_NE(pair.manifest.find("\"ticks_per_frame\": 2"), std::string::npos) << pair.manifest;
}

TEST_F(PairGl, MissedAccuracyLeavesNothing) {
  const scene::Scenario scenario = small_scenario();
  const scene::Cast cast = scene::load_cast(scenario);
  gl::Context context;
  PairRequest r = request(scenario, cast);
  r.clip.least_psnr = 90;
  EXPECT_FALSE(export_pair(context, cast, r, folder / "p.mp4").clip.accurate);
  EXPECT_TRUE(fs::is_empty(folder));
}

}  // namespace
}  // namespace crowdbench::studies
