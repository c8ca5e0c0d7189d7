// Scores over successive frames of a still camera.
#pragma once
#include <optional>
#include <span>
#include <vector>

#include "metrics/difference.h"

namespace crowdbench::metrics {

// Mean of |(T[t] - 2 T[t-1] + T[t-2]) - (R[t] - 2 R[t-1] + R[t-2])| over every t >= 2 and every pixel of the
// silhouettes of frames t-2 .. t, in luma601() code values: shimmer that the reference has not. 0 = the test changes as
// the reference does; 1020 the most. reference, test: as many frames each, all of one size. silhouettes: a frame's
// union of both masks, as many as frames; none = every pixel counts. Nothing for fewer than three frames or empty
// silhouettes. Throws Error when sizes differ.
std::optional<double> flicker(std::span<const Image8> reference, std::span<const Image8> test,
                              std::span<const Mask> silhouettes = {});

// Mean over all pixels of |(T[t] - T[t-1]) - (R[t] - R[t-1])| of luma601(), one number for each t >= 1: a step where
// the test jumps and the reference does not. 0 = alike; 510 the most. Throws Error when sizes differ.
std::vector<double> step_difference(std::span<const Image8> reference, std::span<const Image8> test);

}  // namespace crowdbench::metrics
