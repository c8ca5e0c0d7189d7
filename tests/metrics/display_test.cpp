// Displays by name and by file, against numbers that ColorVideoVDP itself gives (tests/data/ground-truth/cvvdp).
#include "metrics/display.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "core/error.h"
#include "core/files.h"
#include "test_paths.h"
#include "tests/support/scratch_folder.h"

namespace crowdbench::metrics {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

const json& units() {
  static const json all = json::parse(read_text(fs::path(CROWDBENCH_TEST_DATA) / "ground-truth/cvvdp/units.json"));
  return all["units"];
}

Display of_text(const std::string& text) { return parse_displays(text, "d.json", "d").at(0); }

// The named models, and those that the ground truth defines in ColorVideoVDP's own keys.
Display any_display(const std::string& name) {
  const json& custom = units()["custom_displays"];
  if (!custom.contains(name)) return find_display(name, "--display");
  return parse_displays(custom[name].dump(), "units.json", name).at(0);
}

std::string refusal(const std::string& text) {
  try {
    of_text(text);
  } catch (const Error& e) {
    return e.what();
  }
  return "accepted";
}

TEST(Display, TheDefaultIsStandard4kAndAlsoWhatTheMembersHold) {
  const Display bare;
  const Display& named = default_display();
  EXPECT_EQ(named.name, "standard_4k");
  EXPECT_EQ(bare.name, named.name);
  EXPECT_DOUBLE_EQ(bare.pixels_per_degree, named.pixels_per_degree);
  EXPECT_EQ(bare.width, named.width);
  EXPECT_EQ(bare.height, named.height);
  EXPECT_EQ(bare.distance, named.distance);
  EXPECT_DOUBLE_EQ(bare.diagonal, named.diagonal);
  EXPECT_EQ(bare.peak, named.peak);
  EXPECT_EQ(bare.black, named.black);
  EXPECT_EQ(bare.ambient, named.ambient);
  EXPECT_EQ(bare.colour_space.name, named.colour_space.name);
  EXPECT_EQ(Display{60}.pixels_per_degree, 60);
  EXPECT_EQ(display_text(named), "standard_4k: 75.40 pixels/degree, peak 200, black 0.2, reflected 0.3979 cd/m2, sRGB");
}

TEST(Display, PixelsPerDegreeByHand) {
  // A pixel of 1 mm at 57.29... mm is seen under one degree within 3e-5; half the picture's size, twice the pixels.
  EXPECT_NEAR(pixels_per_degree_by_size(3, 4, 0.005, 0.05729578), 1, 3e-5);
  EXPECT_NEAR(pixels_per_degree_by_size(3, 4, 0.0025, 0.05729578), 2, 2e-4);
  // 90 degrees between opposite corners of 3 x 4 pixels: a pixel is 2/5 of the distance.
  EXPECT_NEAR(pixels_per_degree_by_fov(3, 4, 90), 1 / (2 * 11.309932474020215), 1e-12);
}

TEST(Display, EveryModelHasTheReferencesPixelsBlackAndReflection) {
  size_t checked = 0;
  for (const auto& [name, expected] : units()["displays"].items()) {
    const Display d = any_display(name);
    // The reference's numbers have nine and seven digits.
    EXPECT_NEAR(d.pixels_per_degree / expected["ppd"].get<double>(), 1, 1e-8) << name;
    EXPECT_NEAR(d.black / expected["black_nit"].get<double>(), 1, 1e-6) << name;
    EXPECT_NEAR(reflected(d), expected["reflected_nit"].get<double>(), 1e-6 * (1 + reflected(d))) << name;
    ++checked;
  }
  EXPECT_EQ(checked, 32U);
  EXPECT_EQ(display_names().size(), 22U);
}

TEST(Display, ValuesBecomeTheReferencesLight) {
  size_t checked = 0;
  for (const auto& [name, expected] : units()["displays"].items()) {
    if (!expected.contains("rgb_to_dkl")) continue;
    const Display d = any_display(name);
    for (const json& one : expected["rgb_to_dkl"]) {
      const auto light = light_of(d, one["rgb"].get<std::array<double, 3>>());
      for (size_t c = 0; c < 3; ++c) {
        const double nits = one["linear_nit"][c].get<double>();
        // Single precision there. PQ loses most: near 1, c2 - c3 e is 0.3 left of two numbers of 18.7, whose roundings
        // of 1e-6 each its power of 6.3 makes 2.4e-5.
        EXPECT_NEAR(light[c] / nits, 1, d.colour_space.eotf == Eotf::pq ? 5e-5 : 2e-6) << name << one["rgb"];
        ++checked;
      }
    }
  }
  EXPECT_GT(checked, 150U);
}

TEST(Display, LightByHand) {
  Display d{60};
  d.ambient = 0;
  d.black = 1;
  d.peak = 101;
  EXPECT_EQ(light_of(d, {0, 1, 2}), (std::array{1.0, 101.0, 101.0}));
  d.colour_space.eotf = Eotf::gamma;
  d.colour_space.gamma = 2;
  EXPECT_DOUBLE_EQ(light_of(d, {0.5, 0, 0})[0], 26);
  d.exposure = 2;
  EXPECT_DOUBLE_EQ(light_of(d, {0.5, 0, 0})[0], 51);
  d.colour_space.eotf = Eotf::linear;
  EXPECT_EQ(light_of(d, {0, 7, 90}), (std::array{1.0, 14.0, 101.0})) << "cd/m2 after exposure, no black added";
}

TEST(Display, FilesHoldOneModelOrSeveral) {
  const Display one = of_text(R"({"pixels_per_degree": 50, "max_luminance": 100})");
  EXPECT_EQ(one.name, "d");
  EXPECT_EQ(one.black, 0.2) << "contrast 500";
  EXPECT_EQ(one.ambient, 0);
  EXPECT_EQ(one.width, 0) << "not given";
  const support::ScratchFolder folder;
  const fs::path file = folder.path() / "mine.json";
  write_file(file, R"({"a": {"pixels_per_degree": 50, "max_luminance": 100},
                       "b": {"resolution": [1920, 1080], "diagonal_size_inches": 24, "viewing_distance_meters": 0.6,
                             "max_luminance": 200, "min_luminance": 0.1, "E_ambient": 250, "name": "of b"}})");
  EXPECT_EQ(display_of(file.string() + ":a", "--display").pixels_per_degree, 50);
  const Display b = display_of(file.string() + ":b", "--display");
  EXPECT_DOUBLE_EQ(b.pixels_per_degree, find_display("standard_fhd", "").pixels_per_degree);
  EXPECT_EQ(b.black, 0.1);
  EXPECT_EQ(b.description, "of b");
  EXPECT_THROW(display_of(file.string(), "--display"), Error) << "which of them?";
  EXPECT_THROW(display_of(file.string() + ":c", "--display"), Error);
  EXPECT_THROW(display_of((folder.path() / "none.json").string(), "--display"), Error);
  EXPECT_EQ(display_of("standard_fhd", "--display").name, "standard_fhd");
}

