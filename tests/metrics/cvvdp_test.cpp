// ColorVideoVDP: identity, by hand, and against the scores of its authors' program (tests/data/ground-truth/cvvdp).
#include "metrics/cvvdp/cvvdp.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "core/error.h"
#include "core/random.h"
#include "metrics/registry.h"
#include "tests/metrics/cvvdp_cases.h"
#include "tests/support/sanitized.h"

namespace crowdbench::metrics {
namespace {

using nlohmann::json;

Image8 noise(int width, int height, uint64_t seed, int channels = 3) {
  Image8 out(width, height, channels);
  for (size_t i = 0; i < out.data.size(); ++i) out.data[i] = static_cast<uint8_t>(random_below(seed, i, 1, 256));
  return out;
}

Image8 flat(int width, int height, uint8_t value) {
  Image8 out(width, height, 3);
  std::fill(out.data.begin(), out.data.end(), value);
  return out;
}

double largest(const CvvdpResult& result) {
  double most = 0;
  for (const auto& frame : result.by_frame)
    for (const auto& channel : frame)
      for (const double q : channel) most = std::max(most, q);
  return most;
}

TEST(Cvvdp, EqualPicturesAndClipsScoreExactlyTen) {
  for (const auto& [width, height] : {std::pair{2, 2}, {3, 2}, {5, 9}, {16, 200}, {97, 64}}) {
    const Image8 a = noise(width, height, 1);
    CvvdpOptions options;
    options.fps = 30;
    size_t maps = 0;
    options.map = [&](size_t, CvvdpMap&& map) {
      ++maps;
      EXPECT_EQ(map.q, 0);
      for (const float v : map.jod.data) ASSERT_EQ(v, 10.0F);
    };
    const CvvdpResult still = cvvdp(a, a, default_display(), options);
    EXPECT_EQ(still.jod, 10);
    EXPECT_EQ(largest(still), 0);
    EXPECT_TRUE(still.still);
    EXPECT_EQ(still.channel_q, std::vector<double>(3, 0));
    Cvvdp clip(default_display(), options);
    for (uint64_t f = 0; f < 4; ++f) clip.take(noise(width, height, f), noise(width, height, f));
    const CvvdpResult moving = clip.finish();
    EXPECT_EQ(moving.jod, 10);
    EXPECT_EQ(largest(moving), 0);
    EXPECT_FALSE(moving.still);
    EXPECT_EQ(moving.channel_q, std::vector<double>(4, 0));
    EXPECT_EQ(maps, 5U);
  }
}

// Two conventions of rounding: the expected values of ColorVideoVDP are of pictures composited to the nearest code
// value, those of all other scores of ImageMagick's, rounded down.
TEST(Cvvdp, CompositedPicturesMeetTheirExpectedValuesByTheirRounding) {
  const CvvdpCases cases;
  size_t seen = 0;
  for (const auto& [key, expected] : cases.all().items()) {
    const size_t at = key.find("@over_");
    if (at == std::string::npos) continue;
    const auto nearest = cases.load(key);
    const auto reference = ground_truth_picture("images/" + key.substr(0, at) + "_ref.png");
    const auto test = ground_truth_picture("images/" + key.substr(0, at) + "_test.png");
    if (!nearest || !reference || !test) continue;
    ++seen;
    const double jod = expected["jod"].get<double>();
    const std::string colour = key.substr(at + 6, key.find('@', at + 1) - at - 6);
    const uint8_t v = colour == "black" ? 0 : colour == "white" ? 255 : 128;
    const auto jod_of = [&](OverRounding rounding) {
      return cvvdp(over(std::get<Image8>(*reference), {v, v, v}, rounding),
                   over(std::get<Image8>(*test), {v, v, v}, rounding), nearest->display)
          .jod;
    };
    EXPECT_NEAR(jod_of(OverRounding::nearest), jod, 1e-4) << key;
    EXPECT_NEAR(jod_of(OverRounding::down), jod, 9.1e-4) << key;
  }
  EXPECT_EQ(seen, 4U);
}

// The base band is divided by its own mean, and no other band sees a constant. Pooled powers make 1e-3 of rounding.
TEST(Cvvdp, AUniformChangeOfLuminanceHasNoEffect) {
  for (const int grey : {0, 64, 129, 255})
    EXPECT_NEAR(cvvdp(flat(64, 48, 128), flat(64, 48, static_cast<uint8_t>(grey)), default_display()).jod, 10, 1e-5);
  Image8 red = flat(64, 48, 128);
  for (size_t i = 0; i < red.data.size(); i += 3) red.data[i] = 160;
  EXPECT_LT(cvvdp(flat(64, 48, 128), red, default_display()).jod, 9.99) << "a uniform change of colour has one";
}

// All of it worked by hand. Of 2 x 2 pixels the pyramid keeps the base band alone, which has no masking and no gain; on
// a display of linear light in a dark room a value is its cd/m2. The reference is grey and its A (close to luminance)
// 100.
//
// From R, G, B to A, RG, YV (LMS of 2006 in DKL of D65, of BT.709's primaries; each row's sum is of R = G = B = 1):
//   A    0.2332012  0.7288308  0.0889959    1.0510279
//   RG   0.1276208 -0.0870681 -0.0367774    0.0037753
//   YV  -0.2148225 -0.6262537  0.8514033    0.0103271
// so that the grey is 100 / 1.0510279 = 95.14496 in R, G, B, its RG 0.3592001, its YV 0.9825740. Each picture is
// divided by its own mean A: the grey's contrasts are 1, 0.003592001, 0.009825740. At 0.1 cycles per degree and 100
// cd/m2 the reference program's sensitivities are 14.53437, 183.0639, 37.41817.
//
// Every power P(x, p) is (x + e)^p - e^p with e = 1e-5: a root of what is not small takes e^(1/2) = 0.0031623 or
// e^(1/4) = 0.0562341 off, a square or a fourth power next to nothing.
//
// A uniform red more, 10 cd/m2: A 102.332012, RG 1.635408, YV -1.165651. Contrasts 1, 0.01598139, -0.01139087.
//   D                           0, 0.01238939 * 183.0639 = 2.268050, 0.02121661 * 37.41817 = 0.7938869, in every pixel
//   Q, root of mean square      0, 2.264900, 0.7907409
//   * weight of the base band   0, 1.662772 * 2.264900 = 3.766013, 4.118745 * 0.7907409 = 3.256860
//   root over bands             0, 3.709789, 3.200636
//   root over channels          (189.4094 + 104.9423)^(1/4) - 0.0562341 = 4.085828
//   * weight of stills          0.5779183 * 4.085828 = 2.361275
//   JOD                         10 - 0.04395694 * 2.361275^0.9302043 = 10 - 0.0977530 = 9.9022470
// Two pixels lighter and two darker by a fifth: A 120, 120, 80, 80, RG and YV by a fifth too, the mean A unchanged.
//   D                           0.2 * 14.53437 = 2.906874, 0.2 * 0.003592001 * 183.0639 = 0.1315131, 0.0735322
//   Q                           2.903723, 0.1283989, 0.0704479
//   * weight of the base band   0.0105505, 0.2134981, 0.2901570
//   root over bands             1.7e-5, 0.1575304, 0.2340352
//   root over channels          (6.2e-4 + 3.0005e-3)^(1/4) - 0.0562341 = 0.1891647
//   * weight of stills, JOD     0.1093217; 10 - 0.0056083 = 9.9943917
TEST(Cvvdp, FourPixelsByHand) {
  constexpr double kRows[3][3] = {{0.2332012107, 0.728830789, 0.08899586934},
                                  {0.1276207712, -0.08706808759, -0.03677739062},
                                  {-0.2148225086, -0.6262536922, 0.851403327}};
  constexpr double kSensitivity[3] = {14.53437, 183.0639, 37.41817};
  constexpr double kBase[3] = {0.0036334486, 1.6627724, 4.1187453};
  const auto power = [](double x, double p) { return std::pow(x + 1e-5, p) - std::pow(1e-5, p); };
  const Display display = find_display("standard_hdr_linear_dark", "");
  using Pixels = std::array<std::array<double, 3>, 4>;
  // Q before the weight of stills.
  const auto by_hand = [&](const Pixels& reference, const Pixels& test) {
    double contrast[2][3][4];
    for (int p = 0; p < 2; ++p) {
      const Pixels& picture = p == 0 ? reference : test;
      double mean = 0;
      for (size_t i = 0; i < 4; ++i)
        for (size_t c = 0; c < 3; ++c) {
          contrast[p][c][i] = kRows[c][0] * picture[i][0] + kRows[c][1] * picture[i][1] + kRows[c][2] * picture[i][2];
          mean += c == 0 ? contrast[p][c][i] / 4 : 0;
        }
      for (auto& channel : contrast[p])
        for (double& v : channel) v /= mean;
    }
    double sum = 0;
    for (size_t c = 0; c < 3; ++c) {
      double squares = 0;
      for (size_t i = 0; i < 4; ++i)
        squares += power(std::fabs(contrast[0][c][i] - contrast[1][c][i]) * kSensitivity[c], 2) / 4;
      const double band = power(power(kBase[c] * power(squares, 0.5), 4), 0.25);  // over bands: there is one
      sum += power(band, 4);
    }
    return power(sum, 0.25);
  };
  const auto floats = [](const Pixels& pixels) {
    ImageF out(2, 2, 3);
    for (size_t i = 0; i < 12; ++i) out.data[i] = static_cast<float>(pixels[i / 3][i % 3]);
    return out;
  };
  const auto jod = [](double q) { return 10 - 0.0439569391 * std::pow(q, 0.9302042723); };  // above 0.1

  constexpr double kGrey = 100 / 1.0510278691;
  Pixels grey{};
  for (auto& pixel : grey) pixel = {kGrey, kGrey, kGrey};
  Pixels red = grey;
  for (auto& pixel : red) pixel[0] += 10;
  Pixels blocks = grey;
  for (size_t i = 0; i < 4; ++i)
    for (double& v : blocks[i]) v *= i < 2 ? 1.2 : 0.8;
  EXPECT_NEAR(by_hand(grey, red), 4.085828, 1e-5) << "the arithmetic above";
  EXPECT_NEAR(cvvdp(floats(grey), floats(red), display).jod, 9.9022470, 1e-5) << "the arithmetic above";
  EXPECT_NEAR(cvvdp(floats(grey), floats(blocks), display).jod, 9.9943917, 1e-5) << "the arithmetic above";
  for (const Pixels& test : {red, blocks}) {
    const double q = by_hand(grey, test);
    const CvvdpResult still = cvvdp(floats(grey), floats(test), display);
    EXPECT_NEAR(still.q, 0.5779182911 * q, 1e-5 * q);
    EXPECT_NEAR(still.jod, jod(0.5779182911 * q), 1e-6);
    // Frames that do not change: the filters' taps over time add up to 1 and the transient channel sees nothing. What
    // is left out is the weight of stills.
    Cvvdp clip(display, {.fps = 30});
    for (int f = 0; f < 3; ++f) clip.take(floats(grey), floats(test));
    const double of_clip = power(power(q, 2), 0.5);  // over frames, which are alike
    EXPECT_NEAR(clip.finish().jod, jod(of_clip), 2e-6);
  }
}

TEST(Cvvdp, ALargerDifferenceAndALargerPixelAreSeenMoreEasily) {
  const Image8 reference = noise(64, 64, 1);
  Image8 little = reference;
  Image8 more = reference;
  for (size_t i = 0; i < little.data.size(); ++i) {
    little.data[i] = static_cast<uint8_t>(std::min(reference.data[i] + i % 7, size_t{255}));
    more.data[i] = static_cast<uint8_t>(std::min(reference.data[i] + i % 7 * 4, size_t{255}));
  }
  const double jod = cvvdp(reference, little, default_display()).jod;
  EXPECT_LT(jod, 10);
  EXPECT_LT(cvvdp(reference, more, default_display()).jod, jod);
  EXPECT_LT(cvvdp(reference, little, find_display("standard_fhd", "")).jod, jod);
}

TEST(Cvvdp, GreyAlphaAndSixteenBitsAreTheSamePicture) {
  const Image8 grey = noise(40, 30, 1, 1);
  Image8 rgb(40, 30, 3);
  Image8 rgba(40, 30, 4);
  for (size_t i = 0; i < grey.data.size(); ++i) {
    std::fill_n(rgb.data.begin() + static_cast<ptrdiff_t>(3 * i), 3, grey.data[i]);
    std::fill_n(rgba.data.begin() + static_cast<ptrdiff_t>(4 * i), 3, grey.data[i]);
    rgba.data[4 * i + 3] = static_cast<uint8_t>(i);
  }
  const Image8 other = noise(40, 30, 2);
  const double jod = cvvdp(rgb, other, default_display()).jod;
  EXPECT_EQ(cvvdp(grey, other, default_display()).jod, jod);
  EXPECT_EQ(cvvdp(rgba, other, default_display()).jod, jod);
  EXPECT_EQ(cvvdp(widen(rgb), widen(other), default_display()).jod, jod);
  ImageF floats(40, 30, 3);
  ImageF other_floats(40, 30, 3);
  for (size_t i = 0; i < floats.data.size(); ++i) {
    floats.data[i] = static_cast<float>(rgb.data[i]) / 255;
    other_floats.data[i] = static_cast<float>(other.data[i]) / 255;
  }
  EXPECT_NEAR(cvvdp(floats, other_floats, default_display()).jod, jod, 1e-5) << "encoded values of 0..1";
}

TEST(Cvvdp, TheBitsDoNotDependOnTheNumberOfThreads) {
  const auto run = [](unsigned threads, int frames) {
    CvvdpOptions options;
    options.threads = threads;
    options.fps = 25;
    std::vector<float> maps;
    options.map = [&](size_t, CvvdpMap&& map) { maps.insert(maps.end(), map.jod.data.begin(), map.jod.data.end()); };
    Cvvdp metric(find_display("standard_fhd", ""), options);
    for (int f = 0; f < frames; ++f) {
      const auto seed = static_cast<uint64_t>(f);
      metric.take(noise(331, 402, seed), noise(331, 402, 2 * seed + 1));
    }
    return std::pair{metric.finish(), maps};
  };
  for (const int frames : {1, 3}) {
    const auto [one, map] = run(1, frames);
    EXPECT_LT(one.jod, 10);
    for (const unsigned threads : {2U, 5U}) {
      const auto [other, other_map] = run(threads, frames);
      EXPECT_EQ(other.jod, one.jod) << threads;
      EXPECT_EQ(other.by_frame, one.by_frame) << threads;
      EXPECT_EQ(other_map, map) << threads;
    }
  }
}

TEST(Cvvdp, Refusals) {
  const auto refusal = [](const auto& work) {
    try {
      work();
    } catch (const Error& e) {
      return std::string(e.what());
    }
    return std::string("accepted");
  };
  const auto contains = [](const std::string& text, const char* part) { return text.find(part) != std::string::npos; };
  const Image8 a = noise(8, 8, 1);
  for (const auto& size : {std::pair{1, 1}, {1, 9}, {9, 1}}) {
    const auto picture = [&](uint64_t seed) { return noise(size.first, size.second, seed); };
    const std::string said = refusal([&] { cvvdp(picture(1), picture(2), default_display()); });
    EXPECT_TRUE(contains(said, "a side is below 2 pixels")) << said;
  }
  EXPECT_TRUE(contains(refusal([&] { cvvdp(a, noise(8, 9, 1), default_display()); }), "differ in size"));
  EXPECT_TRUE(contains(refusal([&] {
                         Cvvdp clip(default_display());
                         clip.take(a, a);
                         clip.take(a, a);
                       }),
                       "without its frame rate"));
  EXPECT_TRUE(contains(refusal([&] {
                         Cvvdp clip(default_display(), {.fps = 30});
                         clip.take(a, a);
                         clip.take(noise(9, 8, 1), noise(9, 8, 1));
                       }),
                       "frame 1 is 9 x 8"));
  EXPECT_TRUE(contains(refusal([&] { Cvvdp(default_display()).finish(); }), "no picture"));
  ImageF bad(8, 8, 3);
  bad.at(3, 2)[1] = std::numeric_limits<float>::quiet_NaN();
  bad.at(4, 5)[0] = std::numeric_limits<float>::infinity();
  const Display linear = find_display("standard_hdr_linear", "");
  const std::string said = refusal([&] { cvvdp(ImageF(8, 8, 3), bad, linear); });
  EXPECT_TRUE(contains(said, "the test has 1 pixel that is not a number and 1 infinite, the first at (3, 2)")) << said;
}

// Every case of the reference whose pictures are here. The reference's numbers have six decimals.
TEST(CvvdpGroundTruth, EveryScoreWithin1e4Jod) {
  constexpr double kTolerance = 1e-4;
  const CvvdpCases cases;
  size_t checked = 0;
  std::string missing;
  for (const auto& [key, expected] : cases.all().items()) {
    // The reference copies a one-channel picture into all three planes; here it is grey.
    if (key.starts_with("grey1_one_channel_path")) continue;
    // Large, and no other code than the smaller ones run.
    if (support::kSanitized &&
        (key.starts_with("a01") || key.starts_with("p14_tiled") || key.starts_with("sequence_x4")))
      continue;
    const auto one = cases.load(key);
    if (!one) {
      missing += (missing.empty() ? "" : ", ") + key;
      continue;
    }
    ++checked;
    if (expected["jod"].is_null()) {
      EXPECT_THROW(score(*one), Error) << key;
      continue;
    }
    const CvvdpResult result = score(*one);
    EXPECT_NEAR(result.jod, expected["jod"].get<double>(), kTolerance) << key;
    ASSERT_EQ(result.by_frame.size(), expected["frames"].get<size_t>()) << key;
    EXPECT_EQ(result.frequencies.size(), expected["rho_band"].size()) << key;
    for (size_t b = 0; b < result.frequencies.size(); ++b)
      EXPECT_NEAR(result.frequencies[b] / expected["rho_band"][b].get<double>(), 1, 1e-6) << key;
    if (!expected.contains("Q")) continue;
    for (size_t f = 0; f < result.by_frame.size(); ++f)
      for (size_t c = 0; c < result.by_frame[f].size(); ++c)
        for (size_t b = 0; b < result.frequencies.size(); ++b) {
          const double q = expected["Q"][c][f][b].get<double>();
          EXPECT_NEAR(result.by_frame[f][c][b], q, 1e-4 * q + 1e-4) << key << " frame " << f << " band " << b;
        }
  }
  EXPECT_GE(checked, 100U);
  RecordProperty("missing", missing);
  if (!missing.empty()) std::printf("not here, not tested: %s\n", missing.c_str());
}

TEST(CvvdpGroundTruth, HeatMaps) {
  const CvvdpCases cases;
  const json maps = cvvdp_json("units.json")["heatmap"];
  size_t checked = 0;
  for (const auto& [key, expected] : maps.items()) {
    if (key == "note") continue;
    auto one = cases.load(key);
    ASSERT_TRUE(one) << key;
    ImageF jod;
    one->options.map = [&](size_t, CvvdpMap&& map) { jod = std::move(map.jod); };
    score(*one);
    const json rows = expected.value("map", json());
    // The reference's values are 1 - JOD / 10, kept in half precision and written with four digits.
    const auto compare = [&, name = key](int x, int y, double value) {
      EXPECT_NEAR(1 - *jod.at(x, y) / 10, value, 1e-3 * value + 2e-6) << name << " at " << x << ", " << y;
      ++checked;
    };
    for (int y = 0; rows.is_array() && y < jod.height; ++y)
      for (int x = 0; x < jod.width; ++x)
        compare(x, y, rows[static_cast<size_t>(y)][static_cast<size_t>(x)].get<double>());
    const json& samples = expected["stats"]["samples"];
    const int w = jod.width;
    const int h = jod.height;
    const std::array<std::pair<int, int>, 6> places = {
        {{0, 0}, {w - 1, 0}, {0, h - 1}, {w - 1, h - 1}, {w / 2, h / 2}, {w / 4, h / 3}}};
    for (size_t i = 0; i < places.size(); ++i) compare(places[i].first, places[i].second, samples[i].get<double>());
  }
  EXPECT_GT(checked, 33U * 47U);
}

// The score of the table.
class CvvdpScore : public testing::Test {
 protected:
  CvvdpScore() {
    input_.reference.codes = &reference_;
    input_.test.codes = &test_;
    input_.display = &default_display();
  }
  static const Score& score() {
    const auto found =
        std::find_if(scores().begin(), scores().end(), [](const Score* s) { return s->name == "cvvdp"; });
    return **found;
  }
  ScoreResult computed() {
    Shared shared;
    return score().compute(input_, shared);
  }

