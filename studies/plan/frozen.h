// Freezing: what was planned is written down with a hash before the first answer, so that nobody, the authors included,
// can pretend afterwards that something else was.
#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "studies/plan/plan.h"

namespace crowdbench::studies {

// A change of the plan after it was frozen, said openly.
struct Deviation {
  std::string hash;    // of the plan from here on
  std::string reason;  // in words
};

// study.frozen.json beside study.toml:
//   {"format": "crowdbench-study-frozen-1", "plan": "study.toml", "hash": "...", "crowdbench": "VERSION (REVISION)",
//    "deviations": [{"hash", "reason"}], "analysis": {...}, "meaning": {...}}
struct FrozenPlan {
  std::filesystem::path file;
  std::string hash;               // of the plan as it was frozen
  std::string analysis, meaning;  // JSON, as it was frozen
  std::vector<Deviation> deviations;
  // The plan's hash that answers may be collected under now: the last deviation's, or the frozen one.
  const std::string& current_hash() const { return deviations.empty() ? hash : deviations.back().hash; }
};

std::filesystem::path frozen_file(const std::filesystem::path& plan_file);

// Nothing where the plan was never frozen. Throws Error where the file is not what freeze() writes, or its hash is not
// that of its own `meaning` (somebody edited it).
std::optional<FrozenPlan> read_frozen(const std::filesystem::path& plan_file);

// Writes the frozen file. Where there is one already: the same plan changes nothing; a changed one throws Error unless
// `deviation` gives the reason, which is recorded, or `anew` says that no answer was collected yet.
FrozenPlan freeze(const std::filesystem::path& plan_file, const StudyPlan& plan, const std::string& deviation = {},
                  bool anew = false);

// The frozen plan that this plan is. Throws Error with advice: it was not frozen, or it was changed since.
FrozenPlan require_frozen(const std::filesystem::path& plan_file, const StudyPlan& plan);

}  // namespace crowdbench::studies
