// Which joints make a body part: what a polypostor cuts a character into.
#pragma once
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "scene/character/character.h"
#include "scene/pose/pose_bank.h"

namespace crowdbench::renderers {

// part_of[joint]: 0 .. count - 1; every part has a joint that moves a triangle. Part 0 is the trunk where there is one.
struct PartMap {
  std::vector<int> part_of;
  int count = 0;
};

struct BodyParts {
  PartMap fine;
  PartMap coarse;  // last segments of limbs of three joined to those before: hands to lower arms, feet to lower legs
};

// From the hierarchy, the lengths of the bones and the surface that each moves; no name is read. The trunk is every
// node above a branching into two subtrees of 1.5 % of the surface each, of a subtree that holds a quarter of it; what
// hangs from the trunk is a limb, cut at its joints into at most three segments, none shorter than 6 % of the height or
// smaller than 0.8 % of the surface. Lighter subtrees of 0.3 % that hang more than a fifth of the height from every
// branching of the trunk are parts too. What is too small to be cut off belongs to what it hangs from.
BodyParts find_parts(const scene::Character& character);

// cuts: joints, by name or by index, joined by "+"; each begins a part that ends where another one begins. What is
// above all of them is a part too. Both maps are that one. Throws Error naming `where`: an unknown joint.
BodyParts cut_parts(const scene::Character& character, const std::string& cuts, const std::string& where);

// The character with its triangles cut where parts end. A point of the surface, whose weights are interpolated between
// the corners of its triangle, belongs to every part that has at least kBorderWeight of them: to two around a joint, so
// that no gap opens there. Cuts follow the lines of that weight across triangles. (A triangle whose middle so many
// parts share that none has as much is the one's that has most.) Corners made on edges carry what lies between the
// ends: everything is interpolated, and of the joints the four of most weight are kept.
//
// A corner made on an edge is carried by what is interpolated of both ends' matrices; the surface's point there is what
// lies between the ends as they are carried. Where these are farther apart than `metres` in any of the palettes, the
// triangle is not cut: it belongs, whole, to every part that has as much of its middle.
struct CutAccuracy {
  std::span<const std::vector<scene::Mat3x4>> palettes;  // none: every triangle is cut
  double metres = 0;
};
struct CutCharacter {
  std::shared_ptr<const scene::Character> character;
  std::vector<std::vector<uint32_t>> triangles;  // by part: indices of triangles, ascending
};
inline constexpr float kBorderWeight = 0.3F;
CutCharacter cut_at_parts(const scene::Character& character, const PartMap& parts, const CutAccuracy& accuracy = {});

}  // namespace crowdbench::renderers
