// The mesh beside rays in double precision, from cameras that nobody chose.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "bench/stability/fixture.h"
#include "core/portable_math.h"
#include "core/random.h"
#include "truth/judge.h"

namespace crowdbench::bench {
namespace {

constexpr uint64_t kSeed = 15;
constexpr double kTall = 1.75;     // metres: of the walker
constexpr double kWide = 170;      // degrees: the widest lens
constexpr double kNearBy = 3;      // metres: within it one lens in two is chosen by its angle
constexpr double kApart = 0.6;     // metres between walkers
constexpr double kFarthest = 1e6;  // metres of the crowd from the origin
constexpr double kDegree = std::numbers::pi / 180;

// What a camera is drawn from.
enum Purpose : uint64_t {
  kDistance,
  kTallness,
  kLens,
  kAngle,
  kAzimuth,
  kHeight,
  kNear,
  kWalkers,
  kAway,
  kWay,
  kPlace
};

double random_share(uint64_t camera, uint64_t purpose) { return random_unit(kSeed, camera, purpose); }
double log_between(double low, double high, double share) { return low * std::pow(high / low, share); }

// Vertical, degrees: so that a figure is 5 to 400 pixels tall, or of an angle drawn for itself.
double lens(uint64_t camera, double distance, int rows) {
  if (distance < kNearBy && random_share(camera, kLens) < 0.5) return 90 + (kWide - 90) * random_share(camera, kAngle);
  const double pixels = log_between(5, 400, random_share(camera, kTallness));
  return std::min(kWide, 2 * std::atan(kTall / distance * rows / pixels / 2) / kDegree);
}

scene::Frame extreme_frame(Fixture& fixture, uint64_t camera) {
  const double distance = log_between(0.05, 1e4, random_share(camera, kDistance));
  const double height = 2 * random_share(camera, kHeight) - 1;  // of a unit sphere: areas are even in it
  const SinCos azimuth = sincos_turns(random_share(camera, kAzimuth));
  const double level = std::sqrt(1 - height * height);
  const SinCos way = sincos_turns(random_share(camera, kWay));
  const double away = log_between(1, kFarthest, random_share(camera, kAway));
  const glm::dvec3 crowd(away * way.sin, 0, away * way.cos);
  const glm::dvec3 target = crowd + glm::dvec3(0, kTall / 2, 0);
  const glm::dvec3 eye = target + distance * glm::dvec3(level * azimuth.sin, height, level * azimuth.cos);
  const int rows = fixture.side(160);
  scene::Frame frame = empty_frame(eye, target, lens(camera, distance, rows), fixture.side(200), rows);
  frame.camera.near = log_between(1e-3, 0.1, random_share(camera, kNear));
  const auto walkers = static_cast<uint64_t>(std::round(log_between(1, 30, random_share(camera, kWalkers))));
  const int columns = static_cast<int>(std::ceil(std::sqrt(static_cast<double>(walkers))));
  for (uint64_t i = 0; i < walkers; ++i) {
    const auto of = [&](uint64_t what) { return random_share(camera, kPlace + 1 + 4 * i + what); };
    const double x = static_cast<double>(static_cast<int>(i) % columns) - (columns - 1) / 2.0 + 0.5 * of(0);
    const int row = static_cast<int>(i) / columns;
    const double z = row - (columns - 1) / 2.0 + 0.5 * of(1);
    add_agent(frame, fixture.walker(), crowd + kApart * glm::dvec3(x, 0, z), of(2), of(3));
  }
  return frame;
}

// Asked once: before any other representation is asked about, and so of the reference.
Found extreme_cameras(Fixture& fixture) {
  Found found;
  found.measured = 0;
  found.bound = 0;
  const uint64_t cameras = fixture.small() ? 3 : 12;
  truth::Judgement all;
  double widest = 0;
  uint64_t worst = 0;
  for (uint64_t camera = 0; camera < cameras; ++camera) {
    const scene::Frame frame = extreme_frame(fixture, camera);
    const renderers::Capture mesh = fixture.draw(frame);
    const truth::TruthPicture truth = truth::cast_truth(fixture.walker(), frame, {.shade = false});
    const truth::Judgement one = truth::judge(fixture.walker(), frame, truth, {mesh.ids, mesh.depth, Image8()});
    all.covered += one.covered;
    all.wrong += one.wrong;
    all.outline += one.outline;
    all.depth += one.depth;
    all.mask += one.mask;
    all.unexplained += one.unexplained;
    widest = std::max(widest, one.largest_bound);
    if (one.unexplained <= worst) continue;
    worst = one.unexplained;
    const truth::JudgedPixel& first = one.offenders.front();
    found.place = fmt::format("camera {}, {:.3g} m off, {:.3g} degrees, near {:.2g} m, {} walkers: pixel ({}, {})",
                              camera, glm::length(frame.camera.target - frame.camera.eye), frame.camera.fov_y / kDegree,
                              frame.camera.near, frame.agents[0].size(), first.x, first.y);
    found.expected = fmt::format("id {}", first.truth_id);
    found.got = fmt::format("id {}, the bound is {:.3g} pixels", first.id, first.bound);
    found.before = enlarged(truth::cast_truth(fixture.walker(), frame).colour, first.x, first.y);
    found.after = enlarged(mesh.colour, first.x, first.y);
  }
  found.measured = static_cast<double>(all.unexplained);
  found.note = fmt::format(
      "{} cameras, {} pixels covered, {} wrong: {} at outlines, {} of one depth, {} at masks; the largest bound of an "
      "outline is {:.2g} pixels",
      cameras, all.covered, all.wrong, all.outline, all.depth, all.mask, widest);
  return found;
}

}  // namespace

void add_truth_cases(std::vector<StabilityCase>& cases) {
  cases.push_back(
      {.name = "truth_cameras",
       .group = "truth",
       .asked = "the mesh from cameras drawn among extremes (0.05 m to 10 km, to 170 degrees, all round, 1e6 m "
                "from the origin), beside rays in double",
       .unit = "unexplained pixels",
       .bound_from = "an outline lies within a vertex's snap to 1/256 pixel, the 16 bits of its weights and "
                     "24 roundings of a float (truth::OutlineBound); depths as near as those are in any order",
       .once = true,
       .measure = extreme_cameras});
}

}  // namespace crowdbench::bench
