// The four temporal channels of a clip: filters over the frames up to the present one.
#pragma once
#include <cstdint>
#include <vector>

#include "metrics/cvvdp/parameters.h"

namespace crowdbench::metrics {

// What stands for the frames before the first.
enum class Padding : uint8_t {
  replicate,  // the first frame
  symmetric   // the clip backwards: frame -1 is 1, -2 is 2
};

namespace vdp {

// 2 ceil(fps / 8) + 1 taps a channel, newest frame first: what is seen of a frame is at its strongest (taps - 1) / 2
// frames later. fps: above 0.
PerChannel<std::vector<double>> temporal_taps(double fps);

// The frame (0 .. frames - 1) that stands at place `i`, which may lie before the clip. frames: at least 2.
size_t padded_frame(int64_t i, size_t frames, Padding padding);

}  // namespace vdp
}  // namespace crowdbench::metrics
