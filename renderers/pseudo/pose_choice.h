// Which few poses stand for the agents of one clip in one frame.
#pragma once
#include <cstdint>
#include <span>
#include <vector>

namespace crowdbench::renderers {

struct PoseChoice {
  std::vector<double> phases;  // in [0, 1), of the poses that somebody shows
  std::vector<uint32_t> of;    // by agent, in the order given: which of `phases` it shows
};

// The nearest of `poses` phases 0, 1 / poses, 2 / poses, ...: independent of the other agents.
double nearest_even_phase(double phase, uint32_t poses);
// phases: of the agents, each in [0, 1). poses: above 0.
PoseChoice even_poses(std::span<const float> phases, uint32_t poses);

// Means of at most `poses` clusters of the agents' phases on their circle, so that the sum of the squared differences
// of phase is least, as far as Lloyd's iteration finds it. Agents of at most `poses` different phases show their own.
// Where all agents advance by as much, so do the poses.
PoseChoice clustered_poses(std::span<const float> phases, uint32_t poses);

}  // namespace crowdbench::renderers
