// Whether a tuned rule, which is in pixels, holds in other pictures and through other lenses: the same heights are
// drawn and scored there.
//
// Of every bin from which a representation other than the reference draws on, figures of the bin's height are drawn in
// the middle of pictures of each size and lens, from directions and moments of the tuning. Pixels per degree stay those
// of the tuning's display: at more of them less is seen, not more. A figure that needs more rows than a picture
// has is not drawn there.
#pragma once
#include <vector>

#include "bench/experiments/tune.h"

namespace crowdbench::bench {

struct TuneLens {
  int rows = 720;
  double fov_y_deg = 30;
};
// 720p, 1080p and 4K through 30 and 90 degrees.
std::vector<TuneLens> usual_lenses();

struct TuneLensCheck {
  size_t subject = 0;
  TuneLens lens;
  size_t bin = 0, candidate = 0;
  bool skipped = false;  // the figure is too tall for the lens's rows: nothing was drawn, what follows says nothing
  size_t views = 0;
  double tail = 0;                // the bad end's 5 % there
  double tuned_tail = 0;          // the same through the tuning's own lens, of the same directions and moments
  double mean_difference = 0;     // there less at the tuning's own lens, same directions and moments
  double largest_difference = 0;  // of a view, either way
  size_t worse = 0;               // views worse than was promised (TuneError::promised)
  // Unless so many worse ones would come up in less than 2.5 % of such checks were 5 % of all worse.
  bool holds = false;
};

// views: at most so many of the tuning's, evenly taken. answer: with a plan. Throws Error and Interrupted.
std::vector<TuneLensCheck> check_lenses(gl::Context& context, const TuneRequest& request, const TuneResult& result,
                                        const std::vector<TuneLens>& lenses, size_t views = 24);

}  // namespace crowdbench::bench
