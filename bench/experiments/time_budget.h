// How much of the time for a whole sweep each of its points may take.
#pragma once
#include <cstddef>
#include <functional>

namespace crowdbench::bench {

// Counts from its construction.
class TimeBudget {
 public:
  using Clock = std::function<double()>;  // seconds from any origin, never falling
  // seconds: for `points` points together, 0 for no limit.
  TimeBudget(double seconds, size_t points, Clock now = steady_seconds);
  // Whether a point that takes `least_s` seconds at least ends within the budget.
  bool allows(double least_s) const;
  // Seconds that the warm-up and the timed rounds of the next point may take, each: an even share of what is left, less
  // what is needed beside them, and never more than limit_s.
  double share(double limit_s) const;
  void point_done();
  double left() const;  // seconds, not below 0; infinite without a limit

  static double steady_seconds();

 private:
  double seconds_;
  size_t points_left_;
  Clock now_;
  double begun_;
};

}  // namespace crowdbench::bench
