#include "bench/timing/timing.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <ctime>
#include <numeric>
#include <utility>

#include "bench/timing/round_limit.h"
#include "core/block_bootstrap.h"
#include "core/random.h"

namespace crowdbench::bench {
namespace {

int64_t read_clock(clockid_t id) {
  timespec now{};
  clock_gettime(id, &now);
  return int64_t{now.tv_sec} * 1'000'000'000 + now.tv_nsec;
}

// The clocks are read in the order cpu, main, wall | wall, main, cpu, so that none of the reads counts as wall time.
SampleRow time_frame(const Variant& variant, const Clocks& clocks, const std::optional<GpuTimer>& gpu) {
  SampleRow sample;
  if (gpu) gpu->begin();
  const int64_t cpu = clocks.cpu();
  const int64_t main_cpu = clocks.main_cpu();
  const int64_t wall = clocks.wall();
  variant.draw();
  sample.frame_ns = clocks.wall() - wall;
  sample.main_cpu_ns = clocks.main_cpu() - main_cpu;
  sample.cpu_ns = clocks.cpu() - cpu;
  if (gpu) sample.gpu_ns = gpu->end();
  return sample;
}

double metric_of(const SampleRow& sample, Metric metric) {
  switch (metric) {
    case Metric::cpu: return static_cast<double>(sample.cpu_ns);
    case Metric::wall: return static_cast<double>(sample.frame_ns);
    case Metric::gpu: return static_cast<double>(sample.gpu_ns.value_or(0));
  }
  return 0;
}

}  // namespace

Clocks system_clocks() {
  return {[] { return read_clock(CLOCK_MONOTONIC); }, [] { return read_clock(CLOCK_PROCESS_CPUTIME_ID); },
          [] { return read_clock(CLOCK_THREAD_CPUTIME_ID); }};
}

double timer_cost_ns(const Clocks& clocks, int readings) {
  std::vector<double> costs;
  costs.reserve(static_cast<size_t>(readings));
  const Variant nothing{"", {}, [] {}};
  for (int i = 0; i < readings; ++i) {
    const int64_t before = clocks.wall();
    time_frame(nothing, clocks, {});
    costs.push_back(static_cast<double>(clocks.wall() - before));
  }
  return median(costs);
}

const char* metric_name(Metric metric) {
  switch (metric) {
    case Metric::cpu: return "cpu";
    case Metric::wall: return "wall";
    case Metric::gpu: return "gpu";
  }
  return "cpu";
}

bool has_settled(std::span<const double> frames, double fraction) {
  if (frames.size() < 3) return false;
  const double before = median(frames.subspan(1, frames.size() - 2));
  const double now = median(frames.subspan(1));
  return std::abs(now - before) <= fraction * before;
}

std::vector<size_t> round_order(uint64_t seed, int round, size_t variants) {
  constexpr uint64_t kTurn = 0x7475726e;  // "turn": a purpose of random_below
  std::vector<size_t> order(variants);
  std::iota(order.begin(), order.end(), size_t{0});
  // Fisher and Yates: what is left of the numbers, one drawn for each place from the last on.
  for (size_t left = variants; left > 1; --left) {
    const uint64_t index = (static_cast<uint64_t>(round) << 32) | left;
    std::swap(order[left - 1], order[random_below(seed, index, kTurn, left)]);
  }
  return order;
}

namespace {

// Rounds of several variants: the frames of each, and how long a round takes.
class Rounds {
 public:
  Rounds(std::span<const Variant> variants, const TimingPlan& plan, const RoundLimit& limit, const Clocks& clocks,
         const std::optional<GpuTimer>& gpu, const std::function<void()>& after_round)
      : variants_(variants),
        plan_(plan),
        limit_(limit),
        clocks_(clocks),
        gpu_(gpu),
        after_round_(after_round),
        results_(variants.size()),
        warm_(variants.size()),
        tick_(plan.first_tick) {}

  std::vector<VariantTimes> run() && {
    if (warm_up()) time_rounds();
    return std::move(results_);
  }

 private:
  bool fits(int64_t ns) const { return !limit_.fits || limit_.fits(ns); }
  bool out_of_time(int64_t since) const {
    return plan_.time_limit_ns > 0 && clocks_.wall() - since > plan_.time_limit_ns;
  }

  SampleRow draw(size_t v) {
    if (variants_[v].prepare) variants_[v].prepare(tick_);
    return time_frame(variants_[v], clocks_, gpu_);
  }

  // Returns whether it has settled.
  bool warm_frame(size_t v) {
    VariantTimes& result = results_[v];
    const int64_t last = result.warmup_frame_ns;
    const SampleRow sample = draw(v);
    result.warmup_frame_ns = sample.frame_ns;
    ++result.warmup_frames;
    warm_[v].push_back(metric_of(sample, plan_.metric));
    // Once may be shader compilation or a first touch of memory; twice in a row is the frame.
    result.dropped = plan_.drop_above_ns > 0 && result.warmup_frames >= 2 && sample.frame_ns > plan_.drop_above_ns &&
                     last > plan_.drop_above_ns;
    result.settled = has_settled(warm_[v], plan_.settled);
    return result.settled;
  }

