// What stands on a stage, in figures: where the camera and the crowd ended, and how much of the picture they cover.
#pragma once
#include <cstdint>
#include <optional>

#include "bench/stage/stage_scenario.h"
#include "core/json.h"

namespace crowdbench::bench {

// All of tick 0, drawn as `mesh` at the scenario's size without a ground, one sample a pixel.
struct StageFacts {
  scene::Scenario scenario;  // as staged
  scene::Coverage coverage;  // pixels with an agent id
  uint64_t touched_px = 0;  // pixels that a fragment of the mesh reached, measured by a draw of its own (Pass::touched)
  bool unreachable = false;   // an occupancy was asked for and missed by more than a percentage point
  scene::OnScreen on_screen;  // agents by their projected bounds
};

// Draws twice. Throws Error.
StageFacts measure_stage(const Staged& staged, const scene::Cast& cast, gl::Context& context);

// How every command prints it:
//   {"width", "height", "samples", "supersample", "seed": of the picture and the crowd,
//    "camera": {...}, "crowd": {...}: the scenario's keys of those names as staged (scene::table_json),
//    "requested_occupancy": fraction of the picture or null, "achieved_occupancy", "unreachable",
//    "covered_px", "touched_px", "agents_visible",
//    "agents_on_screen": {"wholly", "partly", "off"}}
Json stage_json(const StageFacts& facts);

}  // namespace crowdbench::bench
