#include "metrics/discontinuity.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <utility>

#include "core/parallel.h"
#include "core/statistics.h"
#include "metrics/sizes.h"

namespace crowdbench::metrics {
namespace {

constexpr int kBlock = 8;

// Sum of absolute differences of the block at (x, y) of `now` to the block at (u, v) of `before`; gives up above
// `most`.
int block_difference(const Image8& now, int x, int y, const Image8& before, int u, int v, int most) {
  int sum = 0;
  for (int row = 0; row < kBlock && sum < most; ++row) {
    const uint8_t* a = now.at(x, y + row);
    const uint8_t* b = before.at(u, v + row);
    for (int i = 0; i < kBlock; ++i) sum += std::abs(a[i] - b[i]);
  }
  return sum;
}

// What motion leaves of the block, a sum over its pixels.
int left_of(const Image8& now, int x, int y, const Image8& before) {
  int least = block_difference(now, x, y, before, x, y, kBlock * kBlock * 255);
  const int top = std::max(0, y - kDiscontinuityReach);
  const int bottom = std::min(now.height - kBlock, y + kDiscontinuityReach);
  const int left = std::max(0, x - kDiscontinuityReach);
  const int right = std::min(now.width - kBlock, x + kDiscontinuityReach);
  for (int v = top; v <= bottom && least > 0; ++v)
    for (int u = left; u <= right; ++u) least = std::min(least, block_difference(now, x, y, before, u, v, least));
  return least;
}

Image8 rounded(const Plane& luma) {
  Image8 out(luma.width, luma.height, 1);
  std::transform(luma.data.begin(), luma.data.end(), out.data.begin(),
                 [](double v) { return static_cast<uint8_t>(std::lround(v)); });
  return out;
}

}  // namespace

void Discontinuities::take(const Plane& luma) {
  Image8 now = rounded(luma);
  if (frames_++ == 0) {
    last_ = std::move(now);
    return;
  }
  require_same_size(now, last_);
  const int columns = now.width / kBlock;
  const int rows = now.height / kBlock;
  Step step;
  std::vector<int> left(static_cast<size_t>(columns) * static_cast<size_t>(rows));
  std::vector<int> change(left.size());
  parallel_for(static_cast<size_t>(rows), threads_, [&](size_t row) {
    for (int column = 0; column < columns; ++column) {
      const size_t block = row * static_cast<size_t>(columns) + static_cast<size_t>(column);
      const int x = column * kBlock;
      const int y = static_cast<int>(row) * kBlock;
      change[block] = block_difference(now, x, y, last_, x, y, kBlock * kBlock * 255);
      left[block] = change[block] == 0 ? 0 : left_of(now, x, y, last_);
    }
  });
  constexpr double kPixels = kBlock * kBlock;
  Jump jump{.frame = frames_ - 1};
  for (size_t b = 0; b < left.size(); ++b) {
    step.left.push_back(left[b] / kPixels);
    step.changed.push_back(change[b] != 0);
    jump.change += change[b] / kPixels / static_cast<double>(left.size());
    jump.left += left[b] / kPixels / static_cast<double>(left.size());
  }
  jumps_.push_back(jump);
  if (step_) finish_step(before_ ? &*before_ : nullptr, *step_, &step);
  before_ = std::move(step_);
  step_ = std::move(step);
  last_ = std::move(now);
}

void Discontinuities::finish_step(const Step* before, const Step& step, const Step* after) {
  if (!before && !after) return;
  double sum = 0;
  size_t count = 0;
  for (size_t b = 0; b < step.left.size(); ++b) {
    double usual = 0;
    bool changed = step.changed[b];
    for (const Step* other : {before, after}) {
      if (!other) continue;
      usual = std::max(usual, other->left[b]);
      changed = changed || other->changed[b];
    }
    if (!changed) continue;
    sum += std::max(0.0, step.left[b] - usual);
    ++count;
  }
  const size_t place = jumps_.size() - (after ? 2 : 1);
  if (count > 0) jumps_[place].jump = sum / static_cast<double>(count);
}

std::vector<Jump> Discontinuities::finish() {
  if (step_) finish_step(before_ ? &*before_ : nullptr, *step_, nullptr);
  std::vector<double> all;
  for (const Jump& jump : jumps_) all.push_back(jump.jump);
  if (all.empty()) return {};
  const double usual = median(all);
  for (Jump& jump : jumps_) jump.found = jump.jump > std::max(kLeastJump, kJumpTimesMedian * usual);
  return jumps_;
}

}  // namespace crowdbench::metrics
