#include "bench/experiments/time_budget.h"

#include <algorithm>
#include <chrono>
#include <limits>
#include <utility>

namespace crowdbench::bench {

// Warm-up and timed rounds take this share of a point's time each; solving, pictures and scores take the rest.
constexpr double kTimedPart = 0.35;

TimeBudget::TimeBudget(double seconds, size_t points, Clock now)
    : seconds_(seconds), points_left_(points), now_(std::move(now)), begun_(now_()) {}

bool TimeBudget::allows(double least_s) const { return seconds_ <= 0 || (left() > 0 && least_s <= left()); }

double TimeBudget::share(double limit_s) const {
  if (seconds_ <= 0) return limit_s;
  return std::min(limit_s, kTimedPart * left() / static_cast<double>(std::max<size_t>(points_left_, 1)));
}

void TimeBudget::point_done() {
  if (points_left_ > 0) --points_left_;
}

double TimeBudget::left() const {
  if (seconds_ <= 0) return std::numeric_limits<double>::infinity();
  return std::max(0.0, begun_ + seconds_ - now_());
}

double TimeBudget::steady_seconds() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

}  // namespace crowdbench::bench
