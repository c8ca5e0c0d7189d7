// Error by cause of a representation's picture against the mesh's: the chain of pictures of metrics/causes.h, drawn.
#pragma once
#include <memory>
#include <string>
#include <vector>

#include "bench/experiments/cause_surfaces.h"
#include "metrics/causes.h"

namespace crowdbench::bench {

// What a representation stores of a cast, as its type says it.
struct StoredWhat {
  std::vector<renderers::ViewSampling> views;  // by character; empty where it stores no views
  bool of_several = false;                     // it is made of others: `components`
  bool by_part = false;                        // a view's picture is not of the whole figure
  bool planes = false;                         // its depths are not those of the surfaces that it shows
  std::vector<StoredWhat> components;          // as Representation::components() has them
};
StoredWhat stored_by(const renderers::Spec& spec, const scene::Cast& cast);

struct CauseFrame {
  const renderers::Capture& reference;  // the mesh's picture of the frame
  const scene::Frame& posed;            // with the poses that the representation shows, of the mesh's cast
  const scene::Frame& frame;            // of the representation's cast
  double height = 0;                    // metres, of a figure: 1 % of it is the tolerance between depths
};

struct CausePictures {
  std::vector<metrics::CauseStep> steps;  // the last is the representation's picture
  metrics::CauseErrors errors;
  int level_samples =
      1;  // pixels of the picture in which the finest level was drawn, for one of the frame along a side
};

// mesh draws `posed`, test draws `frame`: the same agents, seen by the same camera; `posed` has the poses of `frame`
// where the representation is made of several. Representations with a history must be at the frame's tick. Throws
// Error.
CausePictures draw_causes(const CauseFrame& of, const Drawer& mesh, const Drawer& test, const StoredWhat& stored);

// Gives every agent the pose of the stored frame that the representation shows for its phase (shown_phase), as the
// cast's banks blend it; every other stays as it is.
void show_stored_frames(scene::Frame& frame, const scene::Cast& cast, const renderers::Representation& representation);

}  // namespace crowdbench::bench
