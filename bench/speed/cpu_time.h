// What the speed programs measure with.
#pragma once
#include <algorithm>
#include <ctime>
#include <vector>

namespace crowdbench::bench {

// Of this process, all its threads.
inline double cpu_seconds() {
  timespec now{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

// The upper one of an even number; there is at least one.
inline double median(std::vector<double> values) {
  std::ranges::sort(values);
  return values.at(values.size() / 2);
}

}  // namespace crowdbench::bench
