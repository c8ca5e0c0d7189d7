// Tears: what a drawn silhouette leaves out of the reference's inside, and what it draws apart from it. Both are too
// few pixels to move an intersection over union, and are what an eye finds first.
//
// 0 = none, lower is better. Of ids alone: neither colours nor a display have a say. Source: nothing published is
// followed. Limits: what is displaced by two pixels has a seam of holes on one side and of strays on the other; a gap
// or a thread that is one pixel wide in the reference is all edge, and never counts.
#pragma once
#include <optional>

#include "metrics/difference.h"

namespace crowdbench::metrics {

// Counts of pixels, per mille of the reference's silhouette. Neighbours are the eight around a pixel, as far as the
// picture reaches: where its edge cuts a figure there is no edge of the figure.
struct Tears {
  double holes = 0;   // of its pixels whose neighbours are all its own too, those that the test leaves empty; 0 to 1000
  double strays = 0;  // pixels of the test outside of it that touch none of its pixels; 0 and up
};
// Nothing when the reference is empty. Throws Error when the sizes differ.
std::optional<Tears> tears(const Mask& reference, const Mask& test);

}  // namespace crowdbench::metrics
