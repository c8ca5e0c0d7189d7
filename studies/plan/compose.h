// Stimuli out of halves: stacked, encoded, proven and scored. Internal to studies/plan.
#pragma once
#include <filesystem>
#include <functional>
#include <string>

#include "core/json.h"
#include "studies/plan/design.h"
#include "studies/plan/export.h"
#include "studies/plan/records.h"

namespace crowdbench::studies {

struct ComposeRequest {
  const StudyPlan& plan;
  const Stimulus& stimulus;
  std::filesystem::path upper, lower;  // the halves' files
  std::filesystem::path twin;          // empty: nothing is under test
  std::filesystem::path out;           // the export's folder
  bool webm = false;
};

struct Composed {
  std::vector<FileHash> files;  // of OUT/page/clips
  // {"files": as trials.json has them, "check_frame", "equal", "proof": by codec, "video": clip_json()}
  Json facts;
};

// Writes OUT/page/clips/ID.mp4 (and .webm). Throws Error where a promise of the plan is broken.
Composed compose_stimulus(const ComposeRequest& request);

// The half under test against its crowd by the reference, frame by frame:
// [{"score", "unit", "mean", "worst", "worst_frame", "x", "y"}]; x, y: the pixel of the score's map that differs most
// in the worst frame, null where the score has no map.
Json score_halves(const std::filesystem::path& test, const std::filesystem::path& reference, size_t every,
                  const metrics::ChosenDisplay& display);

}  // namespace crowdbench::studies
