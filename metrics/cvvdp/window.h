// The last frames of a clip, and what its temporal channels are at one of them.
#pragma once
#include <vector>

#include "metrics/cvvdp/frame.h"
#include "metrics/cvvdp/opponent.h"
#include "metrics/cvvdp/temporal_filter.h"

namespace crowdbench::metrics::vdp {

class FrameWindow {
 public:
  // fps: above 0.
  FrameWindow(double fps, Padding padding);

  size_t length() const { return taps_[0].size(); }
  // The place of a frame, [0] of the test, [1] of the reference; that of `length()` frames before is given up.
  std::array<OpponentPlanes, 2>& place(size_t frame);
  // The channels at `frame` of a clip of `frames`, of which those that the filter reaches are in place. threads: at
  // least 1.
  void filter(size_t frame, size_t frames, FramePlanes& out, unsigned threads) const;

 private:
  PerChannel<std::vector<double>> taps_;
  Padding padding_;
  std::vector<std::array<OpponentPlanes, 2>> places_;
};

}  // namespace crowdbench::metrics::vdp
