// The truth among what the driver compares: as a capture, as JSON, and staged without a driver.
#include <gtest/gtest.h>

#include <limits>

#include "bench/stage/stage_scenario.h"
#include "bench/stage/truth_capture.h"

namespace crowdbench::bench {
namespace {

TEST(TruthCapture, HoldsWhatTheTruthShows) {
  truth::TruthPicture picture;
  picture.colour = Image8(2, 1, 4);
  picture.colour.data = {1, 2, 3, 255, 4, 5, 6, 255};
  picture.linear = ImageF(2, 1, 4);
  picture.depth = Image<double>(2, 1, 1);
  picture.depth.data = {0.1, std::numeric_limits<double>::infinity()};
  picture.ids = ImageU32(2, 1, 1);
  picture.ids.data = {7, 0};
  const renderers::Capture capture = capture_of(picture);
  EXPECT_EQ(capture.colour, picture.colour);
  EXPECT_EQ(capture.ids, picture.ids);
  EXPECT_EQ(capture.depth.data, (std::vector<float>{0.1F, std::numeric_limits<float>::infinity()}));
  EXPECT_TRUE(capture.linear.empty());
  EXPECT_EQ(capture_of(picture, {.linear = true}).linear, picture.linear);
}

TEST(TruthCapture, AJudgementIsJsonAndALine) {
  truth::Judgement judgement;
  judgement.pixels = 100;
  judgement.wrong = 3;
  judgement.outline = 2;
  judgement.unexplained = 1;
  judgement.largest_bound = 0.0078125;
  judgement.offenders.push_back({4, 5, 0, 9, 0.5});
  const Json json = judgement_json(judgement, "it");
  const std::string text = json.dump(0);
  for (const char* part : {"\"judged\"", "\"it\"", "\"unexplained\"", "0.0078125", "\"truth_id\"", "\"bound_px\""})
    EXPECT_NE(text.find(part), std::string::npos) << part << " in " << text;
  EXPECT_EQ(
      judgement_line(judgement, "it"),
      "it: 3 of 100 pixels show another agent than the truth: 2 within 0.0078 pixels of an outline, 0 by depth, 0 "
      "by masks, 1 unexplained; inside, colours are off by 0.00 code values in the mean");
}

TEST(TruthCapture, OnlyAnOccupancyOfSomebodyMustBeSolved) {
  scene::Scenario scenario;
  scenario.crowd.agents = 3;
  EXPECT_FALSE(must_solve(scenario));
  scenario.occupancy = 0.2;
  EXPECT_TRUE(must_solve(scenario));
  scenario.crowd.agents = 0;
  EXPECT_FALSE(must_solve(scenario));
}

}  // namespace
}  // namespace crowdbench::bench
