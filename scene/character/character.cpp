#include "scene/character/character.h"

#include <algorithm>
#include <charconv>

#include "core/error.h"

namespace crowdbench::scene {

std::optional<int> find_clip(const Character& character, std::string_view name_or_index) {
  for (size_t i = 0; i < character.clips.size(); ++i) {
    if (character.clips[i].name == name_or_index) return static_cast<int>(i);
  }
  if (name_or_index.empty() || name_or_index.size() > 9 ||
      !std::ranges::all_of(name_or_index, [](char c) { return c >= '0' && c <= '9'; })) {
    return std::nullopt;
  }
  const int index = std::stoi(std::string(name_or_index));
  if (static_cast<size_t>(index) >= character.clips.size()) return std::nullopt;
  return index;
}

namespace {

std::string nearest_clip(const Character& character, std::string_view name) {
  std::vector<std::string> names;
  for (const Clip& clip : character.clips)
    if (!clip.name.empty()) names.push_back(clip.name);
  if (std::string near = nearest_name(name, names); !near.empty()) return near;
  // "runing" is far from "run", and from what else there is farther: the longest name that it begins with.
  std::string longest;
  for (const std::string& one : names)
    if (one.size() >= 3 && one.size() > longest.size() && name.starts_with(one)) longest = one;
  return longest;
}

}  // namespace

int require_clip(const Character& character, std::string_view name_or_index) {
  if (const auto clip = find_clip(character, name_or_index)) return *clip;
  std::vector<std::string> names;
  const std::string near = nearest_clip(character, name_or_index);
  for (size_t i = 0; i < character.clips.size(); ++i)
    names.push_back(character.clips[i].name.empty() ? fmt::format("{} (unnamed)", i) : character.clips[i].name);
  throw Error(printable(character.source), fmt::format("there is no clip '{}'", printable(name_or_index)),
              names.empty() ? "this character has no clips"
              : !near.empty()
                  ? fmt::format("did you mean {}? It has {}", printable(near, 60), nearest_first(name_or_index, names))
                  : fmt::format("give a name or an index from 0 to {}; it has {}", names.size() - 1,
                                nearest_first(name_or_index, names)));
}

}  // namespace crowdbench::scene
