// Model only what a scene requires: what a scenario's camera sees of its agents.
#pragma once
#include <cstdint>

#include "renderers/representation.h"
#include "scene/crowd/crowd.h"
#include "scene/scenario/scenario.h"

namespace crowdbench::bench {

// Ticks after which a scenario has shown what it will show: its camera path to the end, and ten seconds at least (a
// clip of usual length at any playback speed); at most 3000.
uint64_t required_ticks(const scene::Scenario& scenario);

// Every agent in view at every tick from 0 to `ticks` - 1, as make_frame places it before the scenario's camera.
// scenario, cast and crowd must outlive the result.
renderers::VisitViewSamples view_samples_of(const scene::Scenario& scenario, const scene::Cast& cast,
                                            const scene::Crowd& crowd, uint64_t ticks);

}  // namespace crowdbench::bench
