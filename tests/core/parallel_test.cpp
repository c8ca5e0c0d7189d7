#include "core/parallel.h"

#include <gtest/gtest.h>

#include <atomic>
#include <stdexcept>
#include <thread>
#include <vector>

namespace crowdbench {
namespace {

TEST(Parallel, DoesEveryItemOnceAndReportsFromTheCaller) {
  for (const unsigned threads : {0U, 1U, 5U}) {
    std::vector<std::atomic<int>> times(1000);
    const auto caller = std::this_thread::get_id();
    size_t last = 0;
    parallel_for(
        times.size(), threads, [&](size_t i) { ++times[i]; },
        [&](size_t done) {
          EXPECT_EQ(std::this_thread::get_id(), caller);
          EXPECT_GE(done, last);
          last = done;
        });
    for (const auto& n : times) EXPECT_EQ(n, 1) << threads << " threads";
    if (threads == 1) {
      EXPECT_EQ(last, times.size());
    }
  }
  parallel_for(0, 4, [](size_t) { FAIL() << "nothing to do"; });
}

TEST(Parallel, AFaultEndsTheWorkAndIsThrownToTheCaller) {
  for (const unsigned threads : {1U, 4U}) {
    std::atomic<size_t> done = 0;
    const auto work = [&](size_t i) {
      if (i == 10) throw std::runtime_error("ten");
      ++done;
    };
    EXPECT_THROW(parallel_for(1000, threads, work), std::runtime_error);
    if (threads == 1) {
      EXPECT_EQ(done, 10U) << "nothing after it";
    }
  }
  // One from the report ends it too.
  EXPECT_THROW(parallel_for(
                   100, 1, [](size_t) {}, [](size_t) { throw std::runtime_error("stopped"); }),
               std::runtime_error);
}

}  // namespace
}  // namespace crowdbench
