// Cast: the characters of a scenario, loaded, with the banks that pose them.
#pragma once
#include <filesystem>
#include <memory>
#include <vector>

#include "scene/character/character.h"
#include "scene/pose/pose_bank.h"
#include "scene/scenario/scenario.h"
#include "scene/scenario/scenario_toml.h"

namespace crowdbench::scene {

struct Cast {
  std::vector<std::shared_ptr<const Character>> characters;
  std::vector<std::shared_ptr<const PoseBank>> banks;
  std::vector<double> shares;  // of the crowd, by character; they sum to 1
};
// Loads every character of the scenario; `folder` resolves relative paths. Throws Error, which names the line of a
// clip's name where `places` has it.
Cast load_cast(const Scenario& scenario, const std::filesystem::path& folder = {}, const KeyPlaces& places = {});

}  // namespace crowdbench::scene
