#include "core/progress.h"

#include <gtest/gtest.h>

#include <csignal>

#include "core/term_status.h"

namespace crowdbench {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

class ProgressLines : public testing::Test {
 protected:
  ProgressOutput output(bool terminal, size_t columns = 200) {
    return {terminal, columns, [this](std::string_view text) { written_ += text; }, [this] { return now_; }};
  }
  std::string take() { return std::exchange(written_, {}); }
  std::string written_;
  std::chrono::nanoseconds now_ = seconds(1000);
};

TEST_F(ProgressLines, OffATerminalALineEveryTenSecondsWithTheTimeLeft) {
  ProgressBoard board(output(false));
  Progress work("drawing", 100, board);
  now_ += seconds(9);
  work.advance(10);
  EXPECT_EQ(take(), "") << "short work says nothing";
  now_ += seconds(1);
  work.advance(10);
  EXPECT_EQ(take(), "drawing: 20/100, 40 s left\n");
  now_ += seconds(9);
  work.advance(1);
  work.note("frame 21");
  EXPECT_EQ(take(), "");
  now_ += seconds(1);
  board.show();  // as the board's own thread does while the work reports nothing
  EXPECT_EQ(take(), "drawing: 21/100, frame 21, 1 min 15 s left\n");
}

TEST_F(ProgressLines, WhatNobodyKnowsTheLengthOfSaysHowLongItTookSoFar) {
  ProgressBoard board(output(false));
  Progress work("solving", 0, board);
  now_ += seconds(75);
  board.show();
  EXPECT_EQ(take(), "solving: 1 min 15 s so far\n");
  work.expect(130);
  now_ += seconds(10);
  board.show();
  EXPECT_EQ(take(), "solving: 2 min left\n") << "what the work itself expects counts down";
}

// A piece that the estimate of the whole did not know: the first bake of an export.
TEST_F(ProgressLines, TheWholeTakesNoLessThanAPieceOfIt) {
  ProgressBoard board(output(false));
  Progress outer("study export", 56, board);
  outer.expect(20);
  {
    Progress inner("baking", 300, board);
    now_ += seconds(10);
    inner.advance(100);
    board.show();
    EXPECT_EQ(take(), "study export: 0/56, 20 s left; baking: 100/300, 20 s left\n");
    now_ += seconds(20);
    board.show();
    EXPECT_EQ(take(), "study export: 0/56, 1 min left; baking: 100/300, 1 min left\n");
  }
  now_ += seconds(10);
  outer.expect(30);
  board.show();
  EXPECT_EQ(take(), "study export: 0/56, 30 s left\n");
}

TEST_F(ProgressLines, WorkWithinWorkIsOneLine) {
  ProgressBoard board(output(false));
  Progress outer("bench", 12, board);
  outer.set_done(3);
  now_ += seconds(30);
  {
    Progress inner("baking flat", 300, board);
    now_ += seconds(4);
    inner.advance(200);
    board.show();
    EXPECT_EQ(take(), "bench: 3/12, 1 min 42 s left; baking flat: 200/300, 2 s left\n");
  }
  now_ += seconds(10);
  board.show();
  EXPECT_EQ(take(), "bench: 3/12, 2 min 12 s left\n");
  outer.end();
  now_ += seconds(60);
  board.show();
  EXPECT_EQ(take(), "") << "nothing goes on";
}

TEST_F(ProgressLines, ShortPiecesOneAfterTheOtherAreNotSilent) {
  ProgressBoard board(output(false));
  for (int piece = 0; piece < 3; ++piece) {
    Progress work("piece", 0, board);
    now_ += seconds(6);
    board.show();
  }
  EXPECT_EQ(take(), "piece: 6 s so far\n") << "one line, 12 s after the first began";
}

TEST_F(ProgressLines, OnATerminalOneLineIsRewrittenAndGoesAway) {
  ProgressBoard board(output(true));
  {
    Progress work("drawing", 3, board);
    now_ += seconds(2);
    work.advance();
    EXPECT_EQ(take(), "\r\x1b[Kdrawing: 1/3, 4 s left");
    now_ += milliseconds(50);
    work.advance();
    EXPECT_EQ(take(), "") << "no more than ten a second";
    work.say("a line that stays");
    EXPECT_EQ(take(), "\r\x1b[Ka line that stays\n\r\x1b[Kdrawing: 2/3, 1 s left");
  }
  EXPECT_EQ(take(), "\r\x1b[K");
}

TEST_F(ProgressLines, ANarrowTerminalIsNotWrapped) {
  ProgressBoard board(output(true, 20));
  Progress work("a label that is longer than that", 3, board);
  now_ += seconds(2);
  work.advance();
  EXPECT_EQ(take(), "\r\x1b[Ka label that is ...");
}

TEST(DurationText, IsWhatAPersonWouldSay) {
  EXPECT_EQ(duration_text(0.2), "1 s");
  EXPECT_EQ(duration_text(59.4), "59 s");
  EXPECT_EQ(duration_text(60), "1 min");
  EXPECT_EQ(duration_text(200), "3 min 20 s");
  EXPECT_EQ(duration_text(3600), "1 h");
  EXPECT_EQ(duration_text(7510), "2 h 5 min");
}

// ---- signals

// Each in a process of its own, which the signal ends.
int status_after(int signal_number, int term_status) {
  install_interrupt_handler();
  if (interrupt_status() != 0) return 1;
  say_when_interrupted("three of five are in x");
  set_term_status(term_status);
  std::raise(signal_number);
  if (!interrupted() || interrupt_line() != "crowdbench: interrupted; three of five are in x\n") return 2;
  return interrupt_status();
}

TEST(SignalsDeathTest, SigtermHasTheStatusThatASchedulerShallSee) {
  ::testing::FLAGS_gtest_death_test_style = "threadsafe";
  EXPECT_EXIT(std::_Exit(status_after(SIGTERM, 75)), ::testing::ExitedWithCode(75), "");
  EXPECT_EXIT(std::_Exit(status_after(SIGINT, 75)), ::testing::ExitedWithCode(128 + SIGINT), "");
  EXPECT_EXIT(std::_Exit(status_after(SIGTERM, 0)), ::testing::ExitedWithCode(128 + SIGTERM), "");
}

TEST(SignalsDeathTest, TheSecondKillsAtOnce) {
  ::testing::FLAGS_gtest_death_test_style = "threadsafe";
  EXPECT_EXIT(
      {
        status_after(SIGTERM, 75);
        std::raise(SIGTERM);
      },
      ::testing::KilledBySignal(SIGTERM), "");
}

}  // namespace
}  // namespace crowdbench
