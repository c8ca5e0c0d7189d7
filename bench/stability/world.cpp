// The same crowd far from the world's origin.
#include <fmt/format.h>

#include <cmath>

#include "bench/stability/fixture.h"

namespace crowdbench::bench {
namespace {

scene::Scenario moved_scenario(const glm::dvec3& by, int width, int height) {
  scene::Scenario scenario;
  scenario.width = width;
  scenario.height = height;
  scenario.ground = true;
  scenario.crowd.agents = 16;
  scenario.crowd.centre = by;
  scene::Camera& camera = scenario.camera.keys.front().camera;
  camera.eye = glm::dvec3(0.0, 3.0, 9.0) + by;
  camera.target = glm::dvec3(0.0, 0.875, 0.0) + by;
  return scenario;
}

// Every coordinate of the scene is a multiple of 1/8, so that doubles hold it exactly at any of the distances and what
// reaches the GPU is the same to the bit.
Found moved_picture(Fixture& fixture, double metres) {
  const auto draw = [&](const glm::dvec3& by) {
    scene::Scenario scenario = moved_scenario(by, fixture.side(320), fixture.side(240));
    scenario.crowd.placement = scene::PlacementKind::grid;
    scenario.crowd.spacing = 1.25;
    const scene::Crowd crowd = scene::make_crowd(scenario, fixture.walker(), scene::stage_view(scenario));
    return fixture.draw(scene::make_frame(scenario, fixture.walker(), crowd, scenario.camera.at(0), 7)).colour;
  };
  Found found = largest_difference(draw(glm::dvec3(0.0)), draw({metres, metres, -metres}));
  found.bound = 0.5;
  return found;
}

struct Placing {
  const char* name;
  scene::Stage stage;
  scene::PlacementKind placement;
  scene::MotionKind motion;
};
constexpr Placing kPlacings[] = {
    {"jittered", scene::Stage::plaza, scene::PlacementKind::jittered, scene::MotionKind::treadmill},
    {"jittered, free", scene::Stage::plaza, scene::PlacementKind::jittered, scene::MotionKind::free},
    {"poisson", scene::Stage::plaza, scene::PlacementKind::poisson, scene::MotionKind::treadmill},
    {"lanes", scene::Stage::plaza, scene::PlacementKind::lanes, scene::MotionKind::lanes},
    {"view, grid", scene::Stage::view, scene::PlacementKind::grid, scene::MotionKind::treadmill},
    {"view, jittered", scene::Stage::view, scene::PlacementKind::jittered, scene::MotionKind::treadmill},
    {"view, poisson", scene::Stage::view, scene::PlacementKind::poisson, scene::MotionKind::treadmill},
    {"frustum", scene::Stage::frustum, scene::PlacementKind::jittered, scene::MotionKind::treadmill},
};

double spacing_of_doubles(double x) { return std::nextafter(x, INFINITY) - x; }
float spacing_of_floats(float x) { return std::nextafter(x, INFINITY) - x; }

// Places as they reach the GPU. Where the pictures' crowd stands, whatever the rules that place it.
Found moved_places(Fixture& fixture, double metres) {
  const auto frame_of = [&](const Placing& placing, const glm::dvec3& by, uint64_t tick) {
    scene::Scenario scenario = moved_scenario(by, 320, 240);
    scenario.crowd.agents = 200;
    scenario.crowd.stage = placing.stage;
    scenario.crowd.placement = placing.placement;
    scenario.crowd.motion = placing.motion;
    const scene::Crowd crowd = scene::make_crowd(scenario, fixture.walker(), scene::stage_view(scenario));
    return scene::make_frame(scenario, fixture.walker(), crowd, scenario.camera.at(0), tick, false);
  };
  Found found;
  found.measured = 0;
  float farthest = 0;
  for (const Placing& placing : kPlacings)
    for (const uint64_t tick : {uint64_t{0}, uint64_t{3000}}) {
      const scene::Frame near = frame_of(placing, glm::dvec3(0.0), tick);
      const scene::Frame far = frame_of(placing, {metres, metres, -metres}, tick);
      for (size_t i = 0; i < near.agents[0].size(); ++i) {
        const glm::vec3 a = near.agents[0][i].position;
        const glm::vec3 b = far.agents[0][i].position;
        for (int c = 0; c < 3; ++c) {
          farthest = std::max(farthest, std::abs(a[c]));
          const double gap = std::abs(static_cast<double>(a[c]) - static_cast<double>(b[c]));
          if (!(gap > found.measured)) continue;
          found.measured = gap;
          found.place = fmt::format("{}, tick {}, agent {}, {}", placing.name, tick, i, "xyz"[c]);
          found.expected = fmt::format("{:.7g} m", a[c]);
          found.got = fmt::format("{:.7g} m", b[c]);
        }
      }
    }
  found.bound = 16 * spacing_of_doubles(metres) + static_cast<double>(spacing_of_floats(farthest));
  return found;
}

constexpr const char* kPictureBound =
    "the eye's place leaves every coordinate in double before floats are made; every coordinate is a multiple of 1/8 "
    "m, "
    "which doubles hold to 1e15 m: half a code value";
constexpr const char* kPlacesBound =
    "16 roundings of a double at the distance, and the spacing of floats at the farthest agent's distance from the eye";

}  // namespace

void add_world_cases(std::vector<StabilityCase>& cases) {
  const auto picture = [&](std::string_view name, std::string_view asked, Found (*measure)(Fixture&)) {
    cases.push_back({.name = name,
                     .group = "world",
                     .asked = asked,
                     .unit = "code values",
                     .bound_from = kPictureBound,
                     .measure = measure});
  };
  picture("world_1e3", "16 agents and the ground 1e3 m from the origin along all axes: the picture of the origin",
          [](Fixture& fixture) { return moved_picture(fixture, 1e3); });
  picture("world_1e5", "the same 1e5 m away", [](Fixture& fixture) { return moved_picture(fixture, 1e5); });
  picture("world_1e7", "the same 1e7 m away", [](Fixture& fixture) { return moved_picture(fixture, 1e7); });
  const auto places = [&](std::string_view name, std::string_view asked, Found (*measure)(Fixture&)) {
    cases.push_back({.name = name,
                     .group = "world",
                     .asked = asked,
                     .unit = "m",
                     .bound_from = kPlacesBound,
                     .once = true,
                     .measure = measure});
  };
  places("world_places_1e5", "200 agents by every placement, stage and motion, 1e5 m away: where the eye sees them",
         [](Fixture& fixture) { return moved_places(fixture, 1e5); });
  places("world_places_1e7", "the same 1e7 m away", [](Fixture& fixture) { return moved_places(fixture, 1e7); });
}

}  // namespace crowdbench::bench
