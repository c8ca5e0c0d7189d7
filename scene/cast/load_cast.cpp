#include "scene/cast/load_cast.h"

#include <algorithm>

#include "core/error.h"
#include "scene/cast/open_character.h"

namespace crowdbench::scene {
namespace {

// The clips that an entry names; whoever named one that is not there is to blame, not the character's file.
std::vector<int> clips_in_use(const Character& character, const CharacterEntry& entry, const std::string* place) {
  std::vector<int> clips;
  try {
    for (const std::string& name : entry.clips) clips.push_back(require_clip(character, name));
  } catch (const Error& error) {
    if (place == nullptr) throw;
    throw Error(*place, fmt::format("{} of {}", error.wrong, error.where), error.advice);
  }
  if (clips.empty()) clips.push_back(character.placement.default_clip);
  return clips;
}

// With the place in the scenario that names the file at fault, where it is known.
[[noreturn]] void blame(const Error& error, const CharacterEntry& entry, const std::filesystem::path& folder,
                        size_t index, const KeyPlaces& places) {
  const auto is_about = [&](const std::string& name) {
    return error.where.starts_with(printable(path_of_character(name, folder), 300));
  };
  const bool animations = !is_about(entry.source) && std::ranges::any_of(entry.animations, is_about);
  const auto place = places.find(key_place("character", animations ? "animations" : "source", index));
  if (place == places.end() || !(animations || is_about(entry.source))) throw error;
  throw Error(place->second, fmt::format("{}: {}", error.where, error.wrong), error.advice);
}

std::shared_ptr<const Character> open_entry(const CharacterEntry& entry, const std::filesystem::path& folder,
                                            size_t index, const KeyPlaces& places) {
  try {
    return std::make_shared<const Character>(open_character(entry, folder));
  } catch (const Error& error) {
    blame(error, entry, folder, index, places);
  }
}

}  // namespace

Cast load_cast(const Scenario& scenario, const std::filesystem::path& folder, const KeyPlaces& places) {
  Cast cast;
  double sum = 0;
  for (const CharacterEntry& entry : scenario.characters) sum += entry.share;
  for (const CharacterEntry& entry : scenario.characters) {
    auto character = open_entry(entry, folder, cast.characters.size(), places);
    const auto place = places.find(key_place("character", "clips", cast.characters.size()));
    const std::vector<int> clips = clips_in_use(*character, entry, place == places.end() ? nullptr : &place->second);
    cast.banks.push_back(std::make_shared<const PoseBank>(*character, clips, scenario.pose_rate));
    cast.characters.push_back(std::move(character));
    cast.shares.push_back(entry.share / sum);
  }
  return cast;
}

}  // namespace crowdbench::scene
