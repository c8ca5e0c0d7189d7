// One frame of a crowd, scored agent by agent through the id buffers; and the depth error, which is one of these
// scores.
//
// Depth error: the mean of |d_test - d_reference| over the pixels that carry the same agent in both pictures, d the
// depth along the view axis in metres. 0 = equal, lower is better, no greatest; neither colours nor a display have a
// say. Source: the mean absolute error. Limits: only pixels that both cover count, so that a wrong outline costs
// nothing; a flat impostor is charged for its plane, though nobody sees that from where it stands.
#pragma once
#include <optional>
#include <vector>

#include "metrics/registry.h"

namespace crowdbench::metrics {

struct AgentRow {
  uint32_t id = 0;  // as in the buffers: agent index + 1
  uint64_t pixels_ref = 0;
  uint64_t pixels_test = 0;
  uint64_t pixels_both = 0;
  std::vector<std::optional<double>> values;  // of AgentScores::scores; nothing where the score does not exist
};

// Each score over the pixels that carry the agent's id in the reference or in the test. Maps (SSIM) are those of the
// whole pictures, so that their windows reach beyond the agent.
struct AgentScores {
  std::vector<const Score*> scores;  // of the table: defined for an agent, and their needs are met
  std::vector<AgentRow> agents;      // by ascending id; ids in neither buffer are left out, 0 is the background
};

// input: with ids, which may be any 32-bit numbers; its region is not used. Throws Error when any two sizes differ.
AgentScores score_agents(ScoreTable table, const ScoreInput& input, Shared& shared);

}  // namespace crowdbench::metrics
