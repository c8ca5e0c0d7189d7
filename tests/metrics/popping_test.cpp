#include "metrics/popping.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <string>

#include "core/error.h"
#include "core/random.h"
#include "metrics/discontinuity.h"
#include "tests/metrics/ground_truth.h"

namespace crowdbench::metrics {
namespace {

Image8 grey(int width, int height, uint8_t value) {
  Image8 out(width, height, 3);
  std::fill(out.data.begin(), out.data.end(), value);
  return out;
}

void fill(Image8& image, const Box& box, uint8_t value) {
  for (int y = box.y; y < box.y + box.height; ++y)
    for (int x = box.x; x < box.x + box.width; ++x) std::fill_n(image.at(x, y), image.channels, value);
}

ImageU32 ids_of(int width, int height, const Box& box, uint32_t id) {
  ImageU32 out(width, height, 1);
  for (int y = box.y; y < box.y + box.height; ++y)
    for (int x = box.x; x < box.x + box.width; ++x) *out.at(x, y) = id;
  return out;
}

size_t place_of(std::string_view name) {
  const auto scores = pop_scores();
  for (size_t s = 0; s < scores.size(); ++s)
    if (scores[s].name == name) return s;
  ADD_FAILURE() << "no score " << name;
  return 0;
}

double value(const Pop& pop, std::string_view name) { return pop.values.at(place_of(name)).value(); }

const PopView kView{&default_display(), true, 30};

// A figure of 6 x 4 pixels that grows brighter by ten.
struct Figure {
  Box box{60, 50, 6, 4};
  Image8 before = grey(160, 120, 100), held = before, shown = before;
  ImageU32 ids = ids_of(160, 120, box, 7);
  std::optional<Pop> pop(uint32_t id = 7) const { return score_pop({&before, &shown, &held, &ids, &ids}, id, kView); }
};

TEST(Popping, EqualFramesDoNotPopHoweverMuchMoves) {
  Figure f;
  fill(f.held, {50, 40, 30, 30}, 180);
  f.shown = f.held;
  const Pop pop = f.pop().value();
  for (size_t s = 0; s < pop_scores().size(); ++s)
    EXPECT_EQ(pop.values[s], pop_scores()[s].equal) << pop_scores()[s].name;
}

TEST(Popping, ByHand) {
  Figure f;
  fill(f.shown, f.box, 110);
  Pop pop = f.pop().value();
  EXPECT_EQ(pop.pixels, 24U);
  const int margin = pop_margin(kView);
  EXPECT_EQ(margin, 38) << "half a degree of 75.4 pixels";
  EXPECT_EQ(pop.box.x, 60 - margin);
  EXPECT_EQ(pop.box.height, 4 + 2 * margin);
  EXPECT_NEAR(value(pop, "pop_luma"), 10, 1e-9);
  EXPECT_NEAR(value(pop, "pop_excess"), 10, 1e-9);
  EXPECT_GT(value(pop, "pop_flip"), 0.005);
  EXPECT_NEAR(value(pop, "pop_flip"), value(pop, "pop_flip_excess"), 1e-9) << "nothing moves";
  EXPECT_LT(value(pop, "pop_cvvdp_stay"), value(pop, "pop_cvvdp"));
  EXPECT_LT(value(pop, "pop_cvvdp"), 10);
  // A step back to where the figure was: motion is hidden, and the switch is seen.
  f.held = f.shown;
  f.shown = f.before;
  pop = f.pop().value();
  EXPECT_NEAR(value(pop, "pop_luma"), 10, 1e-9);
  EXPECT_NEAR(value(pop, "pop_excess"), -10, 1e-9);
  EXPECT_GT(value(pop, "pop_flip"), 0.005);
}

TEST(Popping, OfOneAgentWhateverOthersDo) {
  Figure f;
  fill(f.shown, f.box, 110);
  const Pop alone = f.pop().value();
  fill(f.shown, {110, 50, 20, 20}, 250);
  const Pop among_others = f.pop().value();
  EXPECT_EQ(alone.values, among_others.values);
  EXPECT_FALSE(f.pop(8)) << "no pixel has that id";
  // Pixels that carry the id on one side only count too: here two columns more, which stay as they are.
  const ImageU32 wider = ids_of(160, 120, {60, 50, 8, 4}, 7);
  const Pop either = score_pop({&f.before, &f.shown, &f.held, &f.ids, &wider}, 7, kView).value();
  EXPECT_EQ(either.pixels, 32U);
  EXPECT_NEAR(value(either, "pop_luma"), 7.5, 1e-9);
}

TEST(Popping, MoreIsWorse) {
  Figure f;
  fill(f.shown, f.box, 110);
  const Pop less = f.pop().value();
  fill(f.shown, f.box, 140);
  const Pop more = f.pop().value();
  for (size_t s = 0; s < pop_scores().size(); ++s)
    EXPECT_TRUE(is_worse(pop_scores()[s], *more.values[s], *less.values[s])) << pop_scores()[s].name;
}

TEST(Popping, RefusesSizesThatDiffer) {
  Figure f;
  f.held = grey(160, 119, 100);
  EXPECT_THROW((void)f.pop(), Error);
}

TEST(Popping, EveryScoreIsDocumented) {
  const std::string text = pop_scores_markdown();
  EXPECT_GE(pop_scores().size(), 3U);
  for (const PopScore& score : pop_scores()) {
    EXPECT_NE(text.find(fmt::format("`{}`", score.name)), std::string::npos);
    EXPECT_LE(score.column.size(), 9U);
  }
}

// ---- the sequence with a pop at frame 8

std::vector<Image8> frames_of(const nlohmann::json& sequence, const char* side) {
  std::vector<Image8> frames;
  for (size_t t = 0; t < sequence["frames"].get<size_t>(); ++t)
    frames.push_back(picture(kShared / fmt::format("sequence/{}_{:02}.png", side, t)));
  return frames;
}

// By outside tools: the frame without the switch is the reference's, which is equal up to frame 7.
TEST(PoppingGroundTruth, OfTheSwitchAtFrameEight) {
  if (!std::filesystem::exists(kShared)) GTEST_SKIP() << "needs the shared ground-truth folder";
  const nlohmann::json sequence = expected_of(kShared)["sequence"];
  const std::vector<Image8> reference = frames_of(sequence, "ref");
  const std::vector<Image8> test = frames_of(sequence, "test");
  const auto pop_frame = sequence["true_pop_frame"].get<size_t>();
  const Box all{0, 0, test[0].width, test[0].height};
  const ImageU32 ids = ids_of(all.width, all.height, all, 1);
  for (size_t t = 1; t < test.size(); ++t) {
    // The switch lasts; only in its frame does the look of the frame before differ.
    const Image8& held = t == pop_frame ? reference[t] : test[t];
    const Pop pop = score_pop({&test[t - 1], &test[t], &held, &ids, &ids}, 1, kView).value();
    if (t != pop_frame) {
      for (size_t s = 0; s < pop_scores().size(); ++s) EXPECT_EQ(pop.values[s], pop_scores()[s].equal) << t;
      continue;
    }
    const nlohmann::json& expected = sequence["per_frame"][t];
    const auto number = [&](const char* key) { return expected[key].get<double>(); };
    EXPECT_NEAR(value(pop, "pop_luma"), number("temporal_diff_error"), 1e-6);
    EXPECT_NEAR(value(pop, "pop_excess"), number("mad_luma_test_t_vs_prev") - number("mad_luma_ref_t_vs_prev"), 1e-6);
    EXPECT_NEAR(value(pop, "pop_flip"), number("flip_mean"), 2e-4);
    EXPECT_NEAR(value(pop, "pop_flip_excess"), number("flip_test_t_vs_prev") - number("flip_ref_t_vs_prev"), 4e-4);
    EXPECT_LT(value(pop, "pop_cvvdp"), 9.8);
    EXPECT_LT(value(pop, "pop_cvvdp_stay"), 9);
  }
}

std::vector<Jump> jumps_of(const std::vector<Image8>& frames, unsigned threads = 0) {
  Discontinuities discontinuities(threads);
  for (const Image8& frame : frames) discontinuities.take(luma601(frame));
  return discontinuities.finish();
}

std::vector<size_t> found_in(const std::vector<Image8>& frames) {
  std::vector<size_t> found;
  for (const Jump& jump : jumps_of(frames))
    if (jump.found) found.push_back(jump.frame);
  return found;
}

TEST(PoppingGroundTruth, IsFoundFromThePicturesAlone) {
  if (!std::filesystem::exists(kShared)) GTEST_SKIP() << "needs the shared ground-truth folder";
  const nlohmann::json sequence = expected_of(kShared)["sequence"];
  const std::vector<Image8> test = frames_of(sequence, "test");
  EXPECT_EQ(found_in(test), std::vector<size_t>{sequence["true_pop_frame"].get<size_t>()});
  EXPECT_TRUE(found_in(frames_of(sequence, "ref")).empty()) << "it pans, and nothing pops";
  const std::vector<Jump> once = jumps_of(test, 1);
  const std::vector<Jump> again = jumps_of(test, 3);
  for (size_t i = 0; i < once.size(); ++i) EXPECT_EQ(once[i].jump, again[i].jump) << "whatever the threads";
}

// A figure of noise that walks three pixels a frame over grey; from frame `pop` on it is another one.
std::vector<Image8> walking(size_t frames, size_t pop) {
  std::vector<Image8> out;
  for (size_t t = 0; t < frames; ++t) {
    Image8 frame = grey(160, 64, 100);
    for (int y = 20; y < 44; ++y)
      for (int x = 0; x < 16; ++x) {
        const uint64_t noise = random_below(t >= pop ? 2 : 1, static_cast<uint64_t>(100 * y + x), 0, 64);
        std::fill_n(frame.at(static_cast<int>(3 * t) + 10 + x, y), 3, static_cast<uint8_t>(60 + noise));
      }
    out.push_back(std::move(frame));
  }
  return out;
}

TEST(Discontinuity, MotionIsNone) {
  EXPECT_TRUE(found_in(walking(12, 99)).empty());
  const std::vector<Jump> jumps = jumps_of(walking(12, 99));
  ASSERT_EQ(jumps.size(), 11U);
  EXPECT_GT(jumps[4].change, 0.5) << "it moves";
  EXPECT_LT(jumps[4].left, jumps[4].change / 4) << "which is explained";
}

TEST(Discontinuity, AnotherFigureInItsPlaceIsOne) {
  for (const size_t pop : {2U, 6U, 9U}) EXPECT_EQ(found_in(walking(12, pop)), std::vector<size_t>{pop});
}

TEST(Discontinuity, NeedsThreeFramesOfOneSize) {
  EXPECT_TRUE(jumps_of({}).empty());
  EXPECT_TRUE(jumps_of({grey(16, 16, 0)}).empty());
  const std::vector<Jump> two = jumps_of({grey(16, 16, 0), grey(16, 16, 200)});
  ASSERT_EQ(two.size(), 1U);
  EXPECT_EQ(two[0].change, 200);
  EXPECT_EQ(two[0].jump, 0) << "nothing to compare the step with";
  EXPECT_FALSE(two[0].found);
  Discontinuities discontinuities;
  discontinuities.take(luma601(grey(16, 16, 0)));
  EXPECT_THROW(discontinuities.take(luma601(grey(16, 24, 0))), Error);
}

}  // namespace
}  // namespace crowdbench::metrics
