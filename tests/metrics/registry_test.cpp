#include "metrics/registry.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <set>

#include "core/random.h"
#include "metrics/heat_map.h"
#include "metrics/intermediates.h"
#include "metrics/mat.h"
#include "metrics/sizes.h"
#include "test_paths.h"

namespace crowdbench::metrics {
namespace {

Image8 noise(int width, int height, uint64_t seed) {
  Image8 out(width, height, 3);
  for (size_t i = 0; i < out.data.size(); ++i) out.data[i] = static_cast<uint8_t>(random_below(seed, i, 1, 256));
  return out;
}

// Pictures that have everything, large enough for five scales: a square of an agent before a background.
struct Everything {
  Image8 codes = noise(200, 190, 1);
  ImageF linear = ImageF(200, 190, 3);
  ImageU32 ids = ImageU32(200, 190, 1);
  ImageF depth = ImageF(200, 190, 1);
  Mask region = Mask(200, 190, 1);
  Display display{60};

  Everything() {
    std::fill(linear.data.begin(), linear.data.end(), 0.25F);
    for (int y = 50; y < 120; ++y)
      for (int x = 60; x < 110; ++x) {
        *ids.at(x, y) = 3;
        *depth.at(x, y) = 5;
        *region.at(x, y) = 255;
      }
  }
  Buffers buffers() const {
    Buffers out;
    out.codes = &codes;
    out.linear = &linear;
    out.ids = &ids;
    out.depth = &depth;
    return out;
  }
  ScoreInput input(const Everything& test) const {
    ScoreInput out{buffers(), test.buffers()};
    out.region = &region;
    out.display = &display;
    out.fps = 30;
    return out;
  }
};

TEST(Registry, EveryScoreSaysWhatItIs) {
  std::set<std::string_view> names;
  std::set<std::string_view> maps;
  size_t ranking = 0;
  size_t by_cause = 0;
  ASSERT_GE(scores().size(), 14U);
  for (const Score* score : scores()) {
    SCOPED_TRACE(score->name);
    EXPECT_FALSE(score->name.empty());
    EXPECT_EQ(score->name.find_first_not_of("abcdefghijklmnopqrstuvwxyz0123456789_"), std::string_view::npos);
    EXPECT_TRUE(names.insert(score->name).second) << "twice";
    EXPECT_FALSE(score->title.empty());
    EXPECT_FALSE(score->column.empty());
    EXPECT_LE(score->column.size(), 9U);
    EXPECT_FALSE(score->computes.empty());
    EXPECT_LT(score->least, score->greatest);
    EXPECT_NE(score->needs, 0U);
    EXPECT_TRUE(score->compute != nullptr || score->over_time != nullptr);
    EXPECT_EQ((score->needs & kNeedsFrames) != 0, score->compute == nullptr);
    if (!score->map_file.empty()) {
      EXPECT_TRUE(maps.insert(score->map_file).second) << "two scores write one file";
    }
    ranking += (score->uses & kRanking) != 0 ? 1 : 0;
    by_cause += (score->uses & kByCause) != 0 ? 1 : 0;
  }
  EXPECT_EQ(ranking, 1U);
  EXPECT_EQ(by_cause, 1U);
  EXPECT_NE(ranking_score(scores()).uses & kRanking, 0U);
  EXPECT_EQ(&ranking_score(scores().first(1)), scores()[0]) << "a table without one ranks by its first";
}

// Identity and direction of every score of the table: equal pictures score the best there is, others less, inside the
// range.
TEST(Registry, EqualPicturesScoreTheBestAndOthersWorse) {
  const Everything a;
  Everything b;
  b.codes = noise(200, 190, 2);
  for (float& v : b.linear.data) v = 0.5F;
  // Two pixels of the agent are missing in the test, one of them inside; one lies elsewhere; and depths are off.
  *b.ids.at(60, 50) = 0;
  *b.ids.at(61, 51) = 0;
  *b.ids.at(20, 50) = 3;
  for (float& v : b.depth.data) v += 1;
  Shared of_same;
  Shared of_other;
  const auto same = score_pictures(scores(), a.input(a), of_same);
  const auto other = score_pictures(scores(), a.input(b), of_other);
  ASSERT_EQ(same.size(), scores().size() - 1) << "all but flicker, which needs frames";
  ASSERT_EQ(other.size(), same.size());
  for (size_t i = 0; i < same.size(); ++i) {
    const Score& score = *same[i].score;
    SCOPED_TRACE(score.name);
    ASSERT_TRUE(same[i].result.value) << same[i].result.reason;
    if (std::isinf(best_value(score))) {
      EXPECT_EQ(*same[i].result.value, best_value(score));
    } else {
      EXPECT_NEAR(*same[i].result.value, best_value(score), 1e-9);
    }
    ASSERT_TRUE(other[i].result.value) << other[i].result.reason;
    if (score.name == "boundary_px_p95") continue;  // three pixels do not move it
    EXPECT_TRUE(is_worse(score, *other[i].result.value, *same[i].result.value)) << *other[i].result.value;
    EXPECT_GE(*other[i].result.value, score.least);
    EXPECT_LE(*other[i].result.value, score.greatest);
  }
}

// The scores over time that such frames have: all of the table.
TEST(Registry, FramesAreTakenOneByOne) {
  const Everything a;
  Everything b;
  ClipScores still(scores());
  ClipScores flashing(scores());
  for (int t = 0; t < 4; ++t) {
    still.take(a.input(a));
    b.codes = noise(200, 190, static_cast<uint64_t>(10 + t));
    flashing.take(a.input(b));
  }
  const auto of_still = still.finish();
  const auto of_flashing = flashing.finish();
  ASSERT_EQ(of_still.size(), static_cast<size_t>(std::count_if(scores().begin(), scores().end(), [](const Score* s) {
              return s->over_time != nullptr;
            })));
  for (size_t i = 0; i < of_still.size(); ++i) {
    const Score& score = *of_still[i].score;
    EXPECT_EQ(of_still[i].result.value, best_value(score)) << score.name;
    EXPECT_TRUE(is_worse(score, of_flashing[i].result.value.value(), best_value(score))) << score.name;
  }
  EXPECT_EQ(still.frames(), 4U);
  ClipScores two(scores());
  two.take(a.input(a));
  two.take(a.input(a));
  for (const Scored& one : two.finish()) {
    if (one.score->name != "flicker") continue;
    EXPECT_FALSE(one.result.value);
    EXPECT_NE(one.result.reason.find("three frames"), std::string::npos);
  }
}

TEST(Registry, WhatIsNotAvailableHasItsReasonAndWhatWasNotOfferedIsNotListed) {
  const Everything all;
  ScoreInput input;
  input.reference.linear = input.test.linear = &all.linear;
  Shared shared;
  EXPECT_EQ(score_pictures(scores(), input, shared).size(), 3U) << "linear_mae, linear_rms, hdr_flip";
  const auto with_codes = score_pictures(scores(), input, shared, kNeedsCodes);
  EXPECT_GT(with_codes.size(), 6U);
  for (const Scored& one : with_codes) {
    if ((one.score->needs & kNeedsCodes) == 0) continue;
    EXPECT_FALSE(one.result.value) << one.score->name;
    EXPECT_NE(one.result.reason.find("no 8-bit code values"), std::string::npos);
  }
  // One side alone is not a pair.
  input = {};
  input.reference.ids = &all.ids;
  EXPECT_EQ(given(input), 0U);

  // A pixel that is not a number becomes a reason, never a score.
  ImageF broken = all.linear;
  broken.data[7] = std::numeric_limits<float>::quiet_NaN();
  input = {};
  input.reference.linear = &all.linear;
  input.test.linear = &broken;
  Shared of_broken;
  for (const Scored& one : score_pictures(scores(), input, of_broken)) {
    EXPECT_FALSE(one.result.value) << one.score->name;
    EXPECT_EQ(one.result.reason, "the test has 1 pixel that is not a number, the first at (2, 0)");
  }
}

TEST(Registry, MapsAreAskedForAndPainted) {
  const Everything a;
  Everything b;
  b.codes = noise(200, 190, 2);
  b.linear.data[0] = 1;
  ScoreInput input = a.input(b);
  Shared without;
  for (const Scored& one : score_pictures(scores(), input, without)) EXPECT_FALSE(one.result.map) << one.score->name;
  input.maps = true;
  Shared with;
  size_t maps = 0;
  for (const Scored& one : score_pictures(scores(), input, with)) {
    EXPECT_EQ(one.result.map.has_value(), !one.score->map_file.empty()) << one.score->name;
    if (!one.result.map) continue;
    ++maps;
    EXPECT_NE(one.result.map->equal, one.result.map->worst);
    // Where the score's range goes on behind the bar, the bar says so.
    const bool higher = one.score->direction == Direction::higher_is_better;
    EXPECT_EQ(one.result.map->open,
              higher ? one.score->least < one.result.map->worst : one.score->greatest > one.result.map->worst)
        << one.score->name;
    const Image8 picture = map_picture(*one.score, one.result);
    EXPECT_GE(picture.width, one.result.map->values.width);
  }
  EXPECT_EQ(maps, static_cast<size_t>(std::count_if(scores().begin(), scores().end(), [](const Score* s) {
              return s->compute != nullptr && !s->map_file.empty();
            })));
}

TEST(Registry, ValuesForPeople) {
  Score score;
  score.digits = 2;
  EXPECT_EQ(value_text(score, 1.2345), "1.23");
  EXPECT_EQ(value_text(score, std::nullopt), "-");
  EXPECT_EQ(value_text(score, std::numeric_limits<double>::infinity()), "inf");
  score.name = "silhouette_shape";
  EXPECT_EQ(name_among_silhouettes(score), "shape");
  score.name = "shape";
  EXPECT_EQ(name_among_silhouettes(score), "shape");
  EXPECT_EQ(needs_text(kNeedsCodes | kNeedsDepth), "code values, depth");
  const std::string table = scores_markdown(scores());
  for (const Score* one : scores()) EXPECT_NE(table.find("| `" + std::string(one->name) + "` |"), std::string::npos);
}

TEST(Registry, SharedWorkIsDoneOnce) {
  struct Made {
    int number = 0;
  };
  Shared shared;
  int calls = 0;
  const auto make = [&] { return Made{++calls}; };
  EXPECT_EQ(shared.get<Made>(make).number, 1);
  EXPECT_EQ(shared.get<Made>(make).number, 1);
  EXPECT_EQ(calls, 1);
  const Everything a;
  const ScoreInput input = a.input(a);
  EXPECT_EQ(&luma_pair(input, shared), &luma_pair(input, shared));
  EXPECT_EQ(&similarity(input, shared), &similarity(input, shared));
}

// The threshold that is taken where nobody says one.
TEST(Registry, OneScoreHasAThresholdOfTwoPictures) {
  const Score* score = score_of_threshold(scores());
  ASSERT_NE(score, nullptr);
  EXPECT_EQ(score->name, "cvvdp");
  EXPECT_EQ(score->threshold, 9.5);
  EXPECT_NE(score->compute, nullptr);
  EXPECT_EQ(std::ranges::count_if(scores(), [](const Score* s) { return s->threshold.has_value(); }), 1);
  EXPECT_EQ(score_of_threshold(scores().first(1)), nullptr);
}

// A view of OpenCV is the image's own memory.
TEST(Mat, IsAView) {
  Image8 image(4, 3, 3);
  view(image).at<cv::Vec3b>(2, 1)[0] = 77;
  EXPECT_EQ(image.at(1, 2)[0], 77);
}

// Nobody outside metrics/ spells a score's name: what lists, prints, exports or formats scores walks the table.
TEST(Registry, NamesAreSpelledInMetricsAlone) {
  namespace fs = std::filesystem;
  const fs::path root = CROWDBENCH_SOURCE_DIR;
  size_t files = 0;
  for (const char* room : {"core", "store", "scene", "truth", "renderers", "studies", "reports", "bench"})
    for (const auto& entry : fs::recursive_directory_iterator(root / room)) {
      const std::string extension = entry.path().extension().string();
      if (extension != ".h" && extension != ".cpp" && extension != ".html" && extension != ".js") continue;
      ++files;
      std::ifstream file(entry.path(), std::ios::binary);
      const std::string text{std::istreambuf_iterator<char>(file), {}};
      for (const Score* score : scores())
        for (const std::string& quoted :
             {'"' + std::string(score->name) + '"', '"' + std::string(score->name) + '=',
              "{{" + std::string(score->name) + "}}", "{{#" + std::string(score->name) + "}}"})
          EXPECT_EQ(text.find(quoted), std::string::npos) << entry.path() << " spells " << quoted;
    }
  EXPECT_GT(files, 100U) << "the walk found the tree";
}

}  // namespace
}  // namespace crowdbench::metrics
