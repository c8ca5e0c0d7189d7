// Frame times of several variants, a frame of each a round in random order, so that drift hits all alike.
//
// Based on: google/benchmark's random interleaving of repetitions (docs/random_interleaving.md), with every variant
// once a round, so that times of one round make pairs.
//
// Nothing here knows OpenGL: a variant is a function that draws one finished frame, and the clocks are handed in, so
// that the logic is tested without a clock and without sleeping.
#pragma once
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/statistics.h"
#include "store/store.h"

namespace crowdbench::bench {

// Nanoseconds since any fixed moment; never decreasing.
struct Clocks {
  std::function<int64_t()> wall;
  std::function<int64_t()> cpu;       // all threads of this process
  std::function<int64_t()> main_cpu;  // the calling thread
};
// CLOCK_MONOTONIC, CLOCK_PROCESS_CPUTIME_ID, CLOCK_THREAD_CPUTIME_ID.
Clocks system_clocks();
// Nanoseconds of wall time that reading all clocks around an empty frame appears to take: the median of `readings`.
double timer_cost_ns(const Clocks& clocks, int readings = 201);

// A timer on the GPU around one frame, for drivers that passed the self-test; without one, gpu_ns is absent.
struct GpuTimer {
  std::function<void()> begin;
  std::function<int64_t()> end;  // nanoseconds; waits for the result
};

struct Variant {
  std::string name;
  // Not timed: makes the frame of this tick (poses, placement). May be empty.
  std::function<void(uint64_t tick)> prepare;
  // Timed: from a frame in hand to finished colour and depth (the GPU waited for).
  std::function<void()> draw;
};

// Which time decides when the warm-up has settled and when the budget is passed.
enum class Metric : uint8_t { cpu, wall, gpu };
const char* metric_name(Metric metric);

// Of the bootstrap intervals of everything that is timed.
inline constexpr uint64_t kBootstrapSeed = 1;
// Unless asked otherwise, every run draws its rounds in the same order as every other.
inline constexpr uint64_t kOrderSeed = 1;
// The order of one round's frames: the numbers 0 to variants - 1, each once, every order as likely as any other. A hash
// of its arguments. Were the order the same in all rounds, each variant would always find the caches, the clock rate
// and the driver's queue as one and the same other left them.
std::vector<size_t> round_order(uint64_t seed, int round, size_t variants);

struct TimingPlan {
  int rounds = 20;        // timed rounds of every variant
  int least_rounds = 20;  // fewer than `rounds` only because of time_limit_ns
  int least_warmup = 2;   // frames of the exact state, not kept
  int most_warmup = 12;   //
  double settled = 0.05;  // the warm-up ends when the running median moves by less than this fraction
  Metric metric = Metric::cpu;
  // Wall time for the warm-up and for the timed rounds, each: the warm-up stops settling and the rounds stop repeating
  // beyond it, never below least_warmup and least_rounds. 0: no limit.
  int64_t time_limit_ns = 0;
  // A variant whose warm-up frames pass this wall time twice is dropped before the timed rounds. 0: no limit.
  int64_t drop_above_ns = 0;
  uint64_t first_tick = 0;
  // Of the order in which the variants of a round are drawn (round_order).
  uint64_t order_seed = kOrderSeed;
};

struct VariantTimes {
  std::vector<SampleRow> samples;  // one a round; every variant that was not dropped has the same rounds and ticks
  int warmup_frames = 0;
  bool settled = false;
  bool dropped = false;         // passed drop_above_ns; no samples
  int64_t warmup_frame_ns = 0;  // wall time of its last warm-up frame
};

// Warms every variant up, in rounds in the order given, then draws round after round: C A D B, B A C D, ..., each
// variant once a round, in the round's own order (round_order), one tick a round, the same tick for all. `after_round`
// is called between rounds (progress, the wish to stop). Throws whatever the variants throw.
std::vector<VariantTimes> time_interleaved(std::span<const Variant> variants, const TimingPlan& plan,
                                           const Clocks& clocks, const std::optional<GpuTimer>& gpu = {},
                                           const std::function<void()>& after_round = {});

// Whether the running median (of all but the first frame) moved by less than `fraction` with the latest frame.
// Needs at least three frames.
bool has_settled(std::span<const double> frames, double fraction);

// One metric of every sample, in nanoseconds; empty when any sample lacks it.
std::vector<double> values_of(std::span<const SampleRow> samples, Metric metric);
// Median with its bootstrap interval (by blocks of successive rounds where these are alike) and percentiles. At least
// one value, in the order measured.
TimeSummary summarise_times(std::span<const double> times_ns, uint64_t seed);
// The median of the paired ratios numerator / denominator over the rounds that both have; std::nullopt when there are
// none or the metric is not available. Times of 0 (a clock too coarse) leave their pair out. The interval keeps its
// coverage where successive rounds are alike (core/block_bootstrap.h).
std::optional<MedianRatio> paired_ratio(std::span<const SampleRow> numerator, std::span<const SampleRow> denominator,
                                        Metric metric, uint64_t seed);
// The ratios themselves, one a round in which both took time, in order; empty as above.
std::vector<double> ratios_by_round(std::span<const SampleRow> numerator, std::span<const SampleRow> denominator,
                                    Metric metric);
// Fills the time columns and the samples of a row.
void put_times(MeasurementRow& row, const VariantTimes& times, uint64_t seed);

}  // namespace crowdbench::bench
