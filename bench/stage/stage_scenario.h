// The one way from a scenario to a crowd in front of a camera.
#pragma once
#include <optional>

#include "scene/crowd/crowd.h"
#include "scene/crowd/occupancy.h"

namespace crowdbench::gl {
class Context;
}

namespace crowdbench::bench {

// A crowd in front of a camera. With an occupancy asked for it is solved for, by drawing the mesh.
struct Staged {
  scene::Scenario scenario;  // as solved
  scene::Crowd crowd;
  std::optional<scene::Solved> solved;
};
Staged stage_scenario(const scene::Scenario& scenario, const scene::Cast& cast, gl::Context& context);

}  // namespace crowdbench::bench
