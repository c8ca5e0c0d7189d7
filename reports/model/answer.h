// What a scene's rows answer, in figures and sentences without markup.
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "reports/model/scene.h"

namespace crowdbench::reports {

// The answer at a glance: a figure and what it is, in the order of reading; of the first representation that is not the
// reference.
struct Tile {
  std::string figure;
  std::string meaning;
};
std::vector<Tile> tiles(const Scene& scene);

// The answer, in a few paragraphs without markup: what it costs, from where on it pays, what it gets wrong.
std::vector<std::string> answer(const Scene& scene);

// Every figure of speed is a ratio to the reference, which is held to its own floor: above this many times the floor,
// figures are void. The worst point's line of text; std::nullopt when none is above, or none was measured.
constexpr double kReferenceFloorBound = 1.4;
std::optional<std::string> void_notice(const Scene& scene);

// What the floor of a representation is: the reference's in a few words, and all of them in a clause each.
std::string reference_floor_text();
std::string floors_text();

}  // namespace crowdbench::reports
