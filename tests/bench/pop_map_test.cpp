#include "bench/experiments/pop_map.h"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>

#include "core/error.h"
#include "metrics/heat_map.h"
#include "metrics/pseudocolour.h"
#include "renderers/gl/context.h"
#include "scene/mannequin/mannequin.h"
#include "tests/support/driver.h"
#include "tests/support/scratch_folder.h"

namespace crowdbench::bench {
namespace {

Image8 plain(uint8_t value) {
  Image8 out(16, 8, 4);
  for (uint8_t& v : out.data) v = value;
  return out;
}

TEST(PopMap, AFadeTakesEveryPixelFromOneSide) {
  const Image8 black = plain(0);
  const Image8 white = plain(255);
  const std::vector<Image8> pictures = fade_pictures(black, white, 3);
  ASSERT_EQ(pictures.size(), 5U);
  EXPECT_EQ(pictures.front(), black);
  EXPECT_EQ(pictures.back(), white);
  for (size_t step = 0; step < 5; ++step) {
    size_t turned = 0;
    for (size_t i = 0; i < pictures[step].pixels(); ++i) {
      const uint8_t v = pictures[step].data[4 * i];
      ASSERT_TRUE(v == 0 || v == 255);
      turned += v == 255 ? 1U : 0U;
      if (step > 0) {
        ASSERT_GE(v, pictures[step - 1].data[4 * i]) << "a pixel that has turned stays";
      }
    }
    EXPECT_EQ(turned, step * 32) << "a quarter of 128 pixels a step: two whole 8 x 8 patterns";
  }
}

// The place of a score among those of a switch, and its value in one kind of it.
size_t place_of(std::string_view name) {
  const auto scores = pop_scores(metrics::scores());
  for (size_t i = 0; i < scores.size(); ++i)
    if (scores[i]->name == name) return i;
  throw std::logic_error("no such score of a switch");
}
double value(const std::vector<std::optional<double>>& of_kind, std::string_view name) {
  return of_kind.at(place_of(name)).value();
}

TEST(PopMap, StatisticsByHand) {
  metrics::Score error;
  error.direction = metrics::Direction::lower_is_better;
  metrics::Score likeness;
  likeness.direction = metrics::Direction::higher_is_better;
  std::vector<PopCell> cells(5);
  for (size_t i = 0; i < 5; ++i)
    cells[i].own.cut = {static_cast<double>(i) * 10, 1.0 - 0.1 * static_cast<double>(i)};  // 0 .. 40, 1.0 .. 0.6
  cells[2].own.cut[1].reset();
  const auto high = summarise_pops(cells, error, 0, false, false);
  ASSERT_TRUE(high);
  EXPECT_DOUBLE_EQ(high->mean, 20);
  EXPECT_DOUBLE_EQ(high->tail, 38) << "position 0.95 * 4 = 3.8";
  EXPECT_DOUBLE_EQ(high->worst, 40);
  EXPECT_EQ(high->worst_cell, 4U);
  EXPECT_STREQ(tail_name(error), "p95");
  const auto low = summarise_pops(cells, likeness, 1, false, false);
  ASSERT_TRUE(low);
  EXPECT_NEAR(low->mean, (1.0 + 0.9 + 0.7 + 0.6) / 4, 1e-12);
  EXPECT_NEAR(low->tail, 0.615, 1e-12) << "low is bad: position 0.15 between 0.6 and 0.7";
  EXPECT_EQ(low->worst_cell, 4U);
  EXPECT_STREQ(tail_name(likeness), "p05");
  EXPECT_FALSE(summarise_pops(cells, error, 0, true, false)) << "none was measured";

  // Equal pictures: infinite for PSNR. The mean is infinite, the low tail of five is not.
  for (size_t i = 0; i < 5; ++i) cells[i].own.cut = {i < 2 ? 30.0 + static_cast<double>(i) : INFINITY};
  const auto infinite = summarise_pops(cells, likeness, 0, false, false);
  ASSERT_TRUE(infinite);
  EXPECT_TRUE(std::isinf(infinite->mean));
  EXPECT_NEAR(infinite->tail, 30.2, 1e-12);
  EXPECT_EQ(infinite->worst, 30);
  for (PopCell& cell : cells) cell.own.cut = {INFINITY};
  EXPECT_EQ(summarise_pops(cells, likeness, 0, false, false)->tail, INFINITY);
}

TEST(HeatMap, CellsCarryTheColourOfTheirValue) {
  const double nothing = std::nan("");
  const metrics::HeatPanel panel{"panel", {"0", "90"}, {"30", "0"}, {0, 5, 10, nothing}};
  const Image8 picture = metrics::heat_map({{panel}}, 10, "caption");
  const auto& colours = metrics::error_colours();
  EXPECT_EQ(metrics::heat_colour(0, 10), colours[0]);
  EXPECT_EQ(metrics::heat_colour(10, 10), colours[255]);
  EXPECT_EQ(metrics::heat_colour(20, 10), colours[255]) << "held at the end of the scale";
  EXPECT_EQ(metrics::heat_colour(nothing, 10), (std::array<uint8_t, 3>{200, 200, 200}));
  // Each of the four colours fills more than half of a cell of 43 x 25 pixels.
  for (const double value : {0.0, 5.0, 10.0, nothing}) {
    const auto rgb = metrics::heat_colour(value, 10);
    size_t count = 0;
    for (size_t i = 0; i < picture.pixels(); ++i)
      count += std::equal(rgb.begin(), rgb.end(), picture.data.begin() + static_cast<std::ptrdiff_t>(3 * i)) ? 1U : 0U;
    EXPECT_GT(count, 43U * 25 / 2) << value;
  }
}

class PopMapGl : public ::testing::Test {
 protected:
  PopRequest request(const std::string& representation) {
    PopRequest r;
    r.character = std::make_shared<const scene::Character>(scene::make_mannequin({.triangles = 500}));
    r.representation = renderers::parse_spec(representation);
    r.clip = r.character->placement.default_clip;
    r.use_cache = false;
    r.fade = 3;
    return r;
  }
  gl::Context context_{gl::ContextOptions{}};
};

TEST_F(PopMapGl, TheMeshDoesNotPopAgainstItself) {
  PopRequest r = request("mesh");
  EXPECT_THROW(compute_pop_map(context_, r), Error) << "no texels to go by";
  r.heights_px = {60};
  r.azimuths_deg = {0, 90};
  r.phases = {0, 0.3};
  const auto cells = compute_pop_map(context_, r);
  ASSERT_EQ(cells.size(), 4U);
  for (const PopCell& cell : cells)
    for (const PopScores* s : {&cell.own, &cell.matched})
      for (const auto* one : {&s->cut, &s->fade_step}) {
        EXPECT_EQ(value(*one, "mae"), 0.0);
        EXPECT_NEAR(value(*one, "ssim_union"), 1, 1e-12);
        EXPECT_EQ(value(*one, "psnr"), INFINITY);
      }
}

// One stored frame, and the mesh half a cycle from it and on it: what the pose alone adds, and what fading takes.
TEST_F(PopMapGl, MatchingTakesThePoseErrorAndFadingTheStep) {
  PopRequest r = request("flat:views=sphere-4x1,frames=1,texels=64");
  r.azimuths_deg = {90};
  r.phases = {0, 0.25};
  r.ratios = {1};
  size_t seen = 0;
  const auto cells = compute_pop_map(context_, r, [&](const PopCell& cell, const PopPictures& pictures) {
    ++seen;
    EXPECT_EQ(pictures.mesh == pictures.matched, cell.phase == 0.0);
  });
  ASSERT_EQ(cells.size(), 2U);
  EXPECT_EQ(seen, 2U);
  const PopCell& stored = cells[0];
  const PopCell& between = cells[1];
  EXPECT_EQ(between.shown_phase, 0);
  EXPECT_EQ(stored.own.cut, stored.matched.cut);
  EXPECT_EQ(between.matched.cut, stored.matched.cut) << "the same two pictures";
  EXPECT_GT(value(between.own.cut, "mae"), 1.5 * value(between.matched.cut, "mae"));
  EXPECT_LT(value(between.own.cut, "ssim_union"), value(between.matched.cut, "ssim_union") - 0.1);
  for (const PopCell& cell : cells) {
    // Three ticks, four steps: the largest is a quarter of the pop but for which pixels turn when.
    EXPECT_NEAR(value(cell.own.fade_step, "mae") / value(cell.own.cut, "mae"), 0.25, 0.08);
    EXPECT_GT(value(cell.own.fade_step, "ssim_union"), value(cell.own.cut, "ssim_union"));
  }
  // A texel spans one pixel: the figure is as tall as its texels are many.
  EXPECT_EQ(between.ratio, 1);
  EXPECT_GT(between.height_px, 40);
  EXPECT_LT(between.height_px, 64);
}

// What a user opens: the page stands beside the tables, with a chart and the pictures of the worst cell for each size.
TEST(PopMapCommandGl, WritesThePage) {
  if (!support::driver_is_built()) GTEST_SKIP() << "the driver is not built";
  const support::ScratchFolder folder;
  const support::Outcome out = support::run_driver(
      "",
      "popmap --representation flat:views=sphere-4x1,frames=2,texels=32 --character mannequin:triangles=500 "
      "--azimuth-deg 0,20 --elevation-deg 0 --phase 0.1 --ratio 1,2 --fade 2 --no-cache --out '" +
          folder.path().string() + "'");
  ASSERT_EQ(out.status, 0) << out.text;
  for (const char* file : {"popmap.json", "popmap.csv", "heat_map.png", "worst.png"})
    EXPECT_TRUE(std::filesystem::exists(folder / file)) << file;
  const std::vector<uint8_t> bytes = read_file(folder / "popmap.html");
  std::string page(bytes.begin(), bytes.end());
  page.resize(page.find("<footer"));
  const auto count = [&](const std::string& text) {
    size_t n = 0;
    for (size_t at = page.find(text); at != std::string::npos; at = page.find(text, at + 1)) ++n;
    return n;
  };
  EXPECT_EQ(count("<h2>"), 2U);
  EXPECT_EQ(count("data-plot="), 2U);
  EXPECT_EQ(count("<img "), 2U * (4 + 4 + 1))
      << "four of the worst cell, four ticks of the fade, the bar of the difference";
}

}  // namespace
}  // namespace crowdbench::bench
