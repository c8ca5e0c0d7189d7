// What a scene's rows answer, in figures and sentences without markup.
#pragma once
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "reports/model/scene.h"

namespace crowdbench::reports {

// The answer at a glance: a figure and what it is, in the order of reading; of the first of the scene's
// subjects (equal_levels.h).
struct Tile {
  std::string figure;
  std::string meaning;
};
std::vector<Tile> tiles(const Scene& scene);

// The answer, in a few paragraphs without markup: what each subject costs, from where on it pays, what it gets wrong.
std::vector<std::string> answer(const Scene& scene);

// Every figure of speed is a ratio to the reference, which is held to its own floor: above this many times the floor,
// figures are void. The worst point's line of text; std::nullopt when none is above, or none was measured.
constexpr double kReferenceFloorBound = 1.4;
std::optional<std::string> void_notice(const Scene& scene);

// What the floor of a representation still does, by the representation's name without options, to follow "the floor of
// NAME is".
using FloorTexts = std::map<std::string, std::string>;
// What the floors of a scene's representations are, a sentence each; those that `floors` does not know are left out.
std::string floors_text(const Scene& scene, const FloorTexts& floors);

}  // namespace crowdbench::reports
