// The export of a study: every crowd drawn once, pairs of them stacked, proven and put into the folder that
// participants are shown, with what is private beside it. studies/plan/README.md says what lies where.
#pragma once
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "metrics/display.h"
#include "renderers/gl/context.h"
#include "studies/plan/design.h"
#include "studies/plan/frozen.h"
#include "studies/plan/plan.h"

namespace crowdbench::studies {

struct ExportSettings {
  bool webm = false;               // also VP9 4:4:4, for browsers that refuse H.264 4:4:4
  double score_every_seconds = 1;  // how often the half under test is scored against the reference; 0: never
  metrics::ChosenDisplay display;  // of the scores
};

// What an export will take, before anything is drawn.
struct ExportEstimate {
  size_t halves = 0, stimuli = 0, lists = 0;
  uint64_t trials = 0;               // a participant
  double minutes_a_participant = 0;  // clips and four seconds to answer each, breaks not counted
  double seconds = 0;                // of all of it on two cores without a GPU: an order of magnitude
  size_t bakes = 0;                  // of a representation for a character, were none kept from before
  double bake_seconds = 0;           // of these, part of `seconds`
  double page_bytes = 0;             // of what participants load, likewise
  double work_bytes = 0;             // of OUT/work
};
ExportEstimate estimate_export(const StudyPlan& plan, const StudyDesign& design, bool webm);

struct Exported {
  size_t drawn = 0, kept_halves = 0;     // halves
  size_t stacked = 0, kept_stimuli = 0;  // stimuli
  double worst_share = 0;                // of ClipProof, over all stimuli with an artefact
  std::vector<std::string> warnings;     // one line each
};

// Goes on where an export of the same plan was stopped. Throws Error (a clip that breaks a promise of its plan, a
// folder with another study's export), and Interrupted after Ctrl-C.
Exported export_study(gl::Context& context, const StudyPlan& plan, const FrozenPlan& frozen,
                      const std::filesystem::path& out, const ExportSettings& settings);

}  // namespace crowdbench::studies
