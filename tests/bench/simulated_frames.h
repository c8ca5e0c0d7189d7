// Simulated frame times: what a machine does to frames that all take the same. A drift that all variants of a round
// share and that successive rounds share, noise of each frame, and now and then a hitch.
#pragma once
#include <cmath>
#include <cstdint>
#include <vector>

#include "core/random.h"
#include "store/rows.h"

namespace crowdbench::test {

struct SimulatedMachine {
  double noise = 0.02;    // standard deviation of the logarithm of a frame's time
  double drift = 0.05;    // of that of a round, which is half the one before and half its own
  double hitches = 0.02;  // of frames, which take up to twice as long
};

// By Box and Muller.
inline double simulated_normal(uint64_t seed, uint64_t index, uint64_t purpose) {
  const double radius = std::sqrt(-2 * std::log(1 - random_unit(seed, index, purpose)));
  return radius * std::cos(2 * 3.14159265358979323846 * random_unit(seed, index, purpose + 0x1000));
}

// Times of `factors.size()` variants in the same `rounds`: factors times a millisecond times what the machine does.
inline std::vector<std::vector<SampleRow>> simulated_rounds(const std::vector<double>& factors, int rounds,
                                                            uint64_t seed, const SimulatedMachine& machine = {}) {
  std::vector<std::vector<SampleRow>> all(factors.size());
  double drift = 0;
  for (int round = 0; round < rounds; ++round) {
    drift = 0.5 * drift + machine.drift * simulated_normal(seed, static_cast<uint64_t>(round), 1);
    for (size_t v = 0; v < factors.size(); ++v) {
      const uint64_t index = static_cast<uint64_t>(round) * factors.size() + v;
      const double hitch = random_unit(seed, index, 2) < machine.hitches ? 1 + random_unit(seed, index, 3) : 1;
      const double time = 1e6 * factors[v] * hitch * std::exp(drift + machine.noise * simulated_normal(seed, index, 4));
      SampleRow sample;
      sample.round = round;
      sample.tick = static_cast<uint64_t>(round);
      sample.frame_ns = sample.cpu_ns = sample.main_cpu_ns = std::llround(time);
      all[v].push_back(sample);
    }
  }
  return all;
}

}  // namespace crowdbench::test