  // The warm-up takes turns too: what one variant leaves in caches and clocks is part of the state of the next. Returns
  // whether there is time for what follows.
  bool warm_up() {
    const int64_t begun = clocks_.wall();
    for (int frame = 0; frame < plan_.most_warmup; ++frame) {
      bool all_settled = true;
      round_ns_ = 0;
      for (size_t v = 0; v < variants_.size(); ++v) {
        if (results_[v].dropped) continue;
        const int64_t before = clocks_.wall();
        const bool settled = warm_frame(v);
        if (results_[v].dropped) continue;
        round_ns_ += clocks_.wall() - before;
        all_settled = all_settled && settled;
      }
      ++tick_;
      if (after_round_) after_round_();
      // The first frames may have compiled: they forecast nothing.
      if (!fits(frame == 0 ? 0 : limit_.fewest * round_ns_)) return false;
      if (frame + 1 >= plan_.least_warmup && (all_settled || out_of_time(begun))) break;
    }
    return true;
  }

  void time_rounds() {
    const int64_t begun = clocks_.wall();
    for (int round = 0; round < plan_.rounds; ++round, ++tick_) {
      if (!fits(round_ns_) || (round >= plan_.least_rounds && out_of_time(begun))) break;
      const int64_t before = clocks_.wall();
      for (const size_t v : round_order(plan_.order_seed, round, variants_.size())) {
        if (results_[v].dropped) continue;
        SampleRow sample = draw(v);
        sample.round = round;
        sample.tick = tick_;
        results_[v].samples.push_back(sample);
      }
      round_ns_ = clocks_.wall() - before;
      if (after_round_) after_round_();
    }
  }

  std::span<const Variant> variants_;
  const TimingPlan& plan_;
  const RoundLimit& limit_;
  const Clocks& clocks_;
  const std::optional<GpuTimer>& gpu_;
  const std::function<void()>& after_round_;
  std::vector<VariantTimes> results_;
  std::vector<std::vector<double>> warm_;  // the metric of each one's warm-up frames
  uint64_t tick_;
  int64_t round_ns_ = 0;  // wall time of the last round, of those not dropped
};

}  // namespace

std::vector<VariantTimes> time_interleaved(std::span<const Variant> variants, const TimingPlan& plan,
                                           const RoundLimit& limit, const Clocks& clocks,
                                           const std::optional<GpuTimer>& gpu,
                                           const std::function<void()>& after_round) {
  assert(plan.least_warmup >= 2 && plan.most_warmup >= plan.least_warmup && plan.rounds >= plan.least_rounds);
  return Rounds(variants, plan, limit, clocks, gpu, after_round).run();
}

std::vector<VariantTimes> time_interleaved(std::span<const Variant> variants, const TimingPlan& plan,
                                           const Clocks& clocks, const std::optional<GpuTimer>& gpu,
                                           const std::function<void()>& after_round) {
  return time_interleaved(variants, plan, RoundLimit{}, clocks, gpu, after_round);
}

std::vector<double> values_of(std::span<const SampleRow> samples, Metric metric) {
  std::vector<double> values;
  values.reserve(samples.size());
  for (const SampleRow& sample : samples) {
    if (metric == Metric::gpu && !sample.gpu_ns) return {};
    values.push_back(metric_of(sample, metric));
  }
  return values;
}

TimeSummary summarise_times(std::span<const double> times_ns, uint64_t seed) {
  const Interval interval = block_bootstrap_median(times_ns, seed);
  return {median(times_ns),        interval.low, interval.high, quantile(times_ns, 0.05), quantile(times_ns, 0.95),
          quantile(times_ns, 0.99)};
}

std::vector<double> ratios_by_round(std::span<const SampleRow> numerator, std::span<const SampleRow> denominator,
                                    Metric metric) {
  std::vector<double> ratios;
  for (size_t i = 0; i < std::min(numerator.size(), denominator.size()); ++i) {
    assert(numerator[i].round == denominator[i].round);
    if (metric == Metric::gpu && (!numerator[i].gpu_ns || !denominator[i].gpu_ns)) return {};
    const double above = metric_of(numerator[i], metric);
    const double below = metric_of(denominator[i], metric);
    if (above > 0 && below > 0) ratios.push_back(above / below);
  }
  return ratios;
}

std::optional<MedianRatio> paired_ratio(std::span<const SampleRow> numerator, std::span<const SampleRow> denominator,
                                        Metric metric, uint64_t seed) {
  const std::vector<double> ratios = ratios_by_round(numerator, denominator, metric);
  if (ratios.empty()) return std::nullopt;
  return MedianRatio{median(ratios), block_bootstrap_median(ratios, seed), ratios.size()};
}

void put_times(MeasurementRow& row, const VariantTimes& times, uint64_t seed) {
  row.samples = times.samples;
  row.rounds = static_cast<int>(times.samples.size());
  row.warmup_frames = times.warmup_frames;
  row.settled = times.settled;
  if (times.samples.empty()) return;
  const std::vector<double> wall = values_of(times.samples, Metric::wall);
  row.frame_ns = summarise_times(wall, seed);
  if (*std::min_element(wall.begin(), wall.end()) > 0) row.low_1_percent_fps = summarise(wall).low_1_percent_fps;
  row.cpu_ns = summarise_times(values_of(times.samples, Metric::cpu), seed);
  std::vector<double> main_cpu;
  for (const SampleRow& sample : times.samples) main_cpu.push_back(static_cast<double>(sample.main_cpu_ns));
  row.main_cpu_ns = summarise_times(main_cpu, seed);
  const std::vector<double> gpu = values_of(times.samples, Metric::gpu);
  if (!gpu.empty()) row.gpu_ns = summarise_times(gpu, seed);
}

}  // namespace crowdbench::bench
