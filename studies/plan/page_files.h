// The files of an export that are text: what participants' pages read, and what is private. Internal to studies/plan.
#pragma once
#include <filesystem>
#include <string>

#include "core/json.h"
#include "studies/plan/design.h"
#include "studies/plan/export.h"
#include "studies/plan/frozen.h"
#include "studies/plan/plan.h"

namespace crowdbench::studies {

// What an export has made.
struct ExportFacts {
  const StudyPlan& plan;
  const FrozenPlan& frozen;
  const StudyDesign& design;
  const Json& halves;   // as half_json() and crowd_clip_json()
  const Json& stimuli;  // in the order of design.stimuli
  const ExportSettings& settings;
  std::string renderer, renderer_version;
};

// A half and a stimulus as study.json has them, without what is found while they are drawn and encoded.
Json half_json(const PlannedHalf& half, const scene::Scenario& drawn);
Json stimulus_json(const StudyPlan& plan, const StudyDesign& design, const Stimulus& stimulus);

// Public: says nothing of conditions and sides, but where the page adapts, whose rule needs each stimulus's level or
// pair and the answer that counts as yes.
Json trials_json(const ExportFacts& facts);
Json sides_json(const ExportFacts& facts);  // private
Json study_json(const ExportFacts& facts);  // private

// trials.json and the Markdown files; every file below `page` gets one date.
void write_page_files(const ExportFacts& facts, const std::filesystem::path& page);

}  // namespace crowdbench::studies
