#include "reports/page/clip_page.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "core/error.h"
#include "reports/charts/clip_chart.h"
#include "reports/model/clip_series.h"
#include "reports/page/libraries.h"

namespace crowdbench::reports {
namespace {

using nlohmann::json;

ClipSeries series_of(std::string name, std::vector<std::optional<double>> values, size_t worst) {
  ClipSeries out;
  out.doc.name = std::move(name);
  out.doc.title = "sharpness";
  out.doc.unit = "dB";
  out.doc.digits = 2;
  out.whole = 31.5;
  out.pooling = "mean over frames";
  out.by_frame = std::move(values);
  out.worst_frame = worst;
  return out;
}

TEST(ClipChart, HasEveryFrameInSecondsAndMarksTheWorst) {
  const ClipSeries series =
      series_of("s", {40.0, std::numeric_limits<double>::infinity(), 20.0, std::nullopt, 30.0}, 2);
  const json spec = json::parse(clip_chart(series, 10));
  const json& values = spec.at("data").at("values");
  ASSERT_EQ(values.size(), 5U);
  EXPECT_EQ(values[2].at("seconds"), 0.2);
  EXPECT_EQ(values[2].at("text"), "20.00");
  EXPECT_TRUE(values[1].at("value").is_null()) << "infinite: a gap";
  EXPECT_EQ(values[1].at("text"), "∞");
  EXPECT_TRUE(values[3].at("value").is_null());
  EXPECT_EQ(spec.at("layer")[1].at("data").at("values")[0].at("label"), "frame 2");
  EXPECT_EQ(spec.at("layer")[0].at("encoding").at("y").at("axis").at("title"), "dB")
      << "the heading above names the score, which upright would be longer than the chart is high";
  EXPECT_FALSE(json::parse(clip_chart(series, 0)).at("data").at("values")[2].contains("seconds"));
  EXPECT_EQ(clip_chart(series_of("s", {std::nullopt, std::numeric_limits<double>::infinity()}, 1), 10), "");
  EXPECT_EQ(clip_chart(series_of("s", {}, 0), 10), "") << "a score over time alone";
}

// The axis has room for labels, but not beyond what the score can be.
TEST(ClipChart, TheAxisKeepsWithinTheScoresRange) {
  const auto range_of = [](std::vector<std::optional<double>> values, std::optional<double> least,
                           std::optional<double> greatest) {
    ClipSeries series = series_of("s", std::move(values), 0);
    series.doc.least = least;
    series.doc.greatest = greatest;
    const json scale = json::parse(clip_chart(series, 10)).at("layer")[0].at("encoding").at("y").at("scale");
    EXPECT_EQ(scale.at("nice"), false);
    return std::pair(scale.at("domain")[0].get<double>(), scale.at("domain")[1].get<double>());
  };
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  const auto error = range_of({0.0, 0.4, 0.2}, 0, 1);
  EXPECT_EQ(error.first, 0);
  EXPECT_NEAR(error.second, 0.46, 1e-12);
  const auto jod = range_of({9.0, 10.0, std::nullopt}, -kInfinity, 10);
  EXPECT_NEAR(jod.first, 8.85, 1e-12);
  EXPECT_EQ(jod.second, 10);
  const auto unknown = range_of({9.0, 10.0}, {}, {});
  EXPECT_NEAR(unknown.second, 10.15, 1e-12);
  const auto equal = range_of({0.0, 0.0, kInfinity}, 0, kInfinity);
  EXPECT_EQ(equal.first, 0);
  EXPECT_GT(equal.second, 0) << "one value is a range too";
}

TEST(ClipPage, SaysTheWholeTheWorstAndWhatIsMissing) {
  try {
    chart_libraries();
  } catch (const Error&) {
    GTEST_SKIP() << "npm packages of the chart library absent at configure time";
  }
  ClipPage page;
  page.reference = "a.mp4";
  page.test = "<b>.mp4";
  page.frames = 1500;
  page.fps = 25;
  page.width = 64;
  page.height = 48;
  page.display = "somewhere";
  page.scores.push_back(series_of("s", {40.0, 20.0}, 1));
  page.scores[0].conditions = "67 pixels/degree";
  page.scores[0].map = {1, 1, {0x89, 'P', 'N', 'G'}};
  page.scores.emplace_back().doc.title = "smoothness";
  page.scores[1].reason = "too small";
  const std::string html = clip_page(page);
  const auto has = [&](const char* text) { return html.find(text) != std::string::npos; };
  EXPECT_TRUE(has("&lt;b&gt;.mp4 against a.mp4: 1,500 frames of 64 x 48 pixels at 25 a second"));
  EXPECT_TRUE(has("<td>31.50</td>"));
  EXPECT_TRUE(has("<td>20.00</td><td>1 (0.04 s)</td>"));
  EXPECT_TRUE(has("at 67 pixels/degree"));
  EXPECT_TRUE(has("not available: too small"));
  EXPECT_TRUE(has("data:image/png;base64,"));
  EXPECT_TRUE(has("Sharpness, dB, frame 1 (0.04 s)"));
}

}  // namespace
}  // namespace crowdbench::reports
