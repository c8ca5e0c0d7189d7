// What several scores are made of, computed once for an input. Each is called with its needs met.
#pragma once
#include <optional>
#include <string>

#include "metrics/registry.h"
#include "metrics/silhouette.h"
#include "metrics/ssim.h"

namespace crowdbench::metrics {

struct LumaPair {
  Plane reference, test;
};
const LumaPair& luma_pair(const ScoreInput& input, Shared& shared);  // luma601() of both; kNeedsCodes

// ssim() of the luma. kNeedsCodes
const std::optional<Ssim>& similarity(const ScoreInput& input, Shared& shared);

// difference() over the region, or over every pixel where there is none. kNeedsCodes
const std::optional<Difference>& region_difference(const ScoreInput& input, Shared& shared);

// not_finite_text() of both pictures: why no score is made of them; empty where all pixels are finite. kNeedsLinear
const std::string& not_finite_reason(const ScoreInput& input, Shared& shared);

struct SilhouettePair {
  Mask reference, test;
};
const SilhouettePair& silhouettes(const ScoreInput& input, Shared& shared);  // mask_of() both; kNeedsIds

// The silhouettes of one agent, cut to its box and a pixel around: where that is the picture's edge the figure is cut
// off there, and has no boundary.
SilhouettePair masks_of_agent(const ScoreInput& input, const AgentPixels& agent);

// boundary_distance() of the silhouettes. kNeedsIds
const std::optional<BoundaryDistance>& silhouette_boundary(const ScoreInput& input, Shared& shared);

}  // namespace crowdbench::metrics