TEST(Display, RefusalsNameTheKeyAndWhatIsRight) {
  try {
    find_display("standard_4", "--display");
    FAIL();
  } catch (const Error& e) {
    EXPECT_EQ(e.where, "--display");
    EXPECT_NE(std::string(e.what()).find("standard_4k"), std::string::npos) << e.what();
  }
  const std::pair<const char*, const char*> cases[] = {
      {R"({"pixels_per_degree": 50})", "max_luminance is missing"},
      {R"({"max_luminance": 100})", "pixels_per_degree"},
      {R"({"max_luminance": 100, "resolution": [1920, 1080], "diagonal_size_inches": 24})", "viewing_distance_meters"},
      {R"({"max_luminanc": 100, "pixels_per_degree": 50})", "use one of max_luminance"},
      {R"({"max_luminance": "100", "pixels_per_degree": 50})", "d.json: max_luminance: \"100\" is not right"},
      {R"({"max_luminance": -1, "pixels_per_degree": 50})", "0.01 to"},
      {R"({"max_luminance": 1e999, "pixels_per_degree": 50})", "does not parse"},
      {R"({"max_luminance": 100, "pixels_per_degree": 0})", "1 to 10000"},
      {R"({"max_luminance": 100, "pixels_per_degree": 50, "min_luminance": 100})", "not below max_luminance"},
      {R"({"max_luminance": 100, "pixels_per_degree": 50, "colorspace": "srgb"})", "sRGB"},
      {R"({"max_luminance": 100, "fov_diagonal": 90, "resolution": [1920]})", "[width, height]"},
      {R"({"max_luminance": 100, "fov_diagonal": 90, "resolution": [0, 5]})", "[width, height]"},
      {R"({"max_luminance": 100, "fov_diagonal": 180, "resolution": [5, 5]})", "0.1 to 179"},
      {R"({"max_luminance": 100, "fov_diagonal": 179, "resolution": [1, 1]})", "pixels a degree"},
      {R"({"max_luminance": 100, "pixels_per_degree": 50, "viewing_distance_meters": 1, "viewing_distance_inches": 39})",
       "both given"},
      {R"({"max_luminance": 2000, "pixels_per_degree": 50, "colorspace": "BT.2020-HLG"})", "in lux"},
      {R"({"max_luminance": 100, "max_luminance": 200, "pixels_per_degree": 50})", "twice"},
      {R"({"max_luminance": 100, "pixels_per_degree": 50, "name": 3})", "not text"},
      {R"([1, 2])", "not an object"},
      {R"({"a": {"b": {"c": {"d": 1}}}})", "nested deeper"},
      {"", "does not parse"},
      {"{\"max_luminance\"", "does not parse"},
      {"{\"\xff\": 1}", "does not parse"},
      {"{}", "pixels_per_degree"},
  };
  for (const auto& [text, what] : cases) {
    const std::string said = refusal(text);
    EXPECT_NE(said.find(what), std::string::npos) << text << " gave " << said;
    EXPECT_EQ(said.rfind("d.json: ", 0), 0U) << said;
    EXPECT_EQ(said.find('\n'), std::string::npos) << said;
  }
  EXPECT_NE(refusal(std::string(60000, '[')).find("nested deeper"), std::string::npos);
}

}  // namespace
}  // namespace crowdbench::metrics
