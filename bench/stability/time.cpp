// Clocks that have run for long, backwards, too slowly or too fast, and the seams of a loop.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "bench/stability/fixture.h"

namespace crowdbench::bench {
namespace {

constexpr uint64_t kMillionSeconds = 30'000'000;  // ticks, at 30 a second

// What phase a pose of the bank is.
long double phase_of(const scene::PoseBank& bank, const scene::FrameAgent& agent) {
  const scene::BankClip& clip = bank.clips()[static_cast<size_t>(agent.bank_clip)];
  return (static_cast<long double>(agent.pose.a - clip.first_sample) + static_cast<long double>(agent.pose.blend)) /
         clip.samples;
}

// Phases of a whole crowd beside the same arithmetic with 64 bits of mantissa, in fractions of a cycle.
void compare_phases(Fixture& fixture, const scene::Crowd& crowd, const scene::Scenario& scenario, uint64_t tick,
                    Found& found) {
  const scene::PoseBank& bank = *fixture.walker().banks[0];
  const scene::Frame frame = scene::make_frame(scenario, fixture.walker(), crowd, scenario.camera.at(0), tick, false);
  for (const scene::FrameAgent& agent : frame.agents[0]) {
    const size_t i = agent.id - 1;
    const scene::BankClip& clip = bank.clips()[crowd.bank_clip[i]];
    const long double played = static_cast<long double>(crowd.phase[i]) +
                               static_cast<long double>(crowd.speed[i]) * static_cast<long double>(tick) /
                                   static_cast<long double>(scenario.tick_rate) /
                                   static_cast<long double>(clip.seconds);
    const long double phase = played - std::floor(played);
    for (const long double got : {phase_of(bank, agent), static_cast<long double>(agent.phase)}) {
      const long double apart = std::abs(got - phase);
      const auto gap = static_cast<double>(std::min(apart, 1 - apart));
      if (gap <= found.measured) continue;
      found.measured = gap;
      found.place = fmt::format("agent {}, tick {}, speed {:g}", i, tick, crowd.speed[i]);
      found.expected = fmt::format("{:.12f}", static_cast<double>(phase));
      found.got = fmt::format("{:.12f}", static_cast<double>(got));
    }
  }
}

// Roundings of the count of cycles: three operations, half a spacing each, in double; then that of a float below 1.
double phase_bound(double cycles) { return 1.5 * cycles * 0x1p-52 + 0x1p-24; }

Found after_a_million_seconds(Fixture& fixture) {
  scene::Scenario scenario;
  const scene::Crowd crowd = scene::make_crowd(scenario, fixture.walker(), scene::stage_view(scenario));
  Found found;
  found.measured = 0;
  compare_phases(fixture, crowd, scenario, kMillionSeconds, found);
  found.bound = phase_bound(1.2e6 / fixture.walker().banks[0]->clips()[0].seconds);
  return found;
}

Found extreme_speeds(Fixture& fixture) {
  scene::Scenario scenario;
  scene::Crowd crowd = scene::make_crowd(scenario, fixture.walker(), scene::stage_view(scenario));
  Found found;
  found.measured = 0;
  for (const double speed : {0.0, 1e-6, 1e3}) {
    std::fill(crowd.speed.begin(), crowd.speed.end(), speed);
    for (const uint64_t tick : {uint64_t{0}, uint64_t{1}, kMillionSeconds})
      compare_phases(fixture, crowd, scenario, tick, found);
  }
  found.bound = phase_bound(1e9 / fixture.walker().banks[0]->clips()[0].seconds);
  return found;
}

// Phases outside of [0, 1), and as near to its ends as doubles go.
Found wrapped_phases(Fixture& fixture) {
  const scene::PoseBank& bank = *fixture.walker().banks[0];
  const scene::BankClip& clip = bank.clips()[0];
  struct Phase {
    double given, same;
  };
  const double below_one = std::nextafter(1.0, 0.0);
  Found found;
  found.measured = 0;
  for (const Phase& phase :
       {Phase{-0.25, 0.75}, Phase{-1e6 - 0.25, 0.75}, Phase{1e6 + 0.25, 0.25}, Phase{1.0, 0.0}, Phase{-0.0, 0.0},
        Phase{-5e-324, 0.0}, Phase{-1e-17, 0.0}, Phase{below_one, 0.0}, Phase{5e-324, 0.0}, Phase{-1.0, 0.0}}) {
    const scene::PoseSample sample = bank.sample(0, phase.given);
    const auto in_clip = [&](uint32_t s) { return s >= clip.first_sample && s < clip.first_sample + clip.samples; };
    double gap = std::numeric_limits<double>::infinity();
    if (in_clip(sample.a) && in_clip(sample.b) && sample.blend >= 0 && sample.blend <= 1) {
      gap = 0;
      const auto expected = bank.palette(bank.sample(0, phase.same));
      const auto got = bank.palette(sample);
      for (size_t j = 0; j < got.size(); ++j)
        for (int row = 0; row < 3; ++row)
          for (int c = 0; c < 4; ++c)
            gap = std::max(gap, static_cast<double>(std::abs(got[j].rows[row][c] - expected[j].rows[row][c])));
    }
    if (!(gap > found.measured)) continue;
    found.measured = gap;
    found.place = fmt::format("phase {:g}", phase.given);
    found.expected = fmt::format("the pose of phase {:g}", phase.same);
    found.got = fmt::format("samples {} and {}, blend {:g}", sample.a, sample.b, sample.blend);
  }
  // A matrix's elements are of the order of one: a float of the blend moves them by as much.
  found.bound = 0x1p-22;
  return found;
}

// How far the fastest vertex of the walker moves between two phases, metres.
double moved_metres(const scene::Cast& cast, double before, double after) {
  const scene::PoseBank& bank = *cast.banks[0];
  const scene::Mesh& mesh = cast.characters[0]->mesh;
  const auto a = scene::skin_points(mesh, bank.palette(bank.sample(0, before)));
  const auto b = scene::skin_points(mesh, bank.palette(bank.sample(0, after)));
  double most = 0;
  for (size_t i = 0; i < a.size(); ++i)
    most = std::max(most, static_cast<double>(glm::length(glm::dvec3(b[i]) - glm::dvec3(a[i]))));
  return most;
}

// Two pictures a millionth of a cycle apart. Where stored poses are shown, both show one, or nothing is claimed.
Found small_steps_of_time(Fixture& fixture) {
  Found worst;
  worst.measured = 0;
  worst.bound = 0;
  int looked = 0;
  double margin = std::numeric_limits<double>::infinity();
  for (const double phase : {0.371, 0.5, 1 - 5e-7}) {
    const double next = phase + 1e-6 >= 1 ? phase + 1e-6 - 1 : phase + 1e-6;
    renderers::Representation& drawn = fixture.representation();
    const double shown = drawn.shown_phase(0, 0, phase);
    const double shown_next = drawn.shown_phase(0, 0, next);
    if (shown != phase && shown != shown_next) continue;
    ++looked;
    scene::Frame before = empty_frame({0, 1.2, 4}, {0, 0.9, 0}, 40, fixture.side(320), fixture.side(320));
    scene::Frame after = before;
    add_agent(before, fixture.walker(), {0, 0, 0}, phase, 0.2);
    add_agent(after, fixture.walker(), {0, 0, 0}, next, 0.2);
    const Image8 a = fixture.draw(before).colour;
    const Image8 b = fixture.draw(after).colour;
    const StepChange change = step_change(a, b);
    const double pixels =
        moved_metres(fixture.walker(), phase, next) / scene::pixel_size_at(before.camera, 3.5, before.height);
    const double bound = step_bound(change.edges, pixels);
    if (bound - static_cast<double>(change.changed) >= margin) continue;
    margin = bound - static_cast<double>(change.changed);
    worst.measured = static_cast<double>(change.changed);
    worst.bound = bound;
    worst.place = fmt::format("phase {:.7f}, pixel ({}, {})", phase, change.x, change.y);
    worst.expected = "less change";
    worst.got = fmt::format("{} pixels changed", change.changed);
    worst.note = fmt::format("the fastest vertex moves {:.2g} pixels", pixels);
    worst.before = enlarged(a, change.x, change.y);
    worst.after = enlarged(b, change.x, change.y);
  }
  if (looked < 3) worst.note += fmt::format("; {} of 3 phases, for others fall to two stored poses", looked);
  return worst;
}

Found the_tick_alone(Fixture& fixture) {
  const auto draw = [&](uint64_t tick) {
    scene::Frame frame = empty_frame({0, 1.2, 5}, {0, 0.9, 0}, 40, fixture.side(240), fixture.side(240));
    add_agent(frame, fixture.walker(), {0, 0, 0}, 0.3, 0.2);
    add_agent(frame, fixture.walker(), {0.9, 0, -1}, 0.9, 0.7);
    frame.tick = tick;
    return fixture.draw(frame).colour;
  };
  const Image8 first = draw(0);
  Found worst = largest_difference(first, first);
  for (const uint64_t tick : {kMillionSeconds, uint64_t{1} << 53U, std::numeric_limits<uint64_t>::max()}) {
    Found found = largest_difference(first, draw(tick));
    if (found.measured > worst.measured) worst = std::move(found);
  }
  worst.bound = 0;
  return worst;
}

// Twice from the seed to the picture, each time anew; and that the two seeds show two crowds.
Found extreme_seeds(Fixture& fixture) {
  const auto draw = [&](uint64_t seed) {
    scene::Scenario scenario;
    scenario.seed = seed;
    scenario.width = fixture.side(240);
    scenario.height = fixture.side(180);
    scenario.crowd.agents = 25;
    const scene::Crowd crowd = scene::make_crowd(scenario, fixture.walker(), scene::stage_view(scenario));
    return fixture.draw(scene::make_frame(scenario, fixture.walker(), crowd, scenario.camera.at(0), 11)).colour;
  };
  const uint64_t most = std::numeric_limits<uint64_t>::max();
  const Image8 low = draw(0);
  const Image8 high = draw(most);
  Found found = largest_difference(low, draw(0));
  Found other = largest_difference(high, draw(most));
  if (other.measured > found.measured) found = std::move(other);
  if (low == high) {
    found.measured = 255;
    found.note = "the two seeds show one crowd";
  }
  found.bound = 0;
  return found;
}

constexpr const char* kPhaseBound =
    "three roundings of the count of cycles in double, and half the spacing of floats below 1 twice";

void add_once(std::vector<StabilityCase>& cases) {
  cases.push_back({.name = "time_1e6_s",
                   .group = "time",
                   .asked = "the phases of 100 agents after 1e6 s, beside arithmetic of 64 bits",
                   .unit = "cycles",
                   .bound_from = kPhaseBound,
                   .once = true,
                   .measure = after_a_million_seconds});
  cases.push_back({.name = "time_speeds",
                   .group = "time",
                   .asked = "the same at playback speeds 0, 1e-6 and 1e3, at ticks 0, 1 and after 1e6 s",
                   .unit = "cycles",
                   .bound_from = kPhaseBound,
                   .once = true,
                   .measure = extreme_speeds});
  cases.push_back({.name = "time_wrap",
                   .group = "time",
                   .asked = "phases below 0, above 1 and next to both: the pose of the phase within the cycle",
                   .unit = "of a matrix",
                   .bound_from = "the spacing of floats near 1 in the blend, twice",
                   .once = true,
                   .measure = wrapped_phases});
}

}  // namespace

void add_time_cases(std::vector<StabilityCase>& cases) {
  add_once(cases);
  cases.push_back({.name = "time_step",
                   .group = "time",
                   .asked = "a millionth of a cycle later, between two samples, at one, and over the loop's seam",
                   .unit = "pixels changed",
                   .bound_from =
                       "2 x edges of the picture x the fastest vertex's way in pixels, six deviations of that "
                       "count, and 3",
                   .measure = small_steps_of_time});
  cases.push_back({.name = "time_tick",
                   .group = "time",
                   .asked = "the same agents at tick 0, after 1e6 s, at 2^53 and 2^64 - 1: the same picture",
                   .unit = "code values",
                   .bound_from = "a picture is a function of its agents, not of the clock",
                   .measure = the_tick_alone});
  cases.push_back({.name = "time_seeds",
                   .group = "time",
                   .asked = "seeds 0 and 2^64 - 1, each twice from the seed to the picture: the same, and two crowds",
                   .unit = "code values",
                   .bound_from = "a crowd is a function of its seed",
                   .measure = extreme_seeds});
}

}  // namespace crowdbench::bench
