// How fast the figure of a clip that stays in place would go: as fast as the foot that bears its weight goes backwards
// below it. Internal to normalise.cpp, apart from the rule that it states.
//
// A foot steps: it goes back low, on the ground, and comes forward higher, in the air. What turns one joint, sways,
// falls or lunges moves soles over the ground too, but comes back by the way that it went, or not at all, or stands on
// the other foot meanwhile: it goes nowhere.
#pragma once
#include <glm/glm.hpp>
#include <optional>
#include <vector>

namespace crowdbench::scene {

inline constexpr double kStillFoot = 0.02;  // of the height a second: a foot that moves more slowly stands still

// Points of the soles, glTF units.
struct SoleTracks {
  std::vector<std::vector<glm::dvec3>> poses;  // as many points in each, evenly from the clip's start to its end
  double height = 0;                           // of the figure
  double duration = 0;                         // seconds, above 0
};

// Over the ground, (x, z), units a second: 0 for a figure that does not step. Nothing where no point is in contact with
// the ground from one pose to the next.
std::optional<glm::dvec2> stance_velocity(const SoleTracks& tracks);

}  // namespace crowdbench::scene
