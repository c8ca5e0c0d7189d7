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
