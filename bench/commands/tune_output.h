// What `tune` prints: for people, and as JSON.
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "bench/experiments/switch_distance.h"
#include "bench/experiments/tune.h"
#include "bench/experiments/tune_proof.h"
#include "bench/experiments/tune_views.h"
#include "core/error.h"
#include "core/json.h"

namespace crowdbench::bench {

struct TuneProof {
  std::string character;  // of the crowds; empty: the tuned ones
  SpeedProof speed;
  std::vector<ErrorProof> errors;
  bool holds() const;
};

struct TuneReport {
  TuneRequest request;
  TuneResult result;
  std::string renderer;
  uint32_t crowd = 0;              // agents of the scenario, in view or not
  std::vector<glm::dvec3> bounds;  // by subject, metres: the box around the clip's poses, which engines measure by
  // By switch: the height at which a texel of the far representation spans one pixel; nothing where it has no texels.
  std::vector<std::optional<double>> predicted_px;
  std::optional<SpeedPromise> promise;
  std::optional<std::vector<TuneLensCheck>> lenses;
  std::optional<TuneProof> proof;
  std::optional<Error> failed;  // of what comes after the tuning: predictions, promise, lenses or proof
};

// ---- what both forms say
std::string candidate_name(const TuneReport& report, size_t candidate);
double depth_in_report(const TuneReport& report, size_t subject, double height_px);
EngineSizes engines_in_report(const TuneReport& report, size_t subject, double height_px);
double agents_in_view(const TuneReport& report);
// Why an answer has no plan.
std::string no_plan_text(const TuneReport& report, const TuneAnswer& answer);

void print_tune(const TuneReport& report);
Json tune_json(const TuneReport& report);

}  // namespace crowdbench::bench
