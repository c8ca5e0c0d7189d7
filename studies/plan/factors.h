// The factors of a plan: what varies between conditions. Internal to studies/plan.
#pragma once
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "scene/scenario/parse_scenario.h"
#include "scene/scenario/toml_document.h"
#include "studies/plan/plan.h"

namespace crowdbench::studies {

// A factor as it is read: a change of a condition for each of its levels.
struct ReadFactor {
  Factor factor;
  std::string place;  // FILE:LINE
  int turn = 0;       // what draws is chosen before its options, these before its switch, and that before the camera
  std::vector<std::function<void(StudyCondition&)>> changes;
};

// What [factors] holds. folder: of the plan. Throws Error.
std::vector<ReadFactor> read_factors(const scene::TomlNode& table, const std::string& where,
                                     const std::filesystem::path& folder);

// All combinations on top of `base`, the last factor changing fastest. Throws Error at a factor that does not fit.
std::vector<StudyCondition> combine_factors(const std::vector<ReadFactor>& factors, const StudyCondition& base);

}  // namespace crowdbench::studies
