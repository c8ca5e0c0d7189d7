// The cost models of a scene, where representations break even, and the fronts over time, bytes and error: as JSON and
// as Markdown.
#pragma once
#include <string>

#include "core/json.h"
#include "reports/model/scene.h"

namespace crowdbench::reports {

Json cost_json(const Scene& scene);
// Sections from "## Cost model" on; empty where nothing was timed.
std::string cost_markdown(const Scene& scene);

}  // namespace crowdbench::reports
