// Distance: what each agent of a crowd scores, drawn by representations against the reference, and how that falls or
// rises with how far away it is.
//
// Scores are those of the whole pictures (their maps see the neighbours), read over the pixels that carry the agent's
// id in either picture (metrics/agents.h). Only agents of AgentState::counted make curves; the others keep their rows.
#pragma once
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "bench/experiments/agent_views.h"
#include "bench/experiments/cause_words.h"
#include "bench/experiments/distance_curve.h"
#include "bench/stage/stage_scenario.h"
#include "metrics/registry.h"

namespace crowdbench::bench {

struct DistanceRequest {
  renderers::Spec reference;
  std::vector<renderers::Spec> representations;  // at least one
  std::vector<const metrics::Score*> scores;     // of agent_scores()
  metrics::ChosenDisplay display;
  uint64_t tick = 0;            // the first
  uint64_t frames = 1;          // at least one
  uint64_t step = 10;           // ticks from one frame to the next, at least one
  double least_visible = 0.75;  // AgentState::occluded below it
  uint64_t bake_budget = uint64_t{512} << 20;
  bool use_cache = true;
  bool causes = false;  // fill DistanceResult::causes; the reference must be what all others are held against
};

// Scores of a table that exist for an agent. linear: also those of linear light, for which each picture is drawn twice.
std::vector<const metrics::Score*> agent_scores(metrics::ScoreTable table, bool linear);

using AgentValues = std::vector<std::optional<double>>;  // by DistanceRequest::scores

// One agent in one frame.
struct DistanceAgent {
  AgentView view;
  std::vector<AgentValues> values;  // by representation; nothing where neither picture shows the agent
};

// The error by cause of one representation in one frame, of pictures without supersampling.
struct DistanceCauses {
  size_t representation = 0;
  uint64_t tick = 0;
  metrics::CauseErrors errors;
};

struct DistanceResult {
  std::vector<std::vector<double>> texels;  // metres a texel, by representation and character; 0: it has none
  std::vector<DistanceAgent> agents;        // by tick, then by id
  std::vector<DistanceCauses> causes;       // by tick, then by representation
};

// The scores of the agents in `views`, in their order. pictures: of one frame.
std::vector<AgentValues> score_views(const std::vector<AgentView>& views, const DistanceRequest& request,
                                     const renderers::Capture& reference, const renderers::Capture& test);

// Draws and scores. Representations whose picture depends on earlier ticks are shown all of them. Throws Error.
DistanceResult measure_distance(gl::Context& context, const scene::Cast& cast, const Staged& staged,
                                const DistanceRequest& request);

// What dominates a representation's error, by height: over all agents that show a pixel, in all frames.
std::vector<CauseRange> distance_causes(const DistanceResult& result, size_t representation, uint64_t seed);

// Pixels that a texel of the agent's map spans at the agent's depth; nothing where there are no texels.
std::optional<double> pixels_per_texel(const DistanceResult& result, const AgentView& view, size_t representation);

// What a curve is drawn against, in the order of reports::distance_axes(). Heights and ratios fall with distance.
enum class Against : uint8_t { distance, height, texel };
struct AgainstText {
  Against against;
  const char* name;   // "distance_m", "height_px", "pixels_per_texel": in JSON
  const char* title;  // for people
  const char* unit;   // for people; may be empty
};
const std::vector<AgainstText>& all_against();

struct DistanceThreshold {
  const metrics::Score* score = nullptr;
  double value = 0;
};

struct DistanceCurve {
  size_t representation = 0;  // into DistanceRequest
  size_t score = 0;
  Against against = Against::distance;
  ScoreCurve curve;
  std::vector<std::pair<double, ThresholdPlace>> thresholds;  // of this score: its value, and where
};
// By representation, score and what it is against; curves without a point are left out.
std::vector<DistanceCurve> distance_curves(const DistanceResult& result, const DistanceRequest& request, size_t bins,
                                           uint64_t seed, const std::vector<DistanceThreshold>& thresholds);

}  // namespace crowdbench::bench
