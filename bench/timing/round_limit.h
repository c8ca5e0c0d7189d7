// Interleaved timing that ends in time: where a whole run's time is over, in the midst of a point's rounds.
#pragma once
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "bench/timing/timing.h"

namespace crowdbench::bench {

struct RoundLimit {
  // Whether so many nanoseconds more of wall time may be taken. Asked between the rounds of the warm-up for `fewest`
  // timed rounds, and before each timed round for that one, each as long as the last was: at the first no the timing
  // ends with the rounds that there are, also below TimingPlan::least_rounds. Empty: always.
  std::function<bool(int64_t ns)> fits;
  int fewest = 1;  // timed rounds, at least 1: the fewest that are of use to who asked
};

// time_interleaved() within a limit: every variant that was not dropped has the same rounds, which may be none.
std::vector<VariantTimes> time_interleaved(std::span<const Variant> variants, const TimingPlan& plan,
                                           const RoundLimit& limit, const Clocks& clocks,
                                           const std::optional<GpuTimer>& gpu = {},
                                           const std::function<void()>& after_round = {});

}  // namespace crowdbench::bench
