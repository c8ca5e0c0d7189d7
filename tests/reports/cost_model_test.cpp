// Cost models, break-even and fronts on rows that follow a known law.
#include "reports/model/cost_model.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/random.h"
#include "reports/exports/cost_export.h"
#include "reports/model/break_even.h"
#include "reports/model/cost_text.h"
#include "reports/model/pareto.h"

namespace crowdbench::reports {
namespace {

constexpr int kWidth = 640, kHeight = 480;

// Rows of "mesh" (50,000 ns and 9,000 an agent) and of "flat" (400,000 ns, 1,000 an agent and 0.5 a covered pixel),
// with relative noise. The two cost the same where 8,000 agents are 350,000 and 0.5 a covered pixel.
struct Law {
  double frame, agent, pixel;
  double at(double agents, double covered) const { return frame + agent * agents + pixel * covered; }
};
constexpr Law kMesh{50'000, 9'000, 0}, kFlat{400'000, 1'000, 0.5};

StoreContents rows_of(double noise) {
  StoreContents contents;
  RunRow run;
  run.id = 1;
  run.headline = "cpu";
  run.scenario_name = "law";
  contents.runs.push_back(run);
  uint64_t draw = 0;
  int64_t id = 0;
  for (const double occupancy : {0.15, 0.5, 0.9})
    for (const uint32_t agents : {5U, 20U, 100U, 500U, 2000U}) {
      double times[2] = {};
      for (const bool flat : {false, true}) {
        MeasurementRow row;
        row.id = ++id;
        row.run = 1;
        row.key = {flat ? "flat" : "mesh", "walker", agents, kWidth, kHeight, occupancy};
        row.reference = "mesh";
        const double covered = occupancy * kWidth * kHeight;
        row.reference_px = static_cast<uint64_t>(covered);
        row.fragments = static_cast<uint64_t>(covered * (1 + random_unit(9, draw, 2)));
        double& time = times[flat ? 1 : 0];
        time = (flat ? kFlat : kMesh).at(agents, covered) * (1 + noise * (2 * random_unit(3, draw++, 1) - 1));
        row.cpu_ns = row.frame_ns = TimeSummary{time, time, time, time, time, time};
        row.texture_bytes = flat ? 1000 : 10;
        row.buffer_bytes = 0;
        row.rounds = 20;
        contents.measurements.push_back(row);
      }
      RatioRow ratio;
      ratio.id = id;
      ratio.run = 1;
      ratio.kind = "speed";
      ratio.of = contents.measurements.back().key;
      ratio.to = "mesh";
      ratio.metric = "cpu";
      ratio.ratio = times[0] / times[1];
      ratio.low = 0.95 * ratio.ratio;
      ratio.high = 1.05 * ratio.ratio;
      ratio.pairs = 20;
      contents.ratios.push_back(ratio);
    }
  return contents;
}

TEST(CostModel, FindsTheTermsOfALawAndLeavesTheOthersOut) {
  const StoreContents contents = rows_of(0);
  const std::vector<Scene> scenes = scenes_of(contents);
  ASSERT_EQ(scenes.size(), 1U);
  const CostModel flat = cost_model(scenes[0], "flat");
  ASSERT_EQ(flat.absent, "");
  ASSERT_EQ(flat.fit.terms.size(), 3U);
  EXPECT_EQ(flat.fit.terms[0].term, CostTerm::frame);
  EXPECT_NEAR(flat.fit.terms[0].ns, kFlat.frame, 1);
  EXPECT_EQ(flat.fit.terms[1].term, CostTerm::agents);
  EXPECT_NEAR(flat.fit.terms[1].ns, kFlat.agent, 1);
  EXPECT_EQ(flat.fit.terms[2].term, CostTerm::covered) << "not the fragments, which only resemble them";
  EXPECT_NEAR(flat.fit.terms[2].ns, kFlat.pixel, 1e-3);
  EXPECT_EQ(flat.within_15, 15U);
  EXPECT_NEAR(flat.within_share.low, 0.782, 0.001) << "Clopper and Pearson, 15 of 15";
  EXPECT_EQ(flat.within_share.high, 1);
  EXPECT_EQ(formula_text(flat.fit), "0.40 ms a frame + 1.0 µs an agent + 0.5 ns a covered pixel");
}

// Pixels of small figures that cost more: the law is found, and so is where it breaks even, from what is known
// beforehand.
TEST(CostModel, FindsThatPixelsOfSmallFiguresCostMore) {
  EXPECT_NEAR(fine_pixels(1000, 10, 100), 100 * std::log(100), 1e-9)
      << "figures of 10 pixels: a hundred fill the picture";
  EXPECT_EQ(fine_pixels(1000, 1, 1000), 0) << "one that fills it";
  EXPECT_EQ(fine_pixels(1000, 0, 0), 0);
  StoreContents contents = rows_of(0);
  for (MeasurementRow& row : contents.measurements) {
    if (row.key.representation != "flat") continue;
    const double time =
        400'000 + 2 * fine_pixels(kWidth * kHeight, row.key.agents, static_cast<double>(*row.reference_px));
    row.cpu_ns = TimeSummary{time, time, time, time, time, time};
  }
  for (const size_t allowed : {kTermsBeforehand, kCostTerms}) {
    const CostModel flat = cost_model(scenes_of(contents)[0], "flat", allowed);
    ASSERT_EQ(flat.fit.terms.size(), 2U);
    EXPECT_EQ(flat.fit.terms[1].term, CostTerm::fine);
    EXPECT_NEAR(flat.fit.terms[1].ns, 2, 1e-6);
    EXPECT_LT(flat.error, 1e-6);
  }
  const BreakEvenMap map = break_even_map(scenes_of(contents)[0]);
  ASSERT_EQ(map.pairs.size(), 1U);
  for (const BreakEvenPoint& point : map.pairs[0].contour) {
    ASSERT_TRUE(point.agents) << point.occupancy;
    const double covered = point.occupancy * kWidth * kHeight;
    EXPECT_NEAR(kMesh.at(*point.agents, covered), 400'000 + 2 * fine_pixels(kWidth * kHeight, *point.agents, covered),
                0.02 * kMesh.at(*point.agents, covered))
        << point.occupancy;
  }
}

TEST(CostModel, SaysHowWellItPredictsWhatItWasNotFittedTo) {
  const StoreContents quiet = rows_of(0.03);
  const CostModel model = cost_model(scenes_of(quiet)[0], "mesh");
  EXPECT_EQ(model.within_15, 15U);
  EXPECT_GT(model.error, 0.005);
  EXPECT_LT(model.error, 0.05);
  // What is told is of the predictions that neither terms nor figures were chosen by.
  double squares = 0;
  for (const CostPrediction& one : model.held_out) squares += std::pow(one.predicted_ns / one.point.time_ns - 1, 2);
  EXPECT_NEAR(model.error, std::sqrt(squares / 15), 1e-12);
  EXPECT_NE(model.error, model.fit.held_out);
  EXPECT_EQ(cost_json(scenes_of(quiet)[0]).at("models").elements()[0].at("held_out_error").number(), model.error);
  // Times that follow no law: nothing predicts them, and the model says so.
  StoreContents noise = rows_of(0);
  for (size_t i = 0; i < noise.measurements.size(); ++i) {
    const double time = 1e5 * std::pow(100.0, random_unit(4, i, 1));
    noise.measurements[i].cpu_ns = TimeSummary{time, time, time, time, time, time};
  }
  const CostModel none = cost_model(scenes_of(noise)[0], "mesh");
  EXPECT_LT(none.within_15, 8U);
  EXPECT_GT(none.error, 0.15);
}

// What is predicted from points around it is told apart from what is stretched beyond them: of a grid, its corners.
TEST(CostModel, TellsWhatLiesBetweenFromWhatLiesBeyond) {
  const CostModel model = cost_model(scenes_of(rows_of(0.03))[0], "mesh");
  size_t beyond = 0;
  for (const CostPrediction& one : model.held_out) {
    const auto is_end = [&](auto of) {
      const auto [least, most] =
          std::minmax_element(model.held_out.begin(), model.held_out.end(),
                              [&](const CostPrediction& a, const CostPrediction& b) { return of(a) < of(b); });
      return of(one) == of(*least) || of(one) == of(*most);
    };
    const bool corner = is_end([](const CostPrediction& p) { return static_cast<double>(p.point.agents); }) &&
                        is_end([](const CostPrediction& p) { return p.point.occupancy; });
    EXPECT_EQ(one.between, !corner) << one.point.agents << " agents, " << one.point.occupancy;
    beyond += one.between ? 0 : 1;
  }
  EXPECT_EQ(beyond, 4U);
  EXPECT_EQ(model.between, model.held_out.size() - 4);
  EXPECT_EQ(model.between_within_15, model.between);
  EXPECT_NE(accuracy_text(model).find("; of those between the others 11 of 11, error "), std::string::npos)
      << accuracy_text(model);
  // All at one occupancy: the ends of the line.
  StoreContents line = rows_of(0);
  std::erase_if(line.measurements, [](const MeasurementRow& row) { return row.key.requested_occupancy != 0.5; });
  const CostModel ends = cost_model(scenes_of(line)[0], "mesh");
  ASSERT_EQ(ends.absent, "");
  EXPECT_EQ(ends.held_out.size() - ends.between, 2U);
}

TEST(CostModel, IsAbsentWithTooFewPoints) {
  StoreContents contents = rows_of(0);
  contents.measurements.resize(8);
  const CostModel model = cost_model(scenes_of(contents)[0], "mesh");
  EXPECT_EQ(model.absent, "it was timed at 4 points, a model takes 5 at least");
  EXPECT_TRUE(break_even_map(scenes_of(contents)[0]).pairs.empty());
  EXPECT_NE(cost_markdown(scenes_of(contents)[0]), "");
  for (MeasurementRow& row : contents.measurements) row.cpu_ns = row.frame_ns = std::nullopt;
  EXPECT_EQ(cost_markdown(scenes_of(contents)[0]), "") << "nothing is said of what was not timed";
}

TEST(BreakEven, ContoursCrossWhereTheLawsDo) {
  const StoreContents contents = rows_of(0.02);
  const Scene scene = scenes_of(contents)[0];
  const BreakEvenMap map = break_even_map(scene);
  ASSERT_EQ(map.pairs.size(), 1U);
  ASSERT_EQ(map.pairs[0].contour.size(), 7U) << "between the occupancies that were measured";
  for (const BreakEvenPoint& point : map.pairs[0].contour) {
    const double covered = point.occupancy * kWidth * kHeight;
    const double exact = (kFlat.frame - kMesh.frame + kFlat.pixel * covered) / (kMesh.agent - kFlat.agent);
    ASSERT_TRUE(point.agents) << point.occupancy;
    EXPECT_LE(*point.low, exact) << point.occupancy;
    EXPECT_GE(*point.high, exact) << point.occupancy;
    EXPECT_NEAR(*point.agents, exact, 0.1 * exact);
    EXPECT_EQ(point.cheaper_below, "mesh");
    EXPECT_EQ(point.cheaper_beyond, "flat");
    EXPECT_NE(break_even_text(map.pairs[0], point).find("flat is the cheaper one from about "), std::string::npos);
  }
  for (const CheapestCell& cell : map.cells) {
    const double covered = cell.occupancy * kWidth * kHeight;
    const double ratio = kMesh.at(cell.agents, covered) / kFlat.at(cell.agents, covered);
    if (!cell.not_told_apart.empty()) continue;
    EXPECT_EQ(cell.cheapest, ratio > 1 ? "flat" : "mesh") << cell.agents << " " << cell.occupancy;
  }
  // The wilder the times, the less is said.
  const StoreContents wild = rows_of(0.8);
  size_t told = 0;
  for (const CheapestCell& cell : break_even_map(scenes_of(wild)[0]).cells) told += cell.not_told_apart.empty();
  EXPECT_LT(told, map.cells.size() / 2);
}

TEST(BreakEven, SaysNothingBeyondWhatBothWereTimedWith) {
  StoreContents contents = rows_of(0.02);
  MeasurementRow beyond = contents.measurements.back();
  beyond.id = 1000;
  beyond.key.agents = 100'000;
  contents.measurements.push_back(beyond);  // "flat" alone is timed there
  beyond.id = 1001;
  beyond.key = {"mesh", "walker", 200'000, kWidth, kHeight, 0.95};
  beyond.status = Status::unreachable;
  beyond.cpu_ns = beyond.frame_ns = std::nullopt;
  contents.measurements.push_back(beyond);
  const Scene scene = scenes_of(contents)[0];
  ASSERT_EQ(scene.agents.back(), 200'000U);
  const BreakEvenMap map = break_even_map(scene);
  ASSERT_EQ(map.pairs.size(), 1U);
  for (const BreakEvenPoint& point : map.pairs[0].contour) {
    EXPECT_EQ(point.from, 5U);
    EXPECT_EQ(point.to, 2000U);
  }
  EXPECT_EQ(map.pairs[0].contour.back().occupancy, 0.9);
  ASSERT_FALSE(map.cells.empty());
  for (const CheapestCell& cell : map.cells) EXPECT_LE(cell.agents, 2000);
  EXPECT_EQ(break_even_text(map.pairs[0], {.from = 5, .to = 2000}),
            "mesh and flat cannot be told apart from 5 to 2,000 agents in the "
            "scenario's own view");
}

// The largest crowds were timed where little is covered alone: the ranges of agents and of occupancies make a box, one
// corner of which nobody measured.
TEST(BreakEven, SaysNothingOfACornerThatWasNotTimed) {
  StoreContents contents = rows_of(0.02);
  double most = 0, least_occupancy = 1;
  for (const MeasurementRow& row : contents.measurements) {
    most = std::max<double>(most, row.key.agents);
    least_occupancy = std::min(least_occupancy, row.key.requested_occupancy);
  }
  std::erase_if(contents.measurements, [&](const MeasurementRow& row) {
    return row.key.agents > 20 && row.key.requested_occupancy > least_occupancy;
  });
  uint32_t fewer = 0;
  for (const MeasurementRow& row : contents.measurements)
    if (row.key.requested_occupancy == 0.9) fewer = std::max(fewer, row.key.agents);
  ASSERT_LT(fewer, most);
  const BreakEvenMap map = break_even_map(scenes_of(contents)[0]);
  ASSERT_EQ(map.pairs.size(), 1U);
  const std::vector<BreakEvenPoint>& contour = map.pairs[0].contour;
  EXPECT_EQ(contour.front().to, most);
  EXPECT_EQ(contour.back().occupancy, 0.9);
  EXPECT_EQ(contour.back().to, fewer);
  for (size_t i = 1; i < contour.size(); ++i) EXPECT_LT(contour[i].to, contour[i - 1].to) << "straight in logarithms";
  for (const BreakEvenPoint& point : contour)
    for (const auto& end : {point.agents, point.low, point.high})
      EXPECT_LE(end.value_or(0), point.to + 0.5) << point.occupancy;
  for (const CheapestCell& cell : map.cells) EXPECT_LE(cell.agents, (cell.occupancy == 0.9 ? fewer : most) + 0.5);
  const BreakEvenPoint ended{
      .occupancy = 0.5, .cheaper_below = "mesh", .agents = 12.0, .low = 9.0, .high = 20.0, .high_open = true, .to = 20};
  EXPECT_EQ(break_even_text(map.pairs[0], ended),
            "flat is the cheaper one from about 12 agents on (9 to 20, the most timed) at 50 % occupancy");
  const BreakEvenPoint none{.occupancy = 0.5, .cheaper_below = "mesh", .cheaper_beyond = "mesh", .from = 5, .to = 20};
  EXPECT_EQ(break_even_text(map.pairs[0], none),
            "mesh is cheaper than flat from 5 to 20 agents at 50 % occupancy: no break-even there, and nothing is "
            "known beyond");
}

// 0.1 ms and 20 ns a pixel are 1.2 ms at 55,000 pixels: of 550 agents, where 100 cover 10,000 and 1,000 ten times that.
TEST(BreakEven, CoversPixelsBetweenTheCrowdsThatWereTimedInTheOwnView) {
  StoreContents contents = rows_of(0);
  contents.measurements.resize(10);
  const uint32_t agents[] = {10, 30, 100, 1000, 10'000};
  const uint64_t covered[] = {3000, 2000, 10'000, 100'000, 200'000};  // by nothing that agents alone tell
  for (size_t i = 0; i < contents.measurements.size(); ++i) {
    MeasurementRow& row = contents.measurements[i];
    row.key.agents = agents[i / 2];
    row.key.requested_occupancy = 0;
    row.reference_px = covered[i / 2];
    row.fragments.reset();
    const double noise = 1 + 0.001 * static_cast<double>(i % 3);
    const double time =
        (row.key.representation == "mesh" ? 1e5 + 20.0 * static_cast<double>(covered[i / 2]) : 1.2e6) * noise;
    row.cpu_ns = row.frame_ns = TimeSummary{time, time, time, time, time, time};
  }
  const BreakEvenMap map = break_even_map(scenes_of(contents)[0]);
  ASSERT_EQ(map.pairs.size(), 1U);
  ASSERT_EQ(map.pairs[0].contour.size(), 1U);
  ASSERT_TRUE(map.pairs[0].contour[0].agents);
  EXPECT_NEAR(*map.pairs[0].contour[0].agents, 550, 15);
}

TEST(Pareto, IsBeatenOnlyByWhatIsSurelyFasterAndElseNoWorse) {
  StoreContents contents = rows_of(0);
  const auto front_of = [&] { return pareto_fronts(scenes_of(contents)[0])[0]; };
  ASSERT_EQ(front_of().agents, 2000U);
  for (const ParetoEntry& entry : front_of().entries) EXPECT_EQ(entry.beaten_by, "") << "faster, but of more bytes";
  for (MeasurementRow& row : contents.measurements) row.texture_bytes = 10;
  EXPECT_EQ(front_of().entries[0].beaten_by, "flat") << "nothing was scored: time and bytes decide";

  // Another one was scored: of two that were not, neither beats the other.
  StoreContents third = contents;
  for (const MeasurementRow& row : contents.measurements)
    if (row.key.representation == "flat") {
      third.measurements.push_back(row);
      third.measurements.back().id += 100;
      third.measurements.back().key.representation = "slow";
    }
  for (const RatioRow& row : contents.ratios) {
    third.ratios.push_back(row);
    third.ratios.back().id += 100;
    third.ratios.back().of.representation = "slow";
    third.ratios.back().low = third.ratios.back().high = third.ratios.back().ratio /= 40;
  }
  const auto slow = [](const ParetoFront& front) { return front.entries.back(); };
  ASSERT_EQ(slow(pareto_fronts(scenes_of(third)[0])[0]).beaten_by, "mesh") << "nothing was scored";
  ComparisonRow scored;
  scored.id = scored.run = 1;
  scored.kind = "crowd";
  scored.representation = "flat";
  scored.character = "walker";
  scored.agents = 2000;
  scored.requested_occupancy = 0.15;
  scored.scores.push_back({.name = "s", .value = 0.5});
  third.comparisons.push_back(scored);
  ScoreDoc doc;
  doc.name = "s";
  doc.headline = true;
  const ParetoFront front = pareto_fronts(scenes_of(third, {doc})[0])[0];
  EXPECT_EQ(slow(front).beaten_by, "") << "neither it nor mesh was scored";
  EXPECT_EQ(front_text(front, slow(front)), "not known, as it was not scored");

  for (RatioRow& ratio : contents.ratios) ratio.low = 0.9;
  EXPECT_EQ(front_of().entries[0].beaten_by, "") << "not surely faster";
  EXPECT_EQ(front_text(front_of(), front_of().entries[0]), "on the front");

  const Json told = cost_json(scenes_of(contents)[0]);
  EXPECT_NE(told.at("pareto").dump().find("\"error\":null"), std::string::npos) << "no score, so no error";
  const std::string markdown = cost_markdown(scenes_of(contents)[0]);
  EXPECT_NE(markdown.find("## Break-even"), std::string::npos);
  EXPECT_NE(markdown.find("| flat |"), std::string::npos);
  for (MeasurementRow& row : contents.measurements)
    if (row.key.representation == "flat") row.key.representation = "<b>";
  const std::string named = cost_markdown(scenes_of(contents)[0]);
  EXPECT_NE(named.find("- &lt;b> is the cheaper one"), std::string::npos) << named;
  EXPECT_EQ(named.find("<b>"), std::string::npos);
}

}  // namespace
}  // namespace crowdbench::reports
