// The occupancy solver: moves camera and placement until the mesh covers the requested fraction of the picture.
#pragma once
#include <cstdint>
#include <functional>

#include "scene/crowd/crowd.h"

namespace crowdbench::scene {

// Measured by drawing the mesh, ids on: how much of the picture is covered, and by whom.
struct Coverage {
  double occupancy = 0;  // fraction of pixels with an agent id
  uint64_t covered_px = 0;
  uint32_t agents_visible = 0;  // agents with at least one pixel
};
using MeasureCoverage = std::function<Coverage(const Frame&)>;

// What a search for an occupancy came to.
struct OccupancySearch {
  double requested = 0;      // fraction of the picture
  double achieved = 0;       // the mesh's own, at tick 0
  bool unreachable = false;  // more than one percentage point off
  int measurements = 0;      // of the mesh
  int drafts = 0;            // of the stand-in
};

struct Solved {
  Scenario scenario;  // with camera (one view), stage and spacing as solved; occupancy as requested
  Crowd crowd;
  Camera camera;  // the scenario's, at any time
  OccupancySearch search;
};

// Whether an achieved occupancy is not the requested one: more than one percentage point off.
bool misses_occupancy(double requested, double achieved);

// How many agents are seen whole, in part or not at all, by the projected boxes of their banks' bounds.
struct OnScreen {
  uint32_t wholly = 0;
  uint32_t partly = 0;
  uint32_t off = 0;
};
OnScreen count_on_screen(const Scenario& scenario, const Cast& cast, const Crowd& crowd, const Camera& camera,
                         uint64_t tick);

// Solves for scenario.occupancy (which must be set, with at least one agent) at tick 0, within 0.2 percentage points
// where that can be reached. At least 95 % of the agents end at least partly on screen. The spacing falls to 0.7 m
// first, with the camera on a balcony over the ground that the agents need (stage = view; agents in lanes stay on their
// plaza); beyond that they stand evenly over the view's width and depth (stage = frustum; they may interpenetrate).
// Direction and field of view are the scenario's own, tilted so that the upper edge of the picture lies at least 5
// degrees below the horizon. Returns the nearest it reached when the target is out of reach, marked so. Deterministic.
//
// draft: a cheap stand-in for `measure` (the characters simplified), with which the search is done where one is given;
// the mesh then measures the result, and the search is repeated, at most twice, for what the stand-in was off by. Where
// that ends more than a point off, the mesh searches itself.
// `achieved` is always the mesh's.
Solved solve_occupancy(const Scenario& scenario, const Cast& cast, const MeasureCoverage& measure,
                       const MeasureCoverage& draft = {});

}  // namespace crowdbench::scene
