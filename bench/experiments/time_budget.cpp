#include "bench/experiments/time_budget.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <utility>

namespace crowdbench::bench {

// Warm-up and timed rounds take this share of a point's time each; solving, pictures and scores take the rest.
constexpr double kTimedPart = 0.35;

TimeBudget::TimeBudget(double seconds, size_t points, Clock now)
    : seconds_(seconds), points_left_(points), now_(std::move(now)), begun_(now_()) {}

bool TimeBudget::allows(double expected_s) const { return seconds_ <= 0 || (left() > 0 && expected_s <= left()); }

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

double expected_turn_s(std::span<const Turn> turns, uint32_t agents) {
  if (turns.empty()) return 0;
  const Turn& last = turns.back();
  if (turns.size() < 2)
    return last.seconds * std::max(1.0, std::sqrt(static_cast<double>(agents) / std::max(1U, last.agents)));
  const Turn& before = turns[turns.size() - 2];
  if (before.agents == last.agents) return last.seconds;
  const auto n = [](const Turn& turn) { return static_cast<double>(turn.agents); };
  const double an_agent = (last.seconds - before.seconds) / (n(last) - n(before));
  return std::max(last.seconds, last.seconds + an_agent * (static_cast<double>(agents) - n(last)));
}

double expected_turn_s(std::span<const Turn> turns, std::span<const Turn> before, uint32_t agents) {
  if (!turns.empty()) return expected_turn_s(turns, agents);
  const auto more = std::ranges::find_if(before, [&](const Turn& turn) { return turn.agents > agents; });
  return expected_turn_s(before.first(static_cast<size_t>(more - before.begin())), agents);
}

}  // namespace crowdbench::bench
