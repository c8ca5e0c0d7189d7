// A display chosen in a scenario or by --display: one for FLIP and ColorVideoVDP, in every command that scores
// pictures.
#include "metrics/display.h"

#include <gtest/gtest.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "bench/commands/command_line.h"
#include "bench/commands/commands.h"
#include "bench/commands/scene_options.h"
#include "bench/stage/scenario_display.h"
#include "core/error.h"
#include "core/files.h"
#include "core/image_io.h"
#include "metrics/registry.h"
#include "scene/scenario/scenario_keys.h"
#include "store/store.h"
#include "tests/support/scratch_folder.h"

namespace crowdbench::bench {
namespace {

using nlohmann::json;
using Words = std::vector<std::string>;

constexpr const char* kFlat = "flat:views=sphere-8x3,texels=64,frames=4";
constexpr const char* kFhd =
    "[display]\nresolution = [1920, 1080]\nviewing_distance_meters = 0.6\ndiagonal_size_inches = 24\n"
    "max_luminance = 200\ncontrast = 1000\nE_ambient = 250\n";

json facts(AddCommand add, Words words) {
  CLI::App app;
  Run run;
  Command program(app);
  add(program, run);
  words.emplace_back("--json");
  std::reverse(words.begin(), words.end());
  app.parse(words);
  ::testing::internal::CaptureStdout();
  const int status = run();
  std::fflush(stdout);
  const std::string text = ::testing::internal::GetCapturedStdout();
  EXPECT_EQ(status, 0);
  return json::parse(text);
}

// What `compare` says of two files on that display.
json compared(const std::filesystem::path& reference, const std::filesystem::path& test, const std::string& display) {
  Words words = {"compare", reference.string(), test.string(), "--scores", "flip,cvvdp"};
  if (!display.empty()) words.insert(words.end(), {"--display", display});
  return facts(add_compare, words).at("scores");
}

class DisplayGl : public ::testing::Test {
 protected:
  std::string written(const char* name, const std::string& text) const {
    write_file(folder_ / name, std::string_view(text));
    return (folder_ / name).string();
  }
  support::ScratchFolder folder_;
};

TEST_F(DisplayGl, QualityScoresAsCompareDoes) {
  const auto quality = [&](const std::string& display) {
    Words words = {"quality", "--representation", kFlat, "--character", "mannequin:triangles=500", "--height-px",
                   "60",      "--rows",           "96",  "--maps",      folder_.path().string()};
    if (!display.empty()) words.insert(words.end(), {"--display", display});
    return facts(add_quality, words);
  };
  const json on_fhd = quality("standard_fhd");
  const json by_default = quality("");
  std::filesystem::path reference;
  std::filesystem::path test;
  for (const auto& entry : std::filesystem::directory_iterator(folder_.path())) {
    const std::string name = entry.path().filename().string();
    if (name.ends_with("_reference.png")) reference = entry.path();
    if (name.ends_with("_test.png")) test = entry.path();
  }
  for (const auto& [found, display] : {std::pair(on_fhd, "standard_fhd"), std::pair(by_default, "")}) {
    const json wanted = compared(reference, test, display);
    EXPECT_EQ(found.at("rows")[0].at("flip"), wanted.at("flip")) << display;
    EXPECT_EQ(found.at("rows")[0].at("cvvdp"), wanted.at("cvvdp")) << display;
  }
  EXPECT_NE(on_fhd.at("rows")[0].at("flip"), by_default.at("rows")[0].at("flip"));
  EXPECT_NE(on_fhd.at("rows")[0].at("cvvdp"), by_default.at("rows")[0].at("cvvdp"));
  EXPECT_EQ(on_fhd.at("display").at("name"), "standard_fhd");
  EXPECT_EQ(by_default.at("display").at("given"), false);
}

// The whole pictures of `bench`, from its result file, on the display of the scenario, by keys and by name.
TEST_F(DisplayGl, BenchScoresOnTheScenariosDisplayAsCompareDoes) {
  for (const std::string& display : {std::string(kFhd), std::string("display = \"standard_fhd\"\n")}) {
    const std::string results = (folder_ / "results.sqlite").string();
    std::filesystem::remove(results);
    facts(add_bench, {"bench", written("s.toml", display), "--representation", kFlat, "--character",
                      "mannequin:triangles=500", "--agents", "3", "--occupancy", "0.2", "--size", "160x120", "--rounds",
                      "10", "--no-floors", "--out", results});
    const StoreContents contents = read_store(results);
    ASSERT_EQ(contents.comparisons.size(), 1U);
    const ComparisonRow& row = contents.comparisons[0];
    EXPECT_EQ(row.display_given, true);
    EXPECT_TRUE(
        row.display.value_or("").ends_with(": 37.84 pixels/degree, peak 200, black 0.2, reflected 0.3979 cd/m2, "
                                           "sRGB"))
        << row.display.value_or("");
    EXPECT_NE(contents.runs[0].scenario.find("[display]"), std::string::npos);
    for (const PictureRow& picture : contents.pictures)
      write_file(folder_ / (picture.role + ".png"),
                 std::string_view(reinterpret_cast<const char*>(picture.png.data()), picture.png.size()));
    const json wanted = compared(folder_ / "reference.png", folder_ / "test.png", "standard_fhd");
    const json other = compared(folder_ / "reference.png", folder_ / "test.png", "");
    const auto score = [&](const std::string& name) {
      const auto found =
          std::find_if(row.scores.begin(), row.scores.end(), [&](const ScoreRow& one) { return one.name == name; });
      return found == row.scores.end() ? std::nullopt : found->value;
    };
    EXPECT_EQ(json(score("flip").value()), wanted.at("flip").at("mean"));
    EXPECT_EQ(json(score("cvvdp").value()), wanted.at("cvvdp"));
    EXPECT_NE(wanted.at("flip"), other.at("flip"));
    EXPECT_NE(wanted.at("cvvdp"), other.at("cvvdp"));
  }
}

TEST_F(DisplayGl, TheOptionGoesBeforeTheScenario) {
  const auto distance = [&](const std::string& scenario, const std::string& option) {
    Words words = {"distance",         written("s.toml", scenario),
                   "--representation", kFlat,
                   "--character",      "mannequin:triangles=500",
                   "--agents",         "6",
                   "--occupancy",      "0.2",
                   "--size",           "160x120",
                   "--scores",         "flip,cvvdp"};
    if (!option.empty()) words.insert(words.end(), {"--display", option});
    return facts(add_distance, words);
  };
  const json by_scenario = distance("display = 'standard_fhd'", "");
  const json by_option = distance("display = 'standard_hmd'", "standard_fhd");
  const json by_default = distance("", "");
  EXPECT_EQ(by_scenario.at("rows"), by_option.at("rows"));
  EXPECT_NE(by_scenario.at("rows"), by_default.at("rows"));
  EXPECT_EQ(by_option.at("display").at("name"), "standard_fhd");
}

TEST_F(DisplayGl, PopMapsAreOfADisplayToo) {
  const auto pops = [&](const std::string& display) {
    return facts(add_popmap, {"popmap", "--representation", kFlat, "--character", "mannequin:triangles=500",
                              "--height-px", "40", "--azimuth-deg", "0", "--elevation-deg", "0", "--phase", "0.1",
                              "--scores", "flip,cvvdp", "--display", display});
  };
  const json on_fhd = pops("standard_fhd");
  const json on_4k = pops("standard_4k");
  const auto worst = [](const json& map, const char* name) {
    return map.at("sizes")[0].at("switch").at("own_cut").at(name).at("worst");
  };
  EXPECT_GT(worst(on_fhd, "flip"), worst(on_4k, "flip")) << "larger pixels show more";
  EXPECT_LT(worst(on_fhd, "cvvdp"), 10);
  EXPECT_NE(worst(on_fhd, "cvvdp"), worst(on_4k, "cvvdp"));
  EXPECT_EQ(on_fhd.at("display").at("name"), "standard_fhd");
}

class ScenarioDisplay : public DisplayGl {
 protected:
  ChosenScenario read(const std::string& text) const {
    SceneOptions options;
    options.file = written("s.toml", text);
    return read_scenario(options);
  }
  // What is said of it, from the file's name on.
  std::string fault(const std::string& text) const {
    try {
      read(text);
    } catch (const Error& error) {
      const std::string said = error.what();
      return said.substr(said.find("s.toml"));
    }
    return "";
  }
};

TEST_F(ScenarioDisplay, IsAModelAFileOrKeys) {
  EXPECT_FALSE(read("").display.given);
  EXPECT_EQ(read("display = 'standard_hmd'").display.display.name, "standard_hmd");
  const metrics::ChosenDisplay keys = read(kFhd).display;
  EXPECT_TRUE(keys.given);
  const metrics::Display model = metrics::find_display("standard_fhd", "");
  EXPECT_EQ(keys.display.pixels_per_degree, model.pixels_per_degree);
  EXPECT_EQ(keys.display.peak, model.peak);
  EXPECT_EQ(keys.display.black, model.black);
  EXPECT_EQ(metrics::reflected(keys.display), metrics::reflected(model));
  // Beside the scenario, wherever the program runs.
  written("mine.json", R"({"pixels_per_degree": 41.5, "max_luminance": 300})");
  EXPECT_EQ(read("display = 'mine.json'").display.display.pixels_per_degree, 41.5);
}

TEST_F(ScenarioDisplay, FaultsNameTheLine) {
  EXPECT_TRUE(fault("\ndisplay = 'standard_fhdd'")
                  .starts_with("s.toml:2: `display.model`: 'standard_fhdd' is not a "
                               "display; did you mean standard_fhd? Else use one of standard_fhd"))
      << fault("\ndisplay = 'standard_fhdd'");
  EXPECT_TRUE(fault("[display]\npixels_per_degree = 60\nmax_luminance = 100\ncolorspace = 'sRBG'")
                  .starts_with("s.toml:4: `display.colorspace`: 'sRBG' is not a colour space; use one of sRGB"));
  EXPECT_TRUE(fault("[display]\npixels_per_degree = 60").starts_with("s.toml:2: `display`: max_luminance is missing"));
  EXPECT_TRUE(fault("[display]\npixels_per_degree = 60\nmax_luminance = 100\nmin_luminance = 200")
                  .starts_with("s.toml:4: `display.min_luminance`: 200 is not below"));
  EXPECT_TRUE(fault("[display]\nmodel = 'standard_4k'\nmax_luminance = 100")
                  .starts_with("s.toml:2: `display.model`: a model and keys"));
  EXPECT_TRUE(fault("[display]\nmax_luminance = 1e7").starts_with("s.toml:2: `display.max_luminance` is 10000000"));
}

// The scenario's keys are those of display files, with their ranges: what one takes, the other takes.
TEST(DisplayKeys, OfScenariosAreThoseOfFiles) {
  const auto said = [](const std::string& name, double value) -> std::string {
    json file = {{"pixels_per_degree", 60}, {"max_luminance", 1e6}, {"min_luminance", 1e-9}};
    file[name] = value;
    try {
      metrics::parse_displays(file.dump(), "file", "made");
    } catch (const Error& error) {
      return error.what();
    }
    return "";
  };
  size_t numbers = 0;
  for (const scene::Key& key : scene::scenario_keys()) {
    if (key.table != "display" || key.type != scene::KeyType::number) continue;
    ++numbers;
    for (const double end : {key.low, key.high}) {
      EXPECT_EQ(said(key.name, end).find("is not a key"), std::string::npos) << key.name;
      EXPECT_EQ(said(key.name, end).find("use a number"), std::string::npos) << key.name << " " << end;
    }
    for (const double beyond : {key.low - 1e-4, key.high * 1.0001})
      EXPECT_NE(said(key.name, beyond).find("use a number"), std::string::npos) << key.name << " " << beyond;
  }
  EXPECT_EQ(numbers, 12U);
}

TEST(DisplayKeys, NoneGivenIsTheDefaultAndNotChosen) {
  EXPECT_FALSE(display_of_scenario({}, {}, {}).given);
  scene::Scenario scenario;
  scenario.display.model = "nowhere.json";
  try {
    (void)display_of_scenario(scenario, "beside", {{"crowd.agents", "s.toml:1"}, {"display.model", "s.toml:9"}});
    FAIL();
  } catch (const Error& error) {
    EXPECT_TRUE(std::string(error.what()).starts_with("beside/nowhere.json: cannot open")) << error.what();
  }
}

}  // namespace
}  // namespace crowdbench::bench