  Image8 reference_ = noise(48, 40, 1);
  Image8 test_ = noise(48, 40, 2);
  ScoreInput input_;
};

TEST_F(CvvdpScore, OfPicturesSaysWhatItIsMadeOf) {
  const ScoreResult result = computed();
  const CvvdpResult direct = cvvdp(reference_, test_, default_display());
  EXPECT_EQ(result.value, direct.jod);
  EXPECT_FALSE(result.map) << "not asked for";
  ASSERT_EQ(result.details.size(), 4U);
  EXPECT_EQ(result.details[0].name, "q");
  EXPECT_EQ(result.details[0].value, direct.q);
  EXPECT_EQ(result.details[2].name, "q_red_green");
  // A part is at most the whole, which the source's powers lower by 1e-5^(1/4) once more.
  for (size_t i = 1; i < 4; ++i) EXPECT_LE(result.details[i].value, direct.q + 0.06);
  input_.maps = true;
  EXPECT_EQ(computed().map->values.width, 48);
}

TEST_F(CvvdpScore, OfAnAgentIsTheMapOverItsPixels) {
  test_ = reference_;
  for (int y = 8; y < 16; ++y)
    for (int x = 8; x < 16; ++x) test_.at(x, y)[0] ^= 0x80;
  ImageU32 ids(48, 40, 1);
  input_.reference.ids = input_.test.ids = &ids;
  AgentPixels changed;
  AgentPixels far;
  for (int i = 0; i < 8; ++i) {
    changed.pixels.emplace_back(8 + i, 12);
    far.pixels.emplace_back(40 + i, 39);
  }
  Shared shared;
  const double value = score().by_agent(input_, shared, changed).value();
  EXPECT_LT(value, score().by_agent(input_, shared, far).value());
  input_.maps = true;
  EXPECT_EQ(value, mean_over(computed().map->values, 0, 0, changed));
}

TEST_F(CvvdpScore, OfAClipIsThatOfTheFramesShown) {
  const auto run = [&](double fps) {
    const FrameScore clip = score().over_time();
    for (uint64_t f = 0; f < 4; ++f) {
      test_ = f == 2 ? noise(48, 40, 9) : reference_;
      input_.fps = fps;
      input_.maps = true;
      Shared shared;
      clip.take(input_, shared);
    }
    EXPECT_EQ(clip.finish().value, clip.finish().value);
    return clip.finish();
  };
  const ScoreResult result = run(30);
  Cvvdp direct(default_display(), {.fps = 30});
  for (uint64_t f = 0; f < 4; ++f) direct.take(reference_, f == 2 ? noise(48, 40, 9) : reference_);
  const CvvdpResult expected = direct.finish();
  EXPECT_EQ(result.value, expected.jod);
  ASSERT_EQ(result.by_frame.size(), 4U);
  for (size_t f = 0; f < 4; ++f) EXPECT_EQ(result.by_frame[f], cvvdp_jod(expected.frame_q[f]));
  EXPECT_GT(result.by_frame[0], result.by_frame[2]) << "nothing has happened yet";
  EXPECT_EQ(result.details.back().name, "q_transient");
  EXPECT_TRUE(result.map);
  EXPECT_EQ(run(0).reason, "the frame rate is not given");
}

TEST_F(CvvdpScore, WhatCannotBeScoredHasItsReason) {
  const Image8 tiny = noise(1, 1, 1);
  input_.reference.codes = input_.test.codes = &tiny;
  EXPECT_EQ(computed().reason, "a side is below 2 pixels");
  input_.reference.codes = nullptr;
  EXPECT_NE(computed().reason.find("neither code values nor floats"), std::string::npos);
  ImageF light(8, 8, 3);
  input_.reference.linear = input_.test.linear = &light;
  EXPECT_NE(computed().reason.find("linear colour space"), std::string::npos);
  const Display linear = find_display("standard_hdr_linear", "");
  input_.display = &linear;
  EXPECT_EQ(computed().value, 10);
  light.data[4] = std::numeric_limits<float>::quiet_NaN();
  EXPECT_NE(computed().reason.find("1 pixel that is not a number, the first at (1, 0)"), std::string::npos)
      << computed().reason;
  const FrameScore clip = score().over_time();
  Shared shared;
  clip.take(input_, shared);
  EXPECT_NE(clip.finish().reason.find("frame 0: the reference has 1 pixel"), std::string::npos);
}

}  // namespace
}  // namespace crowdbench::metrics
