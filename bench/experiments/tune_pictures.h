// Pictures of a plan's switches: the figure just before and just after, from the direction and at the moment in which
// the switch shows most of those that were tried.
#pragma once
#include <vector>

#include "bench/experiments/quality.h"
#include "bench/experiments/tune.h"
#include "core/image.h"

namespace crowdbench::bench {

struct TuneSwitchPictures {
  size_t subject = 0;
  QualityView view;
  double pop = 0;  // what the switch shows there, of the pop's score
  // Cut to both figures; sRGB code values. `difference` is in false colours. Empty where nothing is drawn.
  Image8 before, after, difference;
};

// One an answer's switch, in their order. Throws Error and Interrupted.
std::vector<TuneSwitchPictures> draw_switches(gl::Context& context, const TuneRequest& request,
                                              const TuneAnswer& answer);

}  // namespace crowdbench::bench
