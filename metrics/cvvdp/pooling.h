// From differences by band, frame and channel to one number.
#pragma once
#include <vector>

#include "metrics/cvvdp/parameters.h"

namespace crowdbench::metrics::vdp {

// Q of one frame: [channel][band], the base band last, without weights. 3 channels of a still, 4 of a clip.
using FrameQ = std::vector<std::vector<double>>;

// P(x, p) = (x + eps)^p - eps^p.
double power(double x, double p);

// The weight of a channel in a band of a still or a clip.
double weight(size_t channel, bool base, bool still);

// Over bands, without the weight of stills: one channel of one frame.
double channel_difference(const FrameQ& q, size_t channel);
// Over bands, then channels: the difference of one frame.
double frame_difference(const FrameQ& q);
// Over frames. One frame is a still. frames: frame_difference() of each; at least one.
double pooled(const std::vector<double>& frames, bool still);

// 10: no difference; a straight line up to 0.1.
double jod_of(double q);

}  // namespace crowdbench::metrics::vdp
