// Work in a child process, and whatever ends it.
#include "scene/assimp/isolated.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <atomic>
#include <cstdlib>
#include <memory>
#include <new>
#include <string>
#include <vector>

#include "tests/support/sanitized.h"

namespace crowdbench::scene {
namespace {

TEST(Isolated, GivesBackWhatIsWritten) {
  const IsolatedOutput out = run_isolated("test", [](int fd) { ASSERT_EQ(::write(fd, "abc", 3), 3); });
  EXPECT_EQ(std::string(out.bytes.begin(), out.bytes.end()), "abc");
  EXPECT_EQ(out.failure, "");
}

TEST(Isolated, SurvivesWhateverEndsTheChild) {
  EXPECT_EQ(run_isolated("test", [](int) { std::abort(); }).failure, "crashes its reader (signal 6)");
  EXPECT_EQ(run_isolated("test", [](int) { throw std::bad_alloc(); }).failure, "needs more than 2048 MiB to be read");
  EXPECT_EQ(run_isolated("test", [](int) { throw 7; }).failure, "ends its reader (status 70)");
  const auto endless = [](int) {
    for (std::atomic<int> i = 0;;) ++i;
  };
  IsolationLimits limits;
  limits.cpu_seconds = 1;
  EXPECT_EQ(run_isolated("test", endless, limits).failure, "takes more than 1 s to be read");
  const auto wordy = [](int fd) { ASSERT_EQ(::write(fd, "abc", 3), 3); };
  limits.output_bytes = 2;
  EXPECT_EQ(run_isolated("test", wordy, limits).failure, "becomes more than 0 MiB");
}

TEST(Isolated, AStandstillEnds) {
  IsolationLimits limits;
  limits.idle_seconds = 1;
  const auto waiting = [](int) { ::pause(); };
  EXPECT_EQ(run_isolated("test", waiting, limits).failure, "stands still in its reader");
}

TEST(Isolated, MemoryIsBounded) {
  if (support::kSanitized) GTEST_SKIP() << "a sanitizer ends the process where memory ends";
  const auto greedy = [](int) {
    std::vector<std::unique_ptr<char[]>> all;
    while (true) all.emplace_back(new char[size_t{64} << 20]);  // untouched, so that the machine need not have it
  };
  EXPECT_EQ(run_isolated("test", greedy).failure, "needs more than 2048 MiB to be read");
}

}  // namespace
}  // namespace crowdbench::scene
