// Discontinuity: in which of a sequence's frames something changes that motion does not explain. For sequences of which
// nothing but the pictures is known; where the switches are known, score_pop() (metrics/popping.h) says more.
//
// Each frame is cut into blocks of 8 x 8 pixels. What motion leaves of a block is its mean absolute difference of luma
// to the most similar place of the frame before, at most kDiscontinuityReach pixels away. Uncovered ground, turning
// limbs and noise leave something in every step; what pops leaves much in one step only. So the jump of a block is how
// much more the step to frame t leaves than the steps before and after it do, and the jump of a frame is the mean over
// those blocks that change at all from t-2 to t+1. It is of the whole picture: a single figure that pops in a crowd is
// lost among turning limbs.
// Based on: block matching by exhaustive search (Jain and Jain 1981, "Displacement measurement and its application in
// interframe image coding") for the motion. The comparison with the neighbouring steps is an addition.
#pragma once
#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "metrics/difference.h"

namespace crowdbench::metrics {

constexpr int kDiscontinuityReach = 8;
// A frame is found where its jump is above both: code values, and times the median jump of the sequence.
constexpr double kLeastJump = 2;
constexpr double kJumpTimesMedian = 8;

struct Jump {
  size_t frame = 0;   // counted from 0: what is new in it
  double change = 0;  // mean |luma - luma of the frame before| over the picture, code values
  double left = 0;    // of it by motion unexplained: mean over blocks
  double jump = 0;    // see above, code values
  bool found = false;
};

// Frames are shown to it in order, one at a time; it keeps one, and what is left of three steps.
class Discontinuities {
 public:
  explicit Discontinuities(unsigned threads = 0) : threads_(threads) {}
  // luma: luma601(), all of one size and at least one block. Throws Error when sizes differ.
  void take(const Plane& luma);
  size_t frames() const { return frames_; }
  // One for each frame but the first. The first and the last step have one neighbour, and so a less certain jump; a
  // sequence of two frames has no jump at all.
  std::vector<Jump> finish();

 private:
  struct Step {
    std::vector<double> left;   // by block
    std::vector<bool> changed;  // by block: any pixel
  };
  void finish_step(const Step* before, const Step& step, const Step* after);

  unsigned threads_;
  size_t frames_ = 0;
  Image8 last_;
  std::optional<Step> before_, step_;
  std::vector<Jump> jumps_;
};

}  // namespace crowdbench::metrics
