// What `tune` prints: for people, and as JSON.
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "bench/experiments/tune.h"
#include "core/json.h"

namespace crowdbench::bench {

struct TuneReport {
  TuneRequest request;
  TuneResult result;
  std::string renderer;
  glm::dvec3 bounds{0.0};  // metres: the edges of the box around the clip's poses, which engines measure by
  // By switch: the height at which a texel of the far representation spans one pixel; nothing where it has no texels.
  std::vector<std::optional<double>> predicted_px;
};

void print_tune(const TuneReport& report);
Json tune_json(const TuneReport& report);

}  // namespace crowdbench::bench
