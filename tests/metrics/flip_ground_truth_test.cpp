// FLIP against NVIDIA's tool, and against the stages of its definition in double precision.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <string>

#include "core/colour.h"
#include "metrics/flip.h"
#include "metrics/flip_filters.h"
#include "metrics/flip_rows.h"
#include "metrics/registry.h"
#include "tests/metrics/flip_expected.h"
#include "tests/metrics/ground_truth.h"

namespace crowdbench::metrics {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

void expect_taps(const Taps& taps, const json& expected) {
  ASSERT_EQ(taps.size(), expected.size());
  for (size_t i = 0; i < taps.size(); ++i)
    EXPECT_NEAR(taps[i], std::abs(expected[i].get<double>()) * (taps[i] < 0 ? -1 : 1), 1e-6) << i;
}

TEST(FlipFilters, AreThoseOfTheDefinition) {
  const json stages = json::parse(read_text(kOwn / "flip_stages.json"));
  for (const double ppd : {kFlipPixelsPerDegree, 33.5, 120.0}) {
    const json& expected = stages["filters"][ppd == kFlipPixelsPerDegree ? "67.02064" : ppd == 120 ? "120" : "33.5"];
    SCOPED_TRACE(ppd);
    const ContrastFilters contrast = contrast_filters(ppd);
    EXPECT_EQ(contrast.achromatic.size(), expected["spatial_radius"].get<size_t>() + 1);
    expect_taps(contrast.achromatic, expected["Y"]);
    expect_taps(contrast.red_green, expected["Cx"]);
    expect_taps(contrast.blue_yellow[0], expected["Cz1"]);
    expect_taps(contrast.blue_yellow[1], expected["Cz2"]);
    const FeatureFilters feature = feature_filters(ppd);
    EXPECT_EQ(feature.gaussian.size(), expected["feature_radius"].get<size_t>() + 1);
    expect_taps(feature.gaussian, expected["g"]);
    expect_taps(feature.first, expected["dg"]);
    expect_taps(feature.second, expected["ddg"]);
    for (size_t i = 0; i < feature.second.size(); ++i)
      EXPECT_EQ(feature.second[i] < 0, expected["ddg"][i].get<double>() < 0) << i;
  }
}

// Returns how many figures were checked: pairs times pixels per degree.
int check_flip_pairs(const fs::path& folder) {
  const json all = expected_of(folder);
  int checked = 0;
  for (const auto& [name, pair] : all["pairs"].items()) {
    const auto [reference, test] = pictures_of(folder, all, name);
    for (const auto& [ppd, expected] : pair["contract"]["flip"].items()) {
      FlipSettings settings;
      if (ppd != "67.0206") settings.pixels_per_degree = std::stod(ppd);
      expect_pooled(flip_pooled(flip_map(reference, test, settings)), expected, name + " at " + ppd);
      ++checked;
    }
  }
  return checked;
}

TEST(FlipGroundTruth, TheBundledPairs) { EXPECT_EQ(check_flip_pairs(kOwn), 3 * 14); }

TEST(FlipGroundTruth, TheWholeSharedSet) {
  if (!fs::exists(kShared)) GTEST_SKIP() << "needs the shared ground-truth folder (a01_tree and others)";
  EXPECT_EQ(check_flip_pairs(kShared), 3 * 22);
}

// Returns how many maps were checked.
int check_flip_maps(const fs::path& folder) {
  const json all = expected_of(folder);
  int checked = 0;
  for (const auto& [name, files] : all["maps"].items()) {
    if (!files.contains("flip_grey")) continue;
    ++checked;
    const Image8 reference = picture(folder / all["pairs"][name]["ref"].get<std::string>());
    const Image8 test = picture(folder / all["pairs"][name]["test"].get<std::string>());
    ScoreInput input;
    input.reference.codes = &reference;
    input.test.codes = &test;
    input.maps = true;
    Shared shared;
    const auto scored = score_pictures(scores(), input, shared);
    const auto flip =
        std::find_if(scored.begin(), scored.end(), [](const Scored& s) { return s.score->name == "flip"; });
    if (flip == scored.end()) throw std::logic_error("no flip");
    const Image8 grey = picture(folder / files["flip_grey"].get<std::string>());
    const Image8 magma = picture(folder / files["flip_magma"].get<std::string>());
    const Image8 painted = map_picture(*flip->score, flip->result, MapColours::plain);
    EXPECT_EQ(painted.width, magma.width);
    EXPECT_EQ(painted.height, magma.height);
    size_t beyond = 0;
    size_t other_colour = 0;
    for (size_t i = 0; i < grey.pixels(); ++i) {
      const int level = static_cast<int>(255 * flip->result.map->values.data[i] + 0.5);
      const int expected = grey.data[i * static_cast<size_t>(grey.channels)];
      EXPECT_LE(std::abs(level - expected), 2) << name << ' ' << i;
      beyond += std::abs(level - expected) > 1 ? 1 : 0;
      other_colour += std::equal(&painted.data[3 * i], &painted.data[3 * i] + 3,
                                 &magma.data[static_cast<size_t>(magma.channels) * i])
                          ? 0
                          : 1;
    }
    EXPECT_LE(beyond, grey.pixels() / 1000) << name;
    EXPECT_LE(other_colour, grey.pixels() / 1000) << name << ": colours that are not the tool's";
  }
  return checked;
}

TEST(FlipGroundTruth, MapsAsTheToolPaintsThem) {
  EXPECT_EQ(check_flip_maps(kOwn), 1);
  if (fs::exists(kShared)) {
    EXPECT_EQ(check_flip_maps(kShared), 3);
  }
}

// The parts of the error at eight pixels of five pairs, by a plain reading of the definition in double precision.
void check_stages(const fs::path& folder) {
  const json stages = json::parse(read_text(folder / "flip_stages.json"));
  const json all = expected_of(folder);
  EXPECT_NEAR(greatest_colour_distance(), stages["cmax"].get<double>(), 1e-4);
  for (const auto& [name, expected] : stages["pairs"].items()) {
    SCOPED_TRACE(name);
    const Image8 reference = picture(folder / all["pairs"][name]["ref"].get<std::string>());
    const Image8 test = picture(folder / all["pairs"][name]["test"].get<std::string>());
    FlipStages parts;
    const ImageF map = flip_map(reference, test, {}, &parts);
    double colour = 0;
    double feature = 0;
    for (size_t i = 0; i < map.data.size(); ++i) {
      colour += parts.colour.data[i];
      feature += std::sqrt(std::max(parts.edge.data[i], parts.point.data[i]) / std::sqrt(2.0));
    }
    const auto pixels = static_cast<double>(map.data.size());
    EXPECT_NEAR(colour / pixels, expected["mean"]["colour"].get<double>(), 1e-5);
    EXPECT_NEAR(feature / pixels, expected["mean"]["feature"].get<double>(), 1e-4);
    EXPECT_NEAR(flip_pooled(map).mean, expected["mean"]["flip"].get<double>(), 2e-5);
    for (size_t i = 0; i < expected["points_row_col"].size(); ++i) {
      const int y = expected["points_row_col"][i][0].get<int>();
      const int x = expected["points_row_col"][i][1].get<int>();
      EXPECT_NEAR(*parts.colour.at(x, y), expected["colour_difference"][i].get<double>(), 2e-5) << i;
      EXPECT_NEAR(*parts.edge.at(x, y), expected["edge_difference"][i].get<double>(), 1e-6) << i;
      EXPECT_NEAR(*parts.point.at(x, y), expected["point_difference"][i].get<double>(), 1e-6) << i;
      EXPECT_NEAR(*map.at(x, y), expected["flip"][i].get<double>(), 5e-5) << i;
    }
    for (const auto& [key, side] : {std::pair("ref_YCxCz", &reference), std::pair("test_YCxCz", &test)})
      for (size_t i = 0; i < expected[key].size(); ++i) {
        std::array<std::array<float, kRowBlock>, 6> rows{};
        const auto* p =
            side->at(expected["points_row_col"][i][1].get<int>(), expected["points_row_col"][i][0].get<int>());
        for (size_t c = 0; c < 3; ++c) rows[c][0] = static_cast<float>(srgb_to_linear(p[c] / 255.0));
        opponents_of(rows[0].data(), rows[1].data(), rows[2].data(), {rows[3].data(), rows[4].data(), rows[5].data()},
                     1);
        EXPECT_NEAR(116 * rows[3][0] - 16, expected[key][i][0].get<double>(), 1e-4) << key << i;
        EXPECT_NEAR(500 * rows[4][0], expected[key][i][1].get<double>(), 1e-4) << key << i;
        EXPECT_NEAR(200 * rows[5][0], expected[key][i][2].get<double>(), 1e-4) << key << i;
      }
  }
}

TEST(FlipGroundTruth, Stages) {
  check_stages(kOwn);
  if (fs::exists(kShared)) check_stages(kShared);
}

TEST(FlipGroundTruth, TheSequenceFrameByFrame) {
  if (!fs::exists(kShared)) GTEST_SKIP() << "needs the shared ground-truth folder";
  const json sequence = expected_of(kShared)["sequence"];
  Image8 before;
  for (size_t t = 0; t < sequence["frames"].get<size_t>(); ++t) {
    const json& expected = sequence["per_frame"][t];
    const Image8 reference = picture(kShared / fmt::format("sequence/ref_{:02}.png", t));
    const Image8 test = picture(kShared / fmt::format("sequence/test_{:02}.png", t));
    EXPECT_NEAR(flip_pooled(flip_map(reference, test)).mean, expected["flip_mean"].get<double>(), 2e-4) << t;
    if (t > 0) {
      EXPECT_NEAR(flip_pooled(flip_map(before, reference)).mean, expected["flip_ref_t_vs_prev"].get<double>(), 2e-4);
    }
    before = reference;
  }
}

}  // namespace
}  // namespace crowdbench::metrics
