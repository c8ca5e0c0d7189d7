// Scores over successive frames of a still camera.
#pragma once
#include <array>
#include <optional>
#include <span>
#include <vector>

#include "metrics/difference.h"

namespace crowdbench::metrics {

// Mean of |(T[t] - 2 T[t-1] + T[t-2]) - (R[t] - 2 R[t-1] + R[t-2])| over every t >= 2 and every pixel of the
// silhouettes of frames t-2 .. t, in luma601() code values: shimmer that the reference has not. 0 = the test changes as
// the reference does; 1020 the most. Frame by frame, so that a clip need not fit in memory.
//
// The second difference is frame t's, the last of the three: an error that comes at frame t and stays is t's and
// t + 1's, one that is in frame t alone t's, twice as much t + 1's, and t + 2's. Limits: code values, not what is seen,
// whatever the frame rate and the screen; an error that grows evenly is none; a camera that moves makes what is wrong
// at edges flicker.
//
// Source: our own; the second difference is the least that a change at a steady rate leaves nothing of.
class Flicker {
 public:
  // All of one size. reference, test: luma601(). silhouette: the frame's union of both masks; none = every pixel
  // counts. Throws Error when sizes differ.
  void take(const Plane& reference, const Plane& test, const Mask* silhouette);
  // Nothing for fewer than three frames or empty silhouettes.
  std::optional<double> value() const;
  // The same of each frame alone; nothing for the first two and where the three silhouettes are empty. value() is the
  // mean of these, each weighted by its pixels.
  const std::vector<std::optional<double>>& by_frame() const { return by_frame_; }
  // What each pixel of the frame taken last adds, NaN where it does not count. Three frames at least were taken
  // (asserted).
  Plane map() const;
  size_t frames() const { return frames_; }

 private:
  struct Frame {
    Plane error;      // luma of the test less luma of the reference
    Mask silhouette;  // empty: every pixel
  };
  bool counts(size_t pixel) const;    // of the three last frames
  double change(size_t pixel) const;  //

  std::array<Frame, 3> last_;  // frame t is at t % 3
  size_t frames_ = 0;
  std::vector<std::optional<double>> by_frame_;
  double sum_ = 0;
  uint64_t count_ = 0;
};

// The same of pictures in hand. reference, test: as many frames each. silhouettes: as many as frames, or none.
std::optional<double> flicker(std::span<const Image8> reference, std::span<const Image8> test,
                              std::span<const Mask> silhouettes = {});

// Mean over all pixels of |(T[t] - T[t-1]) - (R[t] - R[t-1])| of luma601(), one number for each t >= 1: a step where
// the test jumps and the reference does not. 0 = alike; 510 the most. Throws Error when sizes differ.
std::vector<double> step_difference(std::span<const Image8> reference, std::span<const Image8> test);

}  // namespace crowdbench::metrics
