// The outside oracle of what is scored through ids, depths and successive frames: a rendered crowd whose figures hide
// each other and are cut off on three sides, and silhouettes at the edge of what exists. The expected values are those
// of SciPy, scikit-image and NumPy: tests/data/ground-truth/crowd/make_expected.py.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "metrics/agents.h"
#include "metrics/registry.h"
#include "metrics/silhouette.h"
#include "tests/metrics/ground_truth.h"

namespace crowdbench::metrics {
namespace {

using nlohmann::json;

const std::filesystem::path kCrowd = kOwn / "crowd";

const json& expected_of_crowd() {
  static const json all = json::parse(read_text(kCrowd / "expected.json"));
  return all;
}

double tolerance_of(std::string_view score) {
  const json& tolerances = expected_of_crowd()["tolerances"];
  return tolerances.value(std::string(score), tolerances["default"].get<double>());
}

void expect_value(const json& expected, const std::optional<double>& value, std::string_view score) {
  SCOPED_TRACE(score);
  if (expected.is_null()) {
    EXPECT_FALSE(value) << "must not exist";
    return;
  }
  ASSERT_TRUE(value);
  if (expected == "inf") {
    EXPECT_EQ(*value, std::numeric_limits<double>::infinity());
    return;
  }
  const auto number = expected.get<double>();
  EXPECT_NEAR(*value, number, tolerance_of(score) * std::max(1.0, std::abs(number)));
}

ImageU32 ids_picture(const std::filesystem::path& path) { return std::get<ImageU32>(read_image(path)); }

// One of the crowd's frames: colours and ids of both.
struct Frame {
  Image8 reference, test;
  ImageU32 ids_reference, ids_test;
  Mask region;  // either silhouette

  explicit Frame(int tick)
      : reference(picture(kCrowd / fmt::format("ref_{}.png", tick))),
        test(picture(kCrowd / fmt::format("test_{}.png", tick))),
        ids_reference(ids_picture(kCrowd / fmt::format("ref_ids_{}.exr", tick))),
        ids_test(ids_picture(kCrowd / fmt::format("test_ids_{}.exr", tick))),
        region(union_of(mask_of(ids_reference), mask_of(ids_test))) {}
  ScoreInput input(bool with_region) const {
    ScoreInput out;
    out.reference.codes = &reference;
    out.reference.ids = &ids_reference;
    out.test.codes = &test;
    out.test.ids = &ids_test;
    if (with_region) out.region = &region;
    return out;
  }
};

// Every expected score is there and right; returns how many.
size_t expect_scores(const json& expected, const std::vector<Scored>& scored) {
  size_t seen = 0;
  for (const Scored& one : scored) {
    const auto found = expected.find(std::string(one.score->name));
    if (found == expected.end()) continue;
    ++seen;
    expect_value(*found, one.result.value, one.score->name);
  }
  EXPECT_EQ(seen, expected.size());
  return seen;
}

// Likewise of every agent.
void expect_agents(const json& expected, const AgentScores& agents) {
  ASSERT_EQ(agents.agents.size(), expected.size());
  for (const AgentRow& agent : agents.agents) {
    SCOPED_TRACE(agent.id);
    const json& row = expected.at(std::to_string(agent.id));
    size_t seen = 0;
    for (size_t s = 0; s < agents.scores.size(); ++s) {
      const auto found = row.find(std::string(agents.scores[s]->name));
      if (found == row.end()) continue;
      ++seen;
      expect_value(*found, agent.values[s], agents.scores[s]->name);
    }
    EXPECT_EQ(seen, row.size());
  }
}

TEST(CrowdOracle, AFrameAndItsAgents) {
  const json& crowd = expected_of_crowd()["crowd"];
  const int tick = crowd["frame"].get<int>();
  const Frame frame(tick);
  const ImageF depth_reference = float_picture(kCrowd / fmt::format("ref_depth_{}.exr", tick));
  const ImageF depth_test = float_picture(kCrowd / fmt::format("test_depth_{}.exr", tick));
  ScoreInput input = frame.input(true);
  input.reference.depth = &depth_reference;
  input.test.depth = &depth_test;
  Shared shared;
  EXPECT_EQ(expect_scores(crowd["scores"], score_pictures(scores(), input, shared)), 12U);
  EXPECT_EQ(crowd["agents"].size(), 16U);
  expect_agents(crowd["agents"], score_agents(scores(), input, shared));
}

TEST(CrowdOracle, SuccessiveFrames) {
  const json& clip = expected_of_crowd()["clip"];
  for (const bool in_region : {false, true}) {
    const json& expected = clip[in_region ? "in_region" : "whole"];
    ClipScores running(scores());
    for (const json& tick : clip["frames"]) running.take(Frame(tick.get<int>()).input(in_region));
    size_t seen = 0;
    for (const Scored& one : running.finish()) {
      if (one.score->name != "flicker") continue;
      ++seen;
      expect_value(expected["value"], one.result.value, one.score->name);
      ASSERT_EQ(one.result.by_frame.size(), clip["frames"].size());
      EXPECT_FALSE(one.result.by_frame[0]);
      EXPECT_FALSE(one.result.by_frame[1]);
      for (size_t t = 0; t < expected["by_frame"].size(); ++t)
        expect_value(expected["by_frame"][t], one.result.by_frame[t + 2], one.score->name);
    }
    EXPECT_EQ(seen, 1U);
  }
}

TEST(CrowdOracle, LinearLight) {
  const json& linear = expected_of_crowd()["linear"];
  const ImageF reference = float_picture(kOwn / linear["reference"].get<std::string>());
  ASSERT_EQ(reference.channels, 3);
  ImageF test = reference;
  for (size_t i = 0; i < test.data.size(); ++i)
    test.data[i] += static_cast<float>(static_cast<int>(i * 7919 % 64) - 24) / 128.0F;
  ScoreInput input;
  input.reference.linear = &reference;
  input.test.linear = &test;
  Shared shared;
  EXPECT_EQ(expect_scores(linear["scores"], score_pictures(scores(), input, shared)), 2U);
}

ImageU32 ids_of_rows(const json& rows) {
  const auto width = static_cast<int>(rows[0].get<std::string>().size());
  ImageU32 out(width, static_cast<int>(rows.size()), 1);
  for (int y = 0; y < out.height; ++y) {
    const auto row = rows[static_cast<size_t>(y)].get<std::string>();
    for (int x = 0; x < width; ++x) {
      const char c = row.at(static_cast<size_t>(x));
      *out.at(x, y) = c == '.' ? 0 : static_cast<uint32_t>(c - '0');
    }
  }
  return out;
}

// Nothing drawn, a single pixel, everything drawn, cut off by the edge, a ring, a thread, agents over each other.
TEST(CrowdOracle, SilhouettesAtTheEdgeOfWhatExists) {
  const json& grids = expected_of_crowd()["grids"];
  EXPECT_EQ(grids.size(), 12U);
  for (const json& grid : grids) {
    SCOPED_TRACE(grid["name"].get<std::string>());
    const ImageU32 reference = ids_of_rows(grid["reference"]);
    const ImageU32 test = ids_of_rows(grid["test"]);
    ScoreInput input;
    input.reference.ids = &reference;
    input.test.ids = &test;
    Shared shared;
    EXPECT_EQ(expect_scores(grid["scores"], score_pictures(scores(), input, shared)), 7U);
    expect_agents(grid["agents"], score_agents(scores(), input, shared));
  }
}

}  // namespace
}  // namespace crowdbench::metrics
