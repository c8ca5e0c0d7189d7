#include "bench/speed/contest.h"

#include <algorithm>

#include "bench/speed/cpu_time.h"

namespace crowdbench::bench {

void run_rounds(std::vector<Contest*> contests, int rounds) {
  for (int round = -1; round < rounds; ++round) {
    for (Contest* contest : contests) {
      const double start = cpu_seconds();
      contest->found = contest->run();
      if (round >= 0) contest->seconds.push_back(cpu_seconds() - start);
    }
    if (!contests.empty()) std::rotate(contests.begin(), contests.begin() + 1, contests.end());
  }
}

}  // namespace crowdbench::bench
