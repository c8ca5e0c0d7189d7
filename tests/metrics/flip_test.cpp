// LDR-FLIP and HDR-FLIP: by hand, against the stages of the definition in double precision, and against NVIDIA's tool.
#include "metrics/flip.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <nlohmann/json.hpp>
#include <string>

#include "core/colour.h"
#include "core/error.h"
#include "core/files.h"
#include "core/image_io.h"
#include "core/random.h"
#include "metrics/fast_math.h"
#include "metrics/flip_filters.h"
#include "metrics/flip_rows.h"
#include "metrics/hdr_flip.h"
#include "metrics/not_finite.h"
#include "metrics/pseudocolour.h"
#include "metrics/registry.h"
#include "test_paths.h"

namespace crowdbench::metrics {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

const fs::path kOwn = fs::path(CROWDBENCH_TEST_DATA) / "ground-truth";
const fs::path kShared = fs::path(CROWDBENCH_SHARED_DIR) / "ground-truth";

Image8 picture(const fs::path& path) { return decode_png(read_file(path), path.filename().string()); }
ImageF floats(const fs::path& path) { return std::get<ImageF>(read_image(path)); }

// The file has a bare Infinity, which is not JSON.
json expected_of(const fs::path& folder) {
  std::string text = read_text(folder / "expected.json");
  const std::string bare = " Infinity";
  for (size_t at = 0; (at = text.find(bare, at)) != std::string::npos;) text.replace(at, bare.size(), " null");
  return json::parse(text);
}

Image8 noise(int width, int height, uint64_t seed) {
  Image8 out(width, height, 3);
  for (size_t i = 0; i < out.data.size(); ++i) out.data[i] = static_cast<uint8_t>(random_below(seed, i, 1, 256));
  return out;
}

// ---- arithmetic ----

TEST(FastMath, IsAsNearAsItSays) {
  for (int i = 0; i <= 200'000; ++i) {
    const float t = std::exp2(static_cast<float>(i - 100'000) / 1005.0F);
    ASSERT_NEAR(fast_cbrt(t) / std::cbrt(double{t}), 1, 2.5e-7) << t;
    const double log = std::log2(double{t});
    ASSERT_NEAR(fast_log2(t), log, 2e-7 + std::abs(log) * 6e-8) << t;
    const float p = static_cast<float>(i - 100'000) / 800.0F;
    ASSERT_NEAR(fast_exp2(p) / std::exp2(double{p}), 1, 3e-7) << p;
  }
  for (int i = 1; i <= 2000; ++i)
    for (const float exponent : {0.01F, 0.3F, 0.7F, 1.0F}) {
      const float base = static_cast<float>(i) / 10;
      ASSERT_NEAR(fast_pow(base, exponent) / std::pow(double{base}, double{exponent}), 1, 1e-6) << base;
    }
  EXPECT_EQ(fast_pow(0, 0.7F), 0);
  EXPECT_EQ(fast_exp2(-500), fast_exp2(-126));
}

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

TEST(FlipFilters, TrimmedTapsLoseNothing) {
  EXPECT_EQ(trimmed({0.5F, 0.25F}), (Taps{0.5F, 0.25F}));
  EXPECT_EQ(trimmed({0.5F, 0.25F, 1e-12F, 0}), (Taps{0.5F, 0.25F}));
  EXPECT_EQ(trimmed({1}), Taps{1});
  const ContrastFilters contrast = contrast_filters(kFlipPixelsPerDegree);
  EXPECT_LT(trimmed(contrast.achromatic).size(), contrast.achromatic.size());
  EXPECT_EQ(trimmed(contrast.blue_yellow[0]).size(), contrast.blue_yellow[0].size());
}

// ---- identity ----

TEST(Flip, EqualPicturesAreExactlyZeroAndTheOrderHardlyMatters) {
  const Image8 a = noise(70, 41, 1);
  const Image8 b = noise(70, 41, 2);
  const ImageF same = flip_map(a, a);
  EXPECT_TRUE(std::all_of(same.data.begin(), same.data.end(), [](float v) { return v == 0; }));
  EXPECT_EQ(flip_map(a, b), flip_map(b, a)) << "FLIP is symmetric";
  EXPECT_THROW(flip_map(a, noise(70, 40, 1)), Error);
}

TEST(Flip, SixteenBitsAndGreyAndAlphaGiveTheSame) {
  const Image8 a = noise(40, 30, 1);
  const Image8 b = noise(40, 30, 2);
  EXPECT_EQ(flip_map(widen(a), widen(b)), flip_map(a, b));
  Image8 grey(40, 30, 1);
  Image8 repeated(40, 30, 3);
  Image8 with_alpha(40, 30, 4);
  for (size_t i = 0; i < grey.data.size(); ++i) {
    grey.data[i] = a.data[3 * i];
    for (size_t c = 0; c < 3; ++c) repeated.data[3 * i + c] = with_alpha.data[4 * i + c] = grey.data[i];
    with_alpha.data[4 * i + 3] = static_cast<uint8_t>(i);
  }
  EXPECT_EQ(flip_map(grey, b), flip_map(repeated, b));
  EXPECT_EQ(flip_map(with_alpha, b), flip_map(repeated, b));
}

TEST(Flip, AnyNumberOfThreadsGivesTheSameBytes) {
  // More than one tile in both directions, neither a whole number of them.
  const Image8 a = noise(801, 530, 1);
  const Image8 b = noise(801, 530, 2);
  const ImageF one = flip_map(a, b, {kFlipPixelsPerDegree, 1});
  EXPECT_EQ(flip_map(a, b, {kFlipPixelsPerDegree, 3}), one);
  EXPECT_EQ(flip_map(a, b, {kFlipPixelsPerDegree, 8}), one);
}

// Tiles are an arrangement of the work alone: the definition, written down plainly in double precision over the whole
// picture, gives the same where tiles meet.
TEST(Flip, TilesDoNotShow) {
  const Image8 a = noise(420, 300, 1);
  const Image8 b = noise(420, 300, 2);
  const ImageF whole = flip_map(a, b);
  // The same pixels in a picture that begins elsewhere, so that its tiles end elsewhere.
  constexpr int kLeft = 60;
  constexpr int kTop = 40;
  const auto cut = [&](const Image8& image) {
    Image8 out(image.width - kLeft, image.height - kTop, 3);
    for (int y = 0; y < out.height; ++y)
      std::copy_n(image.at(kLeft, y + kTop), 3 * static_cast<size_t>(out.width), out.at(0, y));
    return out;
  };
  const ImageF part = flip_map(cut(a), cut(b));
  constexpr int kReach = 10;  // of the filters
  for (int y = kReach; y < part.height; ++y)
    for (int x = kReach; x < part.width; ++x)
      ASSERT_EQ(*part.at(x, y), *whole.at(x + kLeft, y + kTop)) << x << ' ' << y;
}

// ---- by hand ----

// Flat pictures have no features, so that the error is that of the colours alone. Black has L = 0 and no hue, white L =
// 100: HyAB 100, to the power 0.7 it is 25.119. The greatest distance is 41.2761, of which 0.4 is 16.5104: above, the
// last 0.05 are spread over the rest.
TEST(Flip, BlackAndWhiteByHand) {
  EXPECT_NEAR(greatest_colour_distance(), 41.2761, 1e-4);
  Image8 black(9, 7, 3);
  Image8 white = black;
  std::fill(white.data.begin(), white.data.end(), uint8_t{255});
  const double error = std::pow(100, 0.7);
  const double expected = 0.95 + 0.05 * (error - 16.51044) / (41.2761 - 16.51044);
  for (const float v : flip_map(black, white).data) EXPECT_NEAR(v, expected, 2e-5);
  // A small step of grey: L of a code value is 116 (linear)^(1/3) - 16, and 0.95 / 16.51 of its distance^0.7 counts.
  Image8 grey = black;
  Image8 lighter = black;
  std::fill(grey.data.begin(), grey.data.end(), uint8_t{120});
  std::fill(lighter.data.begin(), lighter.data.end(), uint8_t{130});
  const auto lightness = [](int code) { return 116 * std::cbrt(srgb_to_linear(code / 255.0)) - 16; };
  const double step = 0.95 / 16.51044 * std::pow(lightness(130) - lightness(120), 0.7);
  for (const float v : flip_map(grey, lighter).data) EXPECT_NEAR(v, step, 2e-5);
}

TEST(Flip, PooledByHand) {
  ImageF map(5, 1, 1);
  map.data = {0.4F, 0.1F, 0.3F, 0.0F, 0.2F};
  const FlipPooled pooled = flip_pooled(map);
  EXPECT_NEAR(pooled.mean, 0.2, 1e-7);
  // Ascending sums: 0, 0.1, 0.3, 0.6, 1.
  EXPECT_EQ(pooled.q1, 0.2F);
  EXPECT_EQ(pooled.weighted_median, 0.3F);
  EXPECT_EQ(pooled.q3, 0.4F);
  EXPECT_EQ(pooled.min, 0);
  EXPECT_EQ(pooled.max, 0.4F);
  const FlipPooled zero = flip_pooled(ImageF(3, 3, 1));
  EXPECT_EQ(zero.mean + zero.q1 + zero.weighted_median + zero.q3 + zero.min + zero.max, 0);
}

// The drawers by which quantiles are found give what sorting gives.
TEST(Flip, QuantilesAreThoseOfASort) {
  for (uint64_t seed = 1; seed <= 5; ++seed) {
    ImageF map(37, 29, 1);
    for (size_t i = 0; i < map.data.size(); ++i)
      map.data[i] = std::pow(static_cast<float>(random_below(seed, i, 1, 1000)) / 1000, static_cast<float>(seed));
    std::vector<float> sorted = map.data;
    std::sort(sorted.begin(), sorted.end());
    double total = 0;
    for (const float v : sorted) total += v;
    const auto quantile = [&](double q) {
      double sum = 0;
      for (const float v : sorted)
        if ((sum += v) > q * total) return v;
      return sorted.back();
    };
    const FlipPooled pooled = flip_pooled(map);
    EXPECT_EQ(pooled.q1, quantile(0.25)) << seed;
    EXPECT_EQ(pooled.weighted_median, quantile(0.5)) << seed;
    EXPECT_EQ(pooled.q3, quantile(0.75)) << seed;
  }
}

// ---- outside oracle ----

// Mean and quartiles within 2e-4, least and greatest within 1e-3: the contract of the expected values.
void expect_pooled(const FlipPooled& actual, const json& expected, const std::string& what, double tolerance = 2e-4) {
  const auto either = [&](const char* a, const char* b) { return expected.value(a, expected.value(b, -1.0)); };
  EXPECT_NEAR(actual.mean, expected["mean"].get<double>(), tolerance) << what;
  EXPECT_NEAR(actual.weighted_median, expected["weighted_median"].get<double>(), tolerance) << what;
  EXPECT_NEAR(actual.q1, either("q1_weighted", "q1"), tolerance) << what;
  EXPECT_NEAR(actual.q3, either("q3_weighted", "q3"), tolerance) << what;
  EXPECT_NEAR(actual.min, expected["min"].get<double>(), 1e-3) << what;
  EXPECT_NEAR(actual.max, expected["max"].get<double>(), 1e-3) << what;
}

// Returns how many figures were checked: pairs times pixels per degree.
int check_pairs(const fs::path& folder) {
  const json all = expected_of(folder);
  const std::map<std::string, std::array<uint8_t, 3>> colours = {
      {"black", {0, 0, 0}}, {"white", {255, 255, 255}}, {"gray50", {128, 128, 128}}};
  int checked = 0;
  for (const auto& [name, pair] : all["pairs"].items()) {
    const size_t at = name.find("@over_");
    const json& files = at == std::string::npos ? pair : all["pairs"][name.substr(0, at)];
    Image8 reference = picture(folder / files["ref"].get<std::string>());
    Image8 test = picture(folder / files["test"].get<std::string>());
    if (at != std::string::npos) {
      const auto& colour = colours.at(name.substr(at + 6));
      reference = over(reference, colour);
      test = over(test, colour);
    }
    for (const auto& [ppd, expected] : pair["contract"]["flip"].items()) {
      FlipSettings settings;
      if (ppd != "67.0206") settings.pixels_per_degree = std::stod(ppd);
      expect_pooled(flip_pooled(flip_map(reference, test, settings)), expected, name + " at " + ppd);
      ++checked;
    }
  }
  return checked;
}

TEST(FlipGroundTruth, TheBundledPairs) { EXPECT_EQ(check_pairs(kOwn), 3 * 14); }

TEST(FlipGroundTruth, TheWholeSharedSet) {
  if (!fs::exists(kShared)) GTEST_SKIP() << "needs the shared ground-truth folder (a01_tree and others)";
  EXPECT_EQ(check_pairs(kShared), 3 * 22);
}

// Returns how many maps were checked.
int check_maps(const fs::path& folder) {
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
    const Image8 painted = map_picture(*flip->score, *flip->result.map);
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
  EXPECT_EQ(check_maps(kOwn), 1);
  if (fs::exists(kShared)) {
    EXPECT_EQ(check_maps(kShared), 3);
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

// ---- HDR ----

void expect_hdr_of(const ImageF& reference, const ImageF& test, const HdrFlipSettings& settings, const json& expected,
                   const std::string& name) {
  const HdrFlip actual = hdr_flip(reference, test, settings);
  ASSERT_EQ(actual.range.reason, "") << name;
  const auto either = [&](const char* a, const char* b) { return expected.contains(a) ? expected[a] : expected[b]; };
  EXPECT_NEAR(actual.range.start, either("start_exposure", "start").get<double>(), 1e-4) << name;
  EXPECT_NEAR(actual.range.stop, either("stop_exposure", "stop").get<double>(), 1e-4) << name;
  EXPECT_EQ(actual.range.exposures, either("num_exposures", "n").get<int>()) << name;
  expect_pooled(flip_pooled(actual.map), expected, name);
}

void expect_hdr(const std::string& name, const HdrFlipSettings& settings, const json& expected) {
  const json pair = expected_of(kShared)["hdr"][name];
  expect_hdr_of(floats(kShared / pair["ref"].get<std::string>()), floats(kShared / pair["test"].get<std::string>()),
                settings, expected, name);
}

TEST(HdrFlipGroundTruth, EveryToneMapperAndRange) {
  if (!fs::exists(kShared)) GTEST_SKIP() << "needs the shared ground-truth folder";
  const json all = expected_of(kShared)["hdr"];
  const json more = json::parse(read_text(kShared / "flip_stages.json"))["hdr_extra_reference_cli"];
  HdrFlipSettings aces;
  HdrFlipSettings fixed;
  fixed.start = -4;
  fixed.stop = 2;
  fixed.exposures = 7;
  HdrFlipSettings far;
  far.flip.pixels_per_degree = 33.5;
  HdrFlipSettings hable;
  hable.tone_mapper = ToneMapper::hable;
  HdrFlipSettings reinhard;
  reinhard.tone_mapper = ToneMapper::reinhard;
  const std::string h01 = "h01_noise_fireflies";
  const std::string h03 = "h03_half_exposure";
  for (const auto& name : {h01, std::string("h02_identical"), h03})
    expect_hdr(name, aces, all[name]["hdrflip_aces_default"]);
  expect_hdr(h01, fixed, all[h01]["hdrflip_fixed_exposures_-4_to_2_n7"]);
  expect_hdr(h01, far, all[h01]["hdrflip_ppd33.5"]);
  expect_hdr(h01, reinhard, all[h01]["hdrflip_reinhard"]);
  expect_hdr(h01, hable, more[h01]["hable"]);
  expect_hdr(h03, hable, more[h03]["hable"]);
  expect_hdr(h03, reinhard, more[h03]["reinhard"]);
}

// The bundled case: a picture and its half, a stop darker.
TEST(HdrFlipGroundTruth, HalfTheLight) {
  const json pair = expected_of(kOwn)["hdr"]["h03_half_exposure"];
  const ImageF reference = floats(kOwn / pair["ref"].get<std::string>());
  ImageF test = reference;
  for (float& v : test.data) v *= 0.5F;
  for (const auto& [mapper, key] :
       {std::pair(ToneMapper::aces, "hdrflip_aces_default"), std::pair(ToneMapper::hable, "hdrflip_hable"),
        std::pair(ToneMapper::reinhard, "hdrflip_reinhard")}) {
    HdrFlipSettings settings;
    settings.tone_mapper = mapper;
    expect_hdr_of(reference, test, settings, pair[key], key);
  }
}

TEST(HdrFlipGroundTruth, ErrorAndExposureMaps) {
  const fs::path images = kShared / "cvvdp" / "images";
  if (!fs::exists(images)) GTEST_SKIP() << "needs the shared ground-truth folder";
  const ImageF reference = floats(kShared / "hdr" / "h01_noise_fireflies_ref.exr");
  const ImageF test = floats(kShared / "hdr" / "h01_noise_fireflies_test.exr");
  const HdrFlip actual = hdr_flip(reference, test);
  const Image8 grey = picture(images / "flip_hdr_h01_aces_grey.png");
  const Image8 viridis = picture(images / "flip_hdr_h01_aces_exposure_viridis.png");
  size_t beyond = 0;
  size_t other_exposure = 0;
  for (size_t i = 0; i < grey.pixels(); ++i) {
    const int level = static_cast<int>(255 * actual.map.data[i] + 0.5F);
    beyond += std::abs(level - int{grey.data[i * static_cast<size_t>(grey.channels)]}) > 1 ? 1 : 0;
    const auto& colour = viridis_colours()[static_cast<size_t>(255 * actual.exposure.data[i] + 0.5F)];
    other_exposure +=
        std::equal(colour.begin(), colour.end(), &viridis.data[static_cast<size_t>(viridis.channels) * i]) ? 0 : 1;
  }
  EXPECT_LE(beyond, grey.pixels() / 1000);
  // Two exposures of nearly equal error change places by the last bits.
  EXPECT_LE(other_exposure, grey.pixels() / 1000);
}

TEST(HdrFlip, ExposuresByHand) {
  // Luminances 1, 1, 2: the median 1, the greatest 2. Reinhard's curve is 0.85 at 17/3.
  ImageF image(3, 1, 1);
  image.data = {1, 2, 1};
  HdrFlipSettings settings;
  settings.tone_mapper = ToneMapper::reinhard;
  const ExposureRange range = exposure_range(image, settings);
  EXPECT_NEAR(range.start, std::log2(17.0 / 3 / 2), 1e-12);
  EXPECT_NEAR(range.stop, std::log2(17.0 / 3), 1e-12);
  EXPECT_EQ(range.exposures, 2) << "a stop apart, two at least";
  EXPECT_NEAR(range.at(1), range.stop, 1e-12);
  settings.start = -3;
  EXPECT_EQ(exposure_range(image, settings).exposures, static_cast<int>(std::ceil(std::log2(17.0 / 3) + 3)));
  settings.exposures = 4;
  EXPECT_EQ(exposure_range(image, settings).exposures, 4);
  settings.start = 9;
  EXPECT_NE(exposure_range(image, settings).reason.find("start above"), std::string::npos);
}

TEST(HdrFlip, WhatHasNoValueSaysWhy) {
  ImageF black(6, 6, 3);
  ImageF lit = black;
  for (size_t i = 0; i < 3 * 10; ++i) lit.data[i] = 2;  // ten of 36 pixels: the median is 0
  EXPECT_NE(hdr_flip(lit, black).range.reason.find("median luminance is 0"), std::string::npos);
  EXPECT_NE(hdr_flip(black, lit).range.reason.find("black"), std::string::npos);
  HdrFlipSettings settings;
  settings.start = -2;
  settings.stop = 2;
  EXPECT_EQ(hdr_flip(lit, black, settings).range.reason, "") << "exposures that are given need no median";
  EXPECT_THROW(hdr_flip(lit, ImageF(6, 5, 3)), Error);
}

TEST(HdrFlip, HugeValuesDoNotOverflow) {
  ImageF a(8, 8, 3);
  std::fill(a.data.begin(), a.data.end(), 1e-3F);
  ImageF b = a;
  b.data[0] = std::numeric_limits<float>::max();
  const HdrFlip errors = hdr_flip(b, a);
  for (const float v : errors.map.data) {
    EXPECT_GE(v, 0);
    EXPECT_LE(v, 1);
  }
}

// ---- not a number, infinite ----

TEST(NotFinite, AreCountedAndPlacedAndNeverBecomeAScore) {
  ImageF clean(8, 5, 4);
  std::fill(clean.data.begin(), clean.data.end(), 0.5F);
  ImageF broken = clean;
  broken.at(3, 1)[1] = std::numeric_limits<float>::infinity();
  broken.at(6, 1)[0] = std::numeric_limits<float>::quiet_NaN();
  broken.at(6, 1)[2] = std::numeric_limits<float>::infinity();
  broken.at(2, 4)[2] = std::numeric_limits<float>::quiet_NaN();
  broken.at(0, 0)[3] = std::numeric_limits<float>::quiet_NaN();  // alpha
  const NotFinite found = not_finite(broken);
  EXPECT_EQ(found.nan, 2U);
  EXPECT_EQ(found.infinite, 1U);
  EXPECT_EQ(found.x, 3);
  EXPECT_EQ(found.y, 1);
  EXPECT_EQ(not_finite(clean).pixels(), 0U);
  const std::string text = "the test has 2 pixels that are not a number and 1 infinite, the first at (3, 1)";
  EXPECT_EQ(not_finite_text({}, found), text);
  EXPECT_EQ(
      not_finite_text({1, 0, 2, 3}, {0, 1, 4, 5}),
      "the reference has 1 pixel that is not a number, the first at (2, 3); the test has 1 pixel that is infinite, "
      "the first at (4, 5)");
  ScoreInput input;
  input.reference.linear = &clean;
  input.test.linear = &broken;
  Shared shared;
  const auto scored = score_pictures(scores(), input, shared);
  EXPECT_GE(scored.size(), 3U);
  for (const Scored& one : scored) {
    EXPECT_FALSE(one.result.value) << one.score->name;
    EXPECT_EQ(one.result.reason, text) << one.score->name;
  }
}

// An empty pixel of a depth picture is infinitely far in both: no error. Only HDR-FLIP, which looks at colours,
// refuses.
TEST(NotFinite, InfinityInBothIsNoDifference) {
  ImageF depth(4, 4, 1);
  std::fill(depth.data.begin(), depth.data.end(), std::numeric_limits<float>::infinity());
  *depth.at(1, 1) = 5;
  ImageF other = depth;
  *other.at(1, 1) = 6;
  ScoreInput input;
  input.reference.linear = &depth;
  input.test.linear = &other;
  Shared shared;
  for (const Scored& one : score_pictures(scores(), input, shared)) {
    if (one.score->name == "linear_mae") {
      EXPECT_EQ(one.result.value, 1.0 / 16);
    } else if (one.score->name == "hdr_flip") {
      EXPECT_FALSE(one.result.value);
      EXPECT_NE(one.result.reason.find("15 pixels that are infinite"), std::string::npos);
    }
  }
}

// ---- the scores ----

TEST(FlipScore, IsPooledAndOfTheDisplayAndOfAgents) {
  const Image8 a = noise(40, 30, 1);
  Image8 b = a;
  for (int y = 10; y < 20; ++y)
    for (int x = 5; x < 15; ++x) b.at(x, y)[1] = static_cast<uint8_t>(255 - b.at(x, y)[1]);
  ScoreInput input;
  input.reference.codes = &a;
  input.test.codes = &b;
  const auto flip_of = [](const ScoreInput& of, Shared& shared) {
    for (const Scored& one : score_pictures(scores(), of, shared))
      if (one.score->name == "flip") return one;
    return Scored{};
  };
  Shared shared;
  const Scored at_default = flip_of(input, shared);
  ASSERT_TRUE(at_default.score);
  std::vector<std::string> names;
  for (const auto& [name, value] : at_default.result.pooled) names.push_back(name);
  EXPECT_EQ(names, (std::vector<std::string>{"mean", "weighted_median", "q1", "q3", "min", "max"}));
  EXPECT_EQ(at_default.result.value, flip_pooled(flip_map(a, b)).mean);
  Display display;
  display.pixels_per_degree = 20;
  input.display = &display;
  Shared near;
  EXPECT_EQ(flip_of(input, near).result.value, flip_pooled(flip_map(a, b, {20, 0})).mean);
  display.pixels_per_degree = 0.5;
  Shared none;
  EXPECT_NE(flip_of(input, none).result.reason.find("less than one pixel"), std::string::npos);
  input.display = nullptr;
  const AgentPixels inside{1, {{7, 12}, {8, 12}}};
  const AgentPixels outside{2, {{38, 28}}};
  const ImageF map = flip_map(a, b);
  EXPECT_NEAR(at_default.score->by_agent(input, shared, inside).value(), (*map.at(7, 12) + *map.at(8, 12)) / 2.0, 1e-7);
  EXPECT_EQ(at_default.score->by_agent(input, shared, outside), 0);
}

TEST(FlipScore, MapsInEveryColour) {
  const Image8 a = noise(40, 30, 1);
  const Image8 b = noise(40, 30, 2);
  ScoreInput input;
  input.reference.codes = &a;
  input.test.codes = &b;
  input.maps = true;
  Shared shared;
  for (const Scored& one : score_pictures(scores(), input, shared)) {
    if (!one.result.map) continue;
    SCOPED_TRACE(one.score->name);
    const Image8 error = map_picture(*one.score, *one.result.map, MapColours::error);
    const Image8 magma = map_picture(*one.score, *one.result.map, MapColours::magma);
    const Image8 viridis = map_picture(*one.score, *one.result.map, MapColours::viridis);
    for (const Image8* picture : {&error, &magma, &viridis}) {
      EXPECT_EQ(picture->channels, 3);
      EXPECT_EQ(picture->height, error.height);
      EXPECT_GT(picture->height, one.result.map->values.height + 50) << "the colour bar";
    }
    EXPECT_NE(magma, error);
    EXPECT_NE(viridis, magma);
  }
}

// Every step of a uniform table is lighter than the one before, in CIE lightness.
TEST(ColourTables, GetLighterAllTheWay) {
  for (const ColourTable* table : {&magma_colours(), &viridis_colours()}) {
    double before = -1;
    for (const auto& [r, g, b] : *table) {
      const double y =
          0.2126 * srgb_to_linear(r / 255.0) + 0.7152 * srgb_to_linear(g / 255.0) + 0.0722 * srgb_to_linear(b / 255.0);
      EXPECT_GT(std::cbrt(y), before - 2e-3);
      before = std::cbrt(y);
    }
  }
}

}  // namespace
}  // namespace crowdbench::metrics
