// Clips of another file, played by this character.
//
// Which node plays which: (1) those that the caller names; (2) nodes of one name; (3) where both skeletons are human
// ones by their names, the bones of find_human_bones, for what is still without a counterpart.
//
// How a clip is carried over. Where every node that has a counterpart has its rest transform and its parent's
// counterpart too (the same skeleton), curves are copied as they are. Else, with both rests turned so that the figures
// stand along +Y and face +Z (rest: the nodes' own transforms):
// - rotation: a bone has turned from its rest, in space, as its counterpart has from its own:
//   target(t) = source(t) * source_rest^-1 * aligned * target_rest. `aligned` turns the target's arm and leg bones
//   (upper and lower) at rest to where the source's point, so that a rest with arms raised plays clips of one with arms
//   lowered; hands and fingers go with the lower arm, feet and everything else are taken to rest alike;
// - translation: the hips (else the topmost node that has a counterpart) move as the source's do in space, times the
//   ratio of the leg lengths (else of the hips' heights above the lowest node); all other bones keep their own lengths;
// - scale is not carried over; nodes without a counterpart keep their rest and follow their parents.
// Retargeted curves have keys at all times of the clip's curves and at least 60 a second between them.
#pragma once
#include <string>
#include <vector>

#include "scene/character/character.h"

namespace crowdbench::scene {

struct RetargetOptions {
  std::vector<std::string> bones;  // "mine=theirs": node names, of the character and of the other file
  size_t keys = 10'000'000;        // as GltfLimits::keys
  size_t clips = 4096;             // as GltfLimits::clips: of the character, its own included
};

// Adds the clips of `source` to `target`, whose motion and placement are out of date then (normalise()), and warnings
// that say what has no counterpart. `source` needs nodes and clips alone. Throws Error: nothing matches, a name of
// `bones` that is not there, a mirrored skeleton, a matrix that cannot be animated, limits.
void add_clips_of(const Character& source, Character& target, const RetargetOptions& options = {});

}  // namespace crowdbench::scene
