// Pairs: two representations of one crowd, drawn from one camera in step, stacked into one clip with a manifest that
// says what is what. The stimulus of a paired comparison.
#pragma once
#include <filesystem>
#include <string>

#include "renderers/gl/context.h"
#include "renderers/representation.h"
#include "scene/crowd/crowd.h"
#include "scene/scenario/scenario.h"
#include "studies/stimuli/clip.h"
#include "studies/stimuli/stack.h"

namespace crowdbench::studies {

struct PairRequest {
  scene::Scenario scenario;  // its tick rate must be a multiple of the clip's frame rate
  scene::Crowd crowd;        // of this scenario
  renderers::Spec a;
  renderers::Spec b;
  size_t frames = 750;  // the source's 25 s
  uint64_t pair = 0;    // counts the pairs of one study: the side is drawn anew for each
  StackStyle style;
  ClipSettings clip;
};

struct Pair {
  Clip clip;
  bool a_on_top = true;
  bool equal = true;  // both halves of every frame are the same picture: no stimulus to tell apart
  // The manifest's text (JSON): files, hashes, sides and their rule, seed, scenario, encoder, decoded error, renderer.
  std::string manifest;
};

// Draws both, writes `target` (*.mp4), its copies, and the manifest beside it (the same name with .json). When the clip
// missed its accuracy (Pair::clip.accurate), nothing is written. Frame f shows tick f * tick_rate / fps. Shows
// progress. Throws Error, and Interrupted after Ctrl-C.
Pair export_pair(gl::Context& context, const scene::Cast& cast, const PairRequest& request,
                 const std::filesystem::path& target);

}  // namespace crowdbench::studies
