#include "reports/page/pop_page.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>
#include <nlohmann/json.hpp>

#include "core/error.h"
#include "reports/charts/charts.h"
#include "reports/model/pop_model.h"
#include "reports/page/libraries.h"
#include "tests/reports/rows.h"

namespace crowdbench::reports {
namespace {

// Two azimuths by two phases; cuts of 10, 20, 30, 40 code values, a fade's step a fifth, in the stored pose half of
// both.
constexpr size_t kError = 1;  // the place of the score that ranks
std::vector<ScoreDoc> scores_of_pops() { return {made_up_scores()[2], made_up_scores()[4]}; }

PopSize made_up_size(double ratio) {
  PopSize size;
  for (int i = 0; i < 4; ++i) {
    PopPoint point;
    point.ratio = ratio;
    point.height_px = 120 * ratio;
    point.azimuth_deg = i % 2 == 0 ? 0 : 180;
    point.elevation_deg = 10;
    point.phase = i < 2 ? 0.25 : 0.75;
    const double cut = 10.0 * (i + 1);
    point.scores = {{0.5, 0.75, 0.625, std::nullopt}, {cut, cut / 5, cut / 2, cut / 10}};
    size.points.push_back(point);
  }
  size.summaries.resize(2);
  for (size_t w = 0; w < kPopSwitchKinds; ++w)
    size.summaries[kError][w] = PopSummary{*size.points[1].scores[kError][w], *size.points[3].scores[kError][w] - 0.5,
                                           *size.points[3].scores[kError][w], size.points[3]};
  size.summaries[0][0] = PopSummary{0.5, 0.45, 0.25, size.points[3]};
  size.worst = {{"mesh <own>", 2, 3, {1, 2, 3}}, {"impostor", 2, 3, {1, 2, 3}}};
  size.fade = {{"tick 0", 2, 3, {1, 2, 3}}};
  return size;
}

TEST(PopChart, HoldsEveryCellAndAllKindsOfSwitchOnOneScale) {
  const auto chart = nlohmann::json::parse(pop_chart(made_up_size(1), scores_of_pops(), kError, 40));
  const auto& values = chart.at("data").at("values");
  ASSERT_EQ(values.size(), 4U * kPopSwitchKinds);
  double sum = 0;
  for (const auto& value : values) sum += value.at("coloured").get<double>();
  EXPECT_DOUBLE_EQ(sum, 100 * (1 + 0.2 + 0.5 + 0.1));
  ASSERT_EQ(chart.at("vconcat").size(), kPopSwitchKinds);
  for (const auto& kind : chart.at("vconcat")) {
    // One legend for all: a row that says otherwise is warned of in the browser.
    EXPECT_EQ(kind.at("spec").at("encoding").at("color").at("legend"),
              chart.at("vconcat").at(0).at("spec").at("encoding").at("color").at("legend"));
    EXPECT_EQ(kind.at("spec").at("encoding").at("color").at("scale").at("domain").dump(), "[0,40.0]");
  }
  // A cell without a score is a hole, not a zero.
  PopSize size = made_up_size(1);
  size.points[0].scores[kError][0] = std::nullopt;
  EXPECT_EQ(nlohmann::json::parse(pop_chart(size, scores_of_pops(), kError, 40)).at("data").at("values").size(), 15U);
  EXPECT_TRUE(pop_chart({}, scores_of_pops(), kError, 1).empty());
}

class PopPageTest : public testing::Test {
 protected:
  void SetUp() override {
    try {
      chart_libraries();
    } catch (const Error&) {
      GTEST_SKIP() << "npm packages of the chart library absent at configure time";
    }
    page_ = pop_page({"flat",
                      "a <b>man</b>",
                      "walk",
                      "llvmpipe",
                      "crowdbench 0",
                      true,
                      4,
                      scores_of_pops(),
                      kError,
                      {made_up_size(0.5), made_up_size(1)}});
    if (const char* path = std::getenv("CROWDBENCH_KEEP_PAGE")) std::ofstream(path) << page_;
    EXPECT_EQ(count("<script"), count("</script>"));
    page_.resize(page_.find("<footer"));  // the chart library's own texts are not counted
  }
  size_t count(const std::string& text) const {
    size_t n = 0;
    for (size_t at = page_.find(text); at != std::string::npos; at = page_.find(text, at + 1)) ++n;
    return n;
  }
  std::string page_;
};

TEST_F(PopPageTest, TellsEverySizeByTableChartAndPictures) {
  EXPECT_EQ(count("<h2>"), 2U);
  EXPECT_NE(page_.find("0.5 px a texel, 60 px tall"), std::string::npos);
  EXPECT_EQ(count("data-plot="), 2U);
  EXPECT_EQ(count("<figure>"), 2U * 3);
  const auto has = [&](const std::string& text) { return page_.find(text) != std::string::npos; };
  EXPECT_TRUE(
      has("<td>0.500</td><td>0.450</td><td>0.250</td>\n<td>20.00</td><td>39.50</td><td>40.00</td>\n"
          "<td class=\"l i\">azimuth 180°, elevation 10°, phase 0.75</td>"));
  EXPECT_TRUE(has("<th>SSIM in the figure, mean</th><th>5th percentile</th>"));
  EXPECT_TRUE(has("<th>Mean absolute error, code values, mean</th><th>95th percentile</th>"));
  EXPECT_TRUE(has("the mean absolute error is 20.00 code values on average and 40.00 at worst"));
  EXPECT_NE(page_.find("over 8 cells"), std::string::npos);
}

TEST_F(PopPageTest, OpensWithoutANetworkAndEscapesItsTexts) {
  EXPECT_NE(page_.find("default-src 'none'"), std::string::npos);
  EXPECT_NE(page_.find("a &lt;b&gt;man&lt;/b&gt;"), std::string::npos);
  EXPECT_NE(page_.find("mesh &lt;own&gt;"), std::string::npos);
  EXPECT_EQ(count("<img"), count("src=\"data:image/png;base64,"));
  EXPECT_EQ(page_.find("<link"), std::string::npos);
}

TEST(PopModel, ASizeIsSaidInTexelsWhereThereAreAny) {
  PopPoint point;
  point.height_px = 113.6;
  EXPECT_EQ(pop_size_text(point), "114 px tall");
  point.ratio = 1;
  EXPECT_EQ(pop_size_text(point), "1 px a texel, 114 px tall");
  point.ratio = 0.12345;
  EXPECT_EQ(pop_size_text(point), "0.123 px a texel, 114 px tall");
  EXPECT_EQ(kPopSwitchTitles.size(), kPopSwitchKinds);
  EXPECT_STREQ(kPopSwitchTitles[0], "own pose, cut") << "the order of the points' scores";
}

}  // namespace
}  // namespace crowdbench::reports
