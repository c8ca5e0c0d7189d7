// What ColorVideoVDP is made of, part by part: by hand, and against the reference's own intermediate results.
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <tuple>

#include "metrics/cvvdp/fast_math.h"
#include "metrics/cvvdp/pooling.h"
#include "metrics/cvvdp/temporal_filter.h"
#include "metrics/cvvdp/window.h"
#include "tests/metrics/cvvdp_cases.h"

namespace crowdbench::metrics::vdp {
namespace {

using nlohmann::json;

const json& units() {
  static const json all = cvvdp_json("units.json")["units"];
  return all;
}

FloatPlane plane_of(const json& rows) {
  FloatPlane out;
  out.resize(static_cast<int>(rows[0].size()), static_cast<int>(rows.size()));
  for (int y = 0; y < out.height; ++y)
    for (int x = 0; x < out.width; ++x)
      out.row(y)[x] = rows[static_cast<size_t>(y)][static_cast<size_t>(x)].get<float>();
  return out;
}

FloatPlane reduced(const FloatPlane& in) {
  FloatPlane out;
  out.resize((in.width + 1) / 2, (in.height + 1) / 2);
  reduce_rows(in, out, 0, out.height);
  return out;
}

TEST(CvvdpParts, FastPowersAreAsExactAsTheySay) {
  double log_error = 0;
  double log_units = 0;
  double exp_error = 0;
  for (int i = -1200; i <= 1200; ++i) {
    const float x = std::exp2(static_cast<float>(i) / 20);
    const double exact = std::log2(static_cast<double>(x));
    const double error = std::fabs(fast_log2(x) - exact);
    if (std::fabs(exact) <= 1)
      log_error = std::max(log_error, error);
    else
      log_units = std::max(log_units, error / (std::exp2(std::floor(std::log2(std::fabs(exact)))) * 0x1p-23));
    const float y = static_cast<float>(i) / 10 + 0.013F;
    if (y >= -126 && y <= 127)
      exp_error = std::max(exp_error, std::fabs(fast_exp2(y) / std::exp2(static_cast<double>(y)) - 1));
  }
  EXPECT_LT(log_error, 1.5e-7);
  EXPECT_LT(log_units, 1.0);
  EXPECT_LT(exp_error, 2.5e-7);
  EXPECT_NEAR(fast_pow(9, 0.5F), 3, 1e-6);
}

TEST(CvvdpParts, PowersAreZeroAtZero) {
  EXPECT_EQ(power(0, 0.25), 0);
  EXPECT_NEAR(power(3, 2), 9 + 6e-5, 1e-12);
}

TEST(CvvdpParts, TemporalTapsByHand) {
  // 8 frames a second: three taps, from the gains at 0 and 4 Hz: (H0 + 2 H1 cos(2 pi t / 3)) / 3.
  const auto taps = temporal_taps(8);
  ASSERT_EQ(taps[1].size(), 3U);
  const double h1 = std::exp(-std::pow(4, kTemporalBeta[1]) / kTemporalSigma[1]);
  EXPECT_NEAR(taps[1][1], (1 + 2 * h1) / 3, 1e-15);
  EXPECT_NEAR(taps[1][0], (1 - h1) / 3, 1e-15);
  EXPECT_NEAR(taps[1][2], taps[1][0], 1e-15);
  // What stands still passes the sustained channels whole.
  const auto fast = temporal_taps(60);
  for (size_t c = 0; c < kStillChannels; ++c) {
    double sum = 0;
    for (const double tap : fast[c]) sum += tap;
    EXPECT_NEAR(sum, 1, 1e-12);
  }
}

TEST(CvvdpParts, TemporalTapsOfTheReference) {
  constexpr std::array<const char*, kChannels> kNames = {"A_sust", "RG", "YV", "A_trans"};
  size_t checked = 0;
  for (const auto& [fps, expected] : units()["temporal_filters"].items()) {
    const auto taps = temporal_taps(std::stod(fps));
    ASSERT_EQ(taps[0].size(), expected["length"].get<size_t>()) << fps;
    for (size_t c = 0; c < kChannels; ++c)
      for (size_t t = 0; t < taps[c].size(); ++t, ++checked)
        EXPECT_NEAR(taps[c][t], expected["taps"][kNames[c]][t].get<double>(), 5e-7) << fps;  // single precision
  }
  EXPECT_GT(checked, 400U);
}

TEST(CvvdpParts, FramesBeforeTheFirst) {
  std::vector<size_t> mirrored;
  for (int64_t i = 2; i >= -7; --i) {
    mirrored.push_back(padded_frame(i, 4, Padding::symmetric));
    EXPECT_EQ(padded_frame(i, 4, Padding::replicate), i > 0 ? static_cast<size_t>(i) : 0U);
  }
  EXPECT_EQ(mirrored, (std::vector<size_t>{2, 1, 0, 1, 2, 3, 2, 1, 0, 1}));
  EXPECT_EQ(padded_frame(-1, 2, Padding::symmetric), 1U);
  EXPECT_EQ(padded_frame(-2, 2, Padding::symmetric), 0U);
}

TEST(CvvdpParts, SensitivityOfTheReference) {
  // log10: the formulas' error against the reference's table, by channel, from 0.05 cd/m2 on and below.
  constexpr PerChannel<double> kBright = {5e-4, 5e-6, 5e-6, 1e-5};
  constexpr PerChannel<double> kDark = {5e-2, 5e-6, 5e-6, 1e-2};
  // Contrasts end at 1000: what is less sensitive than 1e-3 sees nothing, however little less.
  constexpr double kBlind = 1e-3;
  size_t checked = 0;
  for (const json& one : units()["csf"]) {
    const auto luminance = one["L"].get<double>();
    for (size_t c = 0; c < kChannels; ++c, ++checked) {
      const double s = sensitivity(sensitivity_lines(c, one["rho"].get<double>(), 1), luminance);
      const auto expected = one["S_corrected"][c].get<double>();
      EXPECT_NEAR(std::log10(std::max(s, kBlind)), std::log10(std::max(expected, kBlind)),
                  luminance < 0.05 ? kDark[c] : kBright[c])
          << "channel " << c << " " << one["rho"] << " cpd " << luminance;
    }
  }
  EXPECT_EQ(checked, 13U * 11U * 4U);
}

TEST(CvvdpParts, JodAndPoolingOfTheReference) {
  for (const json& one : units()["jod_of_Q"])
    EXPECT_NEAR(jod_of(one[0].get<double>()), one[1].get<double>(), 2e-6 + 1e-6 * std::fabs(one[1].get<double>()));
  size_t checked = 0;
  for (const json& one : units()["pooling"]) {
    const json& q = one["Q"];
    const size_t frames = q[0].size();
    std::vector<double> by_frame;
    for (size_t f = 0; f < frames; ++f) {
      FrameQ frame;
      for (const json& channel : q) frame.push_back(channel[f].get<std::vector<double>>());
      by_frame.push_back(frame_difference(frame));
    }
    EXPECT_NEAR(jod_of(pooled(by_frame, frames == 1)), one["jod"].get<double>(), 2e-6);
    ++checked;
  }
  EXPECT_EQ(checked, 3U);
  EXPECT_NEAR(jod_of(0.1), jod_of(0.1 + 1e-12), 1e-9) << "without a step";
}

TEST(CvvdpParts, BandsOfTheReference) {
  for (const json& one : units()["levels"]) {
    const auto f = band_frequencies(one["w"].get<int>(), one["h"].get<int>(), one["ppd"].get<double>());
    ASSERT_EQ(f.size(), one["bands_with_base"].get<size_t>()) << one["w"];
    for (size_t b = 0; b < f.size(); ++b) EXPECT_NEAR(f[b] / one["rho"][b].get<double>(), 1, 1e-6);
  }
}

// A constant stays one, but for the last column where one side is odd and the other even: its weights add up to 0.75 or
// 1.25.
TEST(CvvdpParts, ReducingAConstant) {
  for (const auto& [width, height, last] :
       {std::tuple{8, 6, 1.0F}, {9, 7, 1.0F}, {9, 6, 0.75F}, {8, 7, 1.25F}, {4, 4, 1.0F}}) {
    FloatPlane in;
    in.resize(width, height);
    std::fill(in.data.begin(), in.data.end(), 8.0F);
    const FloatPlane out = reduced(in);
    for (int y = 0; y < out.height; ++y)
      for (int x = 0; x < out.width; ++x)
        EXPECT_NEAR(out.row(y)[x], x + 1 == out.width ? 8 * last : 8, 1e-5) << width << " x " << height;
  }
}

TEST(CvvdpParts, ReducingAndExpandingAsTheReference) {
  size_t checked = 0;
  for (const json& one : units()["pyramid"]) {
    const FloatPlane in = plane_of(one["in"]);
    const FloatPlane out = reduced(in);
    const FloatPlane expected = plane_of(one["reduced"]);
    ASSERT_EQ(out.width, expected.width);
    ASSERT_EQ(out.height, expected.height);
    for (size_t i = 0; i < out.data.size(); ++i) EXPECT_NEAR(out.data[i], expected.data[i], 3e-5) << in.width;
    const FloatPlane back = plane_of(one["expanded_back"]);
    std::vector<float> scratch;
    std::vector<float> row(static_cast<size_t>(in.width));
    for (int y = 0; y < in.height; ++y) {
      expand_row(out, y, in.width, scratch, row.data());
      for (int x = 0; x < in.width; ++x, ++checked)
        EXPECT_NEAR(row[static_cast<size_t>(x)], back.row(y)[x], 3e-5) << in.width << " x " << in.height;
    }
  }
  EXPECT_GT(checked, 200U);
}

TEST(CvvdpParts, OpponentColoursOfTheReference) {
  const CvvdpCases cases;
  size_t checked = 0;
  for (const auto& [name, expected] : units()["displays"].items()) {
    if (!expected.contains("rgb_to_dkl")) continue;
    OpponentColours colours(cases.display(name));
    for (const json& one : expected["rgb_to_dkl"]) {
      ImageF pixel(1, 1, 3);
      pixel.data = one["rgb"].get<std::vector<float>>();
      OpponentPlanes planes;
      colours.planes(pixel, planes, 1);
      for (size_t c = 0; c < kStillChannels; ++c, ++checked) {
        // Chromatic values are small differences of large ones: relative to the light, and to PQ's single precision.
        const double light = one["linear_nit"][1].get<double>() + one["linear_nit"][2].get<double>();
        EXPECT_NEAR(planes[c].data[0], one["dkl"][c].get<double>(),
                    (name.ends_with("pq") ? 1e-4 : 3e-6) * (light + std::fabs(one["dkl"][c].get<double>())))
            << name << one["rgb"];
      }
    }
  }
  EXPECT_GT(checked, 150U);
}

// Everything that happens inside one picture, as the reference recorded it.
using Stages = std::map<std::tuple<size_t, std::string, size_t>, FloatPlane>;

Stages stages_of(FrameComparison& comparison, const FramePlanes& planes) {
  Stages out;
  const FrameComparison::Probe probe = [&](size_t band, std::string_view stage, size_t channel, int y,
                                           std::span<const float> row) {
    FloatPlane& plane = out[{band, std::string(stage), channel}];
    const FloatPlane& size = band == 0 ? planes[0][0] : comparison.level(band)[0][0];
    if (plane.data.empty()) plane.resize(size.width, size.height);
    std::copy(row.begin(), row.end(), plane.row(y));
  };
  comparison.compare(planes, nullptr, &probe);
  return out;
}

FramePlanes still_planes(const CvvdpCase& one) {
  OpponentColours colours(one.display);
  FramePlanes planes;
  for (size_t p = 0; p < 2; ++p) {
    OpponentPlanes opponent;
    colours.planes(std::get<Image8>(p == 0 ? one.test[0] : one.reference[0]), opponent, 1);
    for (size_t c = 0; c < kStillChannels; ++c) planes[p][c] = opponent[c];
  }
  return planes;
}

TEST(CvvdpParts, StagesOfSmallPicturesInFull) {
  constexpr std::array<const char*, kStillChannels> kNames = {"A_sust", "RG", "YV"};
  const CvvdpCases cases;
  const json all = cvvdp_json("small_full.json")["full_arrays"];
  size_t checked = 0;
  for (const auto& [key, bands] : all.items()) {
    const auto one = cases.load(key);
    ASSERT_TRUE(one) << key;
    const FramePlanes planes = still_planes(*one);
    FrameComparison comparison(planes[0][0].width, planes[0][0].height, one->display.pixels_per_degree, kStillChannels,
                               1);
    const Stages stages = stages_of(comparison, planes);
    ASSERT_EQ(comparison.frequencies().size(), bands.size());
    for (size_t b = 0; b < bands.size(); ++b)
      for (size_t c = 0; c < kStillChannels; ++c)
        for (const auto& [stage, values] : bands[b][kNames[c]].items()) {
          const auto found = stages.find({b, stage, c});
          if (!values.is_array() || found == stages.end()) continue;
          const FloatPlane expected = plane_of(values);
          // Single precision on both sides, seven digits written: 1e-4 of the value, and of the largest where a
          // difference is small.
          float largest = 0;
          for (const float v : expected.data) largest = std::max(largest, std::fabs(v));
          for (size_t i = 0; i < expected.data.size(); ++i, ++checked)
            ASSERT_NEAR(found->second.data[i], expected.data[i],
                        1e-4 * std::fabs(expected.data[i]) + 1e-5 * static_cast<double>(largest))
                << key << " band " << b << " " << kNames[c] << " " << stage << " " << i;
        }
    for (size_t b = 0; b + 1 < bands.size(); ++b)
      for (const char* stage : {"log10_Lbkg_test", "log10_Lbkg_ref"}) {
        const FloatPlane expected = plane_of(bands[b][stage]);
        const FloatPlane& ours = stages.at({b, stage, 0});
        for (size_t i = 0; i < expected.data.size(); ++i, ++checked)
          ASSERT_NEAR(ours.data[i], expected.data[i], 1e-5) << key << " " << b;
      }
  }
  EXPECT_GT(checked, 10000U);
}

// least: differences that are rounding alone.
void expect_statistics(const FloatPlane& plane, const json& expected, double least, const std::string& what) {
  double sum = 0;
  double squares = 0;
  const auto [low, high] = std::minmax_element(plane.data.begin(), plane.data.end());
  for (const float v : plane.data) {
    sum += v;
    squares += static_cast<double>(v) * static_cast<double>(v);
  }
  const auto count = static_cast<double>(plane.data.size());
  const auto rms = expected["rms"].get<double>();
  // As above, and 4e-4 for the formulas of the sensitivity.
  const double slack = 1e-3 * rms + least;
  EXPECT_NEAR(sum / count, expected["mean"].get<double>(), slack) << what;
  EXPECT_NEAR(std::sqrt(squares / count), rms, slack) << what;
  EXPECT_NEAR(*low, expected["min"].get<double>(), slack + 1e-3 * std::fabs(*low)) << what;
  EXPECT_NEAR(*high, expected["max"].get<double>(), slack + 1e-3 * std::fabs(*high)) << what;
  const int w = plane.width;
  const int h = plane.height;
  const std::array<std::pair<int, int>, 6> places = {
      {{0, 0}, {w - 1, 0}, {0, h - 1}, {w - 1, h - 1}, {w / 2, h / 2}, {w / 4, h / 3}}};
  for (size_t i = 0; i < places.size(); ++i) {
    const double v = plane.row(places[i].second)[places[i].first];
    EXPECT_NEAR(v, expected["samples"][i].get<double>(), slack + 1e-3 * std::fabs(v)) << what << " sample " << i;
  }
}

// Frame by frame of a clip, by statistics and samples; needs the sequence and stages.json.
TEST(CvvdpParts, StagesOfAClip) {
  const std::filesystem::path file = std::filesystem::path(CROWDBENCH_SHARED_DIR) / "ground-truth/cvvdp/stages.json";
  if (!std::filesystem::exists(file)) GTEST_SKIP() << "needs the shared ground-truth folder";
  constexpr std::array<const char*, kChannels> kNames = {"A_sust", "RG", "YV", "A_trans"};
  const std::string key = "sequence@standard_4k@30fps";
  const json expected = json::parse(read_text(file))["stages"][key];
  const auto clip = CvvdpCases().load(key);
  ASSERT_TRUE(clip);
  OpponentColours colours(clip->display);
  FrameWindow window(30, Padding::replicate);
  FrameComparison comparison(96, 72, clip->display.pixels_per_degree, kChannels, 1);
  size_t checked = 0;
  for (size_t f = 0; f < clip->test.size(); ++f) {
    colours.planes(std::get<Image8>(clip->test[f]), window.place(f)[0], 1);
    colours.planes(std::get<Image8>(clip->reference[f]), window.place(f)[1], 1);
    const std::string name = fmt::format("frame{}", f);
    if (!expected.contains(name)) continue;
    FramePlanes planes;
    window.filter(f, f + 1, planes, 1);
    // Of 200 cd/m2 in single precision, which is what the transient channel takes away from itself.
    constexpr double kRounding = 1e-5;
    for (size_t c = 0; c < kChannels; ++c) {
      expect_statistics(planes[0][c], expected[name]["planes"][kNames[c]]["test"], kRounding, name + " test");
      expect_statistics(planes[1][c], expected[name]["planes"][kNames[c]]["ref"], kRounding, name + " ref");
    }
    const json& bands = expected[name]["bands"];
    for (const auto& [at, plane] : stages_of(comparison, planes)) {
      const auto& [band, stage, channel] = at;
      const json& here = bands[band].contains(stage) ? bands[band] : bands[band][kNames[channel]];
      expect_statistics(plane, here[stage], 1e-6, fmt::format("{} band {} {} {}", name, band, kNames[channel], stage));
      ++checked;
    }
  }
  EXPECT_GT(checked, 300U);
}

}  // namespace
}  // namespace crowdbench::metrics::vdp
