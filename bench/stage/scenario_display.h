// The display that a scenario's pictures are looked at on.
#pragma once
#include <filesystem>

#include "metrics/display.h"
#include "scene/scenario/parse_scenario.h"

namespace crowdbench::bench {

// By the keys of [display]; the default one where none is given. folder: what a file of displays is relative to.
// places: where keys were given, for errors. Throws Error.
metrics::ChosenDisplay display_of_scenario(const scene::Scenario& scenario, const std::filesystem::path& folder,
                                           const scene::KeyPlaces& places);

}  // namespace crowdbench::bench
