#include "renderers/bake/bake_progress.h"

#include <algorithm>
#include <utility>

namespace crowdbench::renderers {

BakeSteps::BakeSteps(BakeProgress progress, const std::vector<double>& weights) : progress_(std::move(progress)) {
  double sum = 0;
  for (const double weight : weights) {
    begins_.push_back(sum);
    sum += weight;
  }
  // Steps that all weigh nothing share evenly.
  for (size_t i = 0; i < begins_.size(); ++i)
    begins_[i] = sum > 0 ? begins_[i] / sum : static_cast<double>(i) / static_cast<double>(begins_.size());
  begins_.push_back(1);
  report(0);
}

BakeProgress BakeSteps::of(size_t step) {
  const double begin = begins_[step];
  const double share = begins_[step + 1] - begin;
  return [this, begin, share](size_t done, size_t total) {
    const double own = total > 0 ? static_cast<double>(done) / static_cast<double>(total) : 1.0;
    report(begin + share * std::min(own, 1.0));
  };
}

void BakeSteps::end() { report(1); }

void BakeSteps::report(double share) {
  // Not to lose a step to rounding.
  done_ = std::max(done_, static_cast<size_t>(share * static_cast<double>(kTotal) + 1e-6));
  if (progress_) progress_(done_, kTotal);
}

}  // namespace crowdbench::renderers
