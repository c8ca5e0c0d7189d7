#include "bench/timing/timing.h"

#include <epoxy/gl.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <map>
#include <numeric>
#include <set>
#include <thread>

#include "bench/speed/cpu_time.h"
#include "bench/timing/round_limit.h"
#include "bench/timing/timing_method.h"
#include "renderers/gl/program.h"
#include "renderers/shaders/bindings.shared.h"

namespace crowdbench::bench {
namespace {

// A machine whose clocks only move when something is drawn.
struct FakeMachine {
  int64_t wall = 1000;
  int64_t cpu = 500;
  int64_t main_cpu = 200;
  std::vector<std::string> order;

  Clocks clocks() {
    return {[this] { return wall; }, [this] { return cpu; }, [this] { return main_cpu; }};
  }
  void spend(int64_t wall_ns, int64_t cpu_ns, int64_t main_ns) {
    wall += wall_ns;
    cpu += cpu_ns;
    main_cpu += main_ns;
  }
  Variant variant(const std::string& name, int64_t wall_ns, int64_t cpu_ns) {
    return {name, [this, name](uint64_t tick) { order.push_back("prepare " + name + " " + std::to_string(tick)); },
            [this, name, wall_ns, cpu_ns] {
              order.push_back("draw " + name);
              spend(wall_ns, cpu_ns, cpu_ns / 2);
            }};
  }
};

TEST(RoundOrder, EveryVariantOnceARound) {
  for (const size_t variants : {0U, 1U, 2U, 7U, 40U})
    for (int round = 0; round < 50; ++round) {
      std::vector<size_t> order = round_order(9, round, variants);
      std::sort(order.begin(), order.end());
      std::vector<size_t> wanted(variants);
      std::iota(wanted.begin(), wanted.end(), size_t{0});
      EXPECT_EQ(order, wanted);
    }
}

TEST(RoundOrder, EveryOrderIsAsLikelyAsAnyOther) {
  // 24 orders of four, 250 of 6000 rounds each: within five standard deviations (15.5) of a fair draw.
  std::map<std::vector<size_t>, int> count;
  for (int round = 0; round < 6000; ++round) ++count[round_order(5, round, 4)];
  EXPECT_EQ(count.size(), 24U);
  for (const auto& [order, rounds] : count)
    EXPECT_NEAR(rounds, 250, 78) << order[0] << order[1] << order[2] << order[3];
}

// A recorded seed must give the recorded order on any machine, at any time.
TEST(RoundOrder, IsPinned) {
  using Order = std::vector<size_t>;
  EXPECT_EQ(round_order(1, 0, 5), (Order{0, 4, 3, 2, 1}));
  EXPECT_EQ(round_order(1, 1, 5), (Order{0, 1, 2, 4, 3}));
  EXPECT_EQ(round_order(2, 0, 5), (Order{0, 1, 4, 3, 2}));
}

TEST(Timing, VariantsTakeTurnsOnTheSameTick) {
  FakeMachine machine;
  const std::vector<Variant> variants = {machine.variant("A", 10, 20), machine.variant("B", 30, 40),
                                         machine.variant("C", 50, 60)};
  TimingPlan plan;
  plan.rounds = plan.least_rounds = 8;
  plan.most_warmup = 2;
  plan.first_tick = 7;
  plan.order_seed = 11;
  const auto results = time_interleaved(variants, plan, machine.clocks());
  std::vector<std::string> wanted;
  const auto turn = [&](size_t variant, int tick) {
    wanted.push_back("prepare " + variants[variant].name + " " + std::to_string(tick));
    wanted.push_back("draw " + variants[variant].name);
  };
  for (const int tick : {7, 8})
    for (size_t v = 0; v < 3; ++v) turn(v, tick);
  for (int round = 0; round < 8; ++round)
    for (const size_t v : round_order(11, round, 3)) turn(v, 9 + round);
  EXPECT_EQ(machine.order, wanted);
  ASSERT_EQ(results.size(), 3U);
  EXPECT_EQ(results[0].warmup_frames, 2);
  // Whatever the order, each variant has its own times, by round.
  ASSERT_EQ(results[1].samples.size(), 8U);
  for (int round = 0; round < 8; ++round) {
    const SampleRow& sample = results[1].samples[static_cast<size_t>(round)];
    EXPECT_EQ(sample.round, round);
    EXPECT_EQ(sample.tick, static_cast<uint64_t>(9 + round));
    EXPECT_EQ(sample.frame_ns, 30);
    EXPECT_EQ(sample.cpu_ns, 40);
    EXPECT_EQ(sample.main_cpu_ns, 20);
    EXPECT_FALSE(sample.gpu_ns.has_value());
  }
}

// What runs first after the wait between rounds pays for it: with a fixed order it would always be the same one.
TEST(Timing, NobodyAlwaysRunsFirst) {
  FakeMachine machine;
  std::vector<Variant> variants;
  for (const char* name : {"A", "B", "C"}) variants.push_back(machine.variant(name, 10, 20));
  TimingPlan plan;
  plan.rounds = plan.least_rounds = 30;
  plan.most_warmup = 2;
  std::map<std::string, int> first;
  machine.order.clear();
  bool begins = true;
  for (Variant& variant : variants)
    variant.draw = [&machine, &first, &begins, name = variant.name] {
      if (begins) ++first[name];
      begins = false;
      machine.spend(10, 20, 10);
    };
  time_interleaved(variants, plan, machine.clocks(), {}, [&] { begins = true; });
  for (const char* name : {"A", "B", "C"}) {
    EXPECT_GE(first[name], 4) << name << " of 30 rounds and 2 of the warm-up";
    EXPECT_LE(first[name], 20) << name;
  }
}

// A run whose whole time is over ends between rounds, at a round that would not fit.
TEST(Timing, EndsWhereTheNextRoundWouldNotFit) {
  FakeMachine machine;
  const std::vector<Variant> variants = {machine.variant("A", 100, 100), machine.variant("B", 300, 300)};
  TimingPlan plan;
  plan.rounds = plan.least_rounds = 20;
  plan.most_warmup = 2;
  int64_t end = 0;
  RoundLimit limit;
  limit.fewest = 6;
  limit.fits = [&](int64_t ns) { return machine.wall + ns <= end; };
  const auto rounds_in = [&](int64_t ns) {
    end = machine.wall + ns;
    const auto results = time_interleaved(variants, plan, limit, machine.clocks());
    EXPECT_EQ(results[0].samples.size(), results[1].samples.size());
    EXPECT_LE(machine.wall, end);
    return results[0].samples.size();
  };
  EXPECT_EQ(rounds_in(30 * 400), 20U);
  EXPECT_EQ(rounds_in(10 * 400 + 399), 8U) << "two of the warm-up, below least_rounds";
  EXPECT_EQ(rounds_in(8 * 400), 6U);
  EXPECT_EQ(rounds_in(8 * 400 - 1), 0U) << "not begun where six would not fit";
}

TEST(Timing, PreparationIsNotTimed) {
  FakeMachine machine;
  const std::vector<Variant> variants = {
      {"A", [&](uint64_t) { machine.spend(1'000'000, 1'000'000, 1'000'000); }, [&] { machine.spend(10, 20, 5); }}};
  const auto results = time_interleaved(variants, {}, machine.clocks());
  ASSERT_EQ(results[0].samples.size(), 20U);
  for (const SampleRow& sample : results[0].samples) {
    EXPECT_EQ(sample.frame_ns, 10);
    EXPECT_EQ(sample.cpu_ns, 20);
    EXPECT_EQ(sample.main_cpu_ns, 5);
  }
}

TEST(Timing, GpuTimerSurroundsTheFrame) {
  FakeMachine machine;
  const std::vector<Variant> variants = {machine.variant("A", 10, 20)};
  const GpuTimer gpu{[&] { machine.order.emplace_back("begin"); },
                     [&]() -> int64_t {
                       machine.order.emplace_back("end");
                       return 777;
                     }};
  TimingPlan plan;
  plan.rounds = plan.least_rounds = 1;
  plan.most_warmup = 2;
  const auto results = time_interleaved(variants, plan, machine.clocks(), gpu);
  EXPECT_EQ(results[0].samples.at(0).gpu_ns, 777);
  const std::vector<std::string> last(machine.order.end() - 4, machine.order.end());
  EXPECT_EQ(last, (std::vector<std::string>{"prepare A 2", "begin", "draw A", "end"}));
}

TEST(Timing, TheWarmUpEndsWhenTheRunningMedianHasSettled) {
  // Frames of 100, 50, 20, 10, 10, 10, ...: all but the first: medians 50, 35, 20, 15, 10, 10: settled with the 7th.
  FakeMachine machine;
  std::vector<int64_t> costs = {100, 50, 20, 10};
  size_t drawn = 0;
  const std::vector<Variant> variants = {{"A", {}, [&] {
                                            const int64_t cost = costs[std::min(drawn++, costs.size() - 1)];
                                            machine.spend(cost, cost, cost);
                                          }}};
  const auto results = time_interleaved(variants, {}, machine.clocks());
  EXPECT_TRUE(results[0].settled);
  EXPECT_EQ(results[0].warmup_frames, 7);
  EXPECT_EQ(results[0].samples.size(), 20U);
}

TEST(Timing, AWarmUpThatNeverSettlesEndsAtItsLimitAndSaysSo) {
  FakeMachine machine;
  int64_t cost = 1;
  const std::vector<Variant> variants = {{"A", {}, [&] {
                                            cost *= 2;
                                            machine.spend(cost, cost, cost);
                                          }}};
  TimingPlan plan;
  plan.most_warmup = 9;
  const auto results = time_interleaved(variants, plan, machine.clocks());
  EXPECT_FALSE(results[0].settled);
  EXPECT_EQ(results[0].warmup_frames, 9);
}

TEST(Timing, SettlingByHand) {
  EXPECT_FALSE(has_settled(std::vector<double>{10, 10}, 0.05));
  EXPECT_TRUE(has_settled(std::vector<double>{99, 10, 10}, 0.05));
  EXPECT_FALSE(has_settled(std::vector<double>{99, 10, 12}, 0.05));      // 10 -> 11
  EXPECT_TRUE(has_settled(std::vector<double>{99, 10, 10.9}, 0.05));     // 10 -> 10.45
  EXPECT_TRUE(has_settled(std::vector<double>{1, 10, 11, 10.5}, 0.05));  // 10.5 -> 10.5
}

TEST(Timing, ATimeLimitNeverCutsBelowTheLeastRounds) {
  FakeMachine machine;
  const std::vector<Variant> variants = {machine.variant("A", 100, 100)};
  TimingPlan plan;
  plan.rounds = 50;
  plan.least_rounds = 10;
  plan.time_limit_ns = 1;  // passed at once
  EXPECT_EQ(time_interleaved(variants, plan, machine.clocks())[0].samples.size(), 10U);
  plan.time_limit_ns = 2450;  // frames 1..25 begin before it is passed
  EXPECT_EQ(time_interleaved(variants, plan, machine.clocks())[0].samples.size(), 25U);
  plan.time_limit_ns = 0;
  EXPECT_EQ(time_interleaved(variants, plan, machine.clocks())[0].samples.size(), 50U);
}

TEST(Timing, AVariantTwiceOverTheLimitIsDroppedAndTheOthersGoOn) {
  FakeMachine machine;
  const std::vector<Variant> variants = {machine.variant("A", 1000, 1000), machine.variant("B", 10, 10)};
  TimingPlan plan;
  plan.drop_above_ns = 500;
  const auto results = time_interleaved(variants, plan, machine.clocks());
  EXPECT_TRUE(results[0].dropped);
  EXPECT_EQ(results[0].warmup_frames, 2);
  EXPECT_EQ(results[0].warmup_frame_ns, 1000);
  EXPECT_TRUE(results[0].samples.empty());
  EXPECT_FALSE(results[1].dropped);
  EXPECT_EQ(results[1].samples.size(), 20U);
}

TEST(Timing, OneSlowFirstFrameDropsNothing) {
  FakeMachine machine;
  int frame = 0;
  const std::vector<Variant> variants = {{"A", {}, [&] {
                                            const int64_t cost = frame++ == 0 ? 100'000 : 10;
                                            machine.spend(cost, cost, cost);
                                          }}};
  TimingPlan plan;
  plan.drop_above_ns = 500;
  const auto results = time_interleaved(variants, plan, machine.clocks());
  EXPECT_FALSE(results[0].dropped);
  EXPECT_EQ(results[0].samples.size(), 20U);
}

TEST(Timing, TheRatioOfKnownCostsIsTheRatioOfTheCosts) {
  // A drift that slows everything alike from round to round leaves the paired ratio exact.
  FakeMachine machine;
  int64_t drift = 1;
  const auto drawer = [&](int64_t cost) {
    return [&machine, &drift, cost] { machine.spend(cost * drift, 3 * cost * drift, 1); };
  };
  const auto slow_down = [&drift](uint64_t tick) { drift = 1 + 3 * static_cast<int64_t>(tick); };
  const std::vector<Variant> variants = {{"of", slow_down, drawer(40)}, {"to", slow_down, drawer(500)}};
  const auto results = time_interleaved(variants, {}, machine.clocks());
  for (const Metric metric : {Metric::cpu, Metric::wall}) {
    const auto ratio = paired_ratio(results[1].samples, results[0].samples, metric, 1);
    ASSERT_TRUE(ratio.has_value());
    EXPECT_DOUBLE_EQ(ratio->median, 12.5);
    EXPECT_DOUBLE_EQ(ratio->interval.low, 12.5);
    EXPECT_DOUBLE_EQ(ratio->interval.high, 12.5);
    EXPECT_EQ(ratio->pairs, 20U);
  }
  EXPECT_FALSE(paired_ratio(results[1].samples, results[0].samples, Metric::gpu, 1).has_value());
}

TEST(Timing, PairsWithoutATimeAreLeftOut) {
  std::vector<SampleRow> a(3);
  std::vector<SampleRow> b(3);
  for (int i = 0; i < 3; ++i) {
    a[static_cast<size_t>(i)] = {i, 0, 10, 20, 0, std::nullopt};
    b[static_cast<size_t>(i)] = {i, 0, 5, i == 1 ? 0 : 4, 0, std::nullopt};
  }
  const auto ratio = paired_ratio(a, b, Metric::cpu, 1);
  ASSERT_TRUE(ratio.has_value());
  EXPECT_EQ(ratio->pairs, 2U);
  EXPECT_DOUBLE_EQ(ratio->median, 5.0);
  EXPECT_FALSE(paired_ratio(std::vector<SampleRow>{}, b, Metric::cpu, 1).has_value());
}

TEST(Timing, RowsAreFilledByHandWorkedAggregates) {
  // Frame times 1..100 ms: median 50.5, 5th percentile 5.95, 95th 95.05, 99th 99.01 (linear between order statistics),
  // slowest 1 % is the one frame of 100 ms: 10 fps.
  VariantTimes times;
  for (int i = 0; i < 100; ++i) {  // in an order in which neighbours are not alike
    const int64_t ms = 37 * i % 100 + 1;
    times.samples.push_back({i, 0, 1'000'000 * ms, 2'000'000 * ms, 5, std::nullopt});
  }
  times.warmup_frames = 4;
  times.settled = true;
  MeasurementRow row;
  put_times(row, times, 1);
  EXPECT_EQ(row.rounds, 100);
  EXPECT_EQ(row.warmup_frames, 4);
  EXPECT_TRUE(row.settled);
  ASSERT_TRUE(row.frame_ns && row.cpu_ns && row.main_cpu_ns);
  EXPECT_DOUBLE_EQ(row.frame_ns->median, 50.5e6);
  EXPECT_NEAR(row.frame_ns->p05, 5.95e6, 1e-3);
  EXPECT_NEAR(row.frame_ns->p95, 95.05e6, 1e-3);
  EXPECT_NEAR(row.frame_ns->p99, 99.01e6, 1e-3);
  EXPECT_LE(row.frame_ns->low, row.frame_ns->median);
  EXPECT_GE(row.frame_ns->high, row.frame_ns->median);
  EXPECT_GT(row.frame_ns->low, 30e6);
  EXPECT_LT(row.frame_ns->high, 70e6);
  EXPECT_DOUBLE_EQ(row.cpu_ns->median, 101e6);
  EXPECT_FALSE(row.gpu_ns.has_value());
  ASSERT_TRUE(row.low_1_percent_fps.has_value());
  EXPECT_NEAR(*row.low_1_percent_fps, 10.0, 1e-9);
  EXPECT_EQ(row.samples.size(), 100U);
}

TEST(Timing, ADroppedVariantHasNoTimes) {
  MeasurementRow row;
  put_times(row, VariantTimes{{}, 2, false, true, 999}, 1);
  EXPECT_FALSE(row.frame_ns.has_value());
  EXPECT_FALSE(row.low_1_percent_fps.has_value());
  EXPECT_EQ(row.rounds, 0);
}

TEST(Timing, SystemClocksMoveForward) {
  const Clocks clocks = system_clocks();
  const int64_t cpu = clocks.cpu();
  const int64_t main_cpu = clocks.main_cpu();
  const int64_t wall = clocks.wall();
  double sum = 0;
  for (int i = 1; i < 2'000'000; ++i) sum += 1.0 / i;
  EXPECT_GT(sum, 1.0);
  EXPECT_GT(clocks.wall(), wall);
  EXPECT_GT(clocks.main_cpu(), main_cpu);
  EXPECT_GE(clocks.cpu() - cpu, 1);
  EXPECT_GT(timer_cost_ns(clocks), 0.0);
  EXPECT_LT(timer_cost_ns(clocks), 1e6);
}

TEST(CpuTime, MedianIsTheUpperOneAndTheClockCountsWork) {
  EXPECT_EQ(median({3}), 3);
  EXPECT_EQ(median({4, 1, 3}), 3);
  EXPECT_EQ(median({4, 1, 3, 2}), 3) << "the upper one of an even number";
  const double before = cpu_seconds();
  volatile double sum = 0;  // the loop is not left out
  // It counts work, and not the time that passes beside it.
  std::this_thread::sleep_for(std::chrono::milliseconds(50));
  const double slept = cpu_seconds() - before;
  for (int i = 0; i < 20'000'000; ++i) sum = sum + i;
  EXPECT_LT(slept, 0.01);
  EXPECT_GT(cpu_seconds() - before - slept, slept + 0.002) << sum;
}

// On a software rasteriser the process's CPU time is what drawing costs, whatever its timer says.
TEST(TimingMethodGl, FollowsTheDriver) {
  gl::Context context;
  const TimingMethod method = choose_timing_method(context);
  EXPECT_EQ(gpu_timer_of(context, method).has_value(), method.gpu_trusted);
  EXPECT_FALSE(method.gpu_reason.empty()) << "why it is trusted, or not";
  if (context.is_software()) {
    EXPECT_EQ(method.headline, Metric::cpu);
    EXPECT_FALSE(method.gpu_trusted);
  } else {
    EXPECT_EQ(method.headline, method.gpu_trusted ? Metric::gpu : Metric::wall);
  }
}

TEST(TimingMethodGl, ATimerIsGivenWhereItIsTrusted) {
  gl::Context context;
  EXPECT_FALSE(gpu_timer_of(context, {Metric::cpu, false, "not asked"}).has_value());
  const std::optional<GpuTimer> timer = gpu_timer_of(context, {Metric::gpu, true, ""});
  ASSERT_TRUE(timer.has_value());
  // A draw that takes time, and none: a timer that always says the same fails.
  constexpr int kSide = 512;
  const gl::Texture colour = gl::Texture::make_2d(context, GL_RGBA8, kSide, kSide);
  const gl::Texture* const attachments[] = {&colour};
  const gl::Framebuffer target(context, attachments, nullptr);
  const gl::VertexArray nothing(context);
  const gl::Program program(context, {"renderers/shaders/screen.vert", "renderers/shaders/timer_test.frag"});
  target.bind();
  glViewport(0, 0, kSide, kSide);
  nothing.bind();
  program.use();
  const auto drawn = [&](int draws) {
    program.set(CB_LOCATION_COUNT, 64U);
    glFinish();
    timer->begin();
    for (int i = 0; i < draws; ++i) glDrawArrays(GL_TRIANGLES, 0, 3);
    return timer->end();
  };
  (void)drawn(1);  // compiles
  EXPECT_GT(drawn(20), drawn(0));
}

}  // namespace
}  // namespace crowdbench::bench
