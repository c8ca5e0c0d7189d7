// How much of the time for a whole sweep each of its points may take.
#pragma once
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>

namespace crowdbench::bench {

// Counts from its construction.
class TimeBudget {
 public:
  using Clock = std::function<double()>;  // seconds from any origin, never falling
  // seconds: for `points` points together, 0 for no limit.
  TimeBudget(double seconds, size_t points, Clock now = steady_seconds);
  // Whether a point that is expected to take so long ends within the budget.
  bool allows(double expected_s) const;
  // Seconds that the warm-up and the timed rounds of the next point may take, each: an even share of what is left, less
  // what is needed beside them, and never more than limit_s.
  double share(double limit_s) const;
  void point_done();
  double left() const;  // seconds, not below 0; infinite without a limit
  bool over() const { return left() <= 0; }

  static double steady_seconds();

 private:
  double seconds_;
  size_t points_left_;
  Clock now_;
  double begun_;
};

// Every variant of a point drawn once.
struct Turn {
  uint32_t agents = 0;
  double seconds = 0;
};
// What a turn of so many agents takes, by the line through the last two turns, of other numbers of agents: part of a
// turn does not grow with them. Of one turn, which does not say how it grows: the geometric mean of as long, and of as
// many times as long as there are more agents. Never less than the last; 0 of none.
double expected_turn_s(std::span<const Turn> turns, uint32_t agents);
// The same from the turns at this occupancy, in which agents ascend; where there are none yet, from those at the
// occupancy before, of no more agents than these.
double expected_turn_s(std::span<const Turn> turns, std::span<const Turn> before, uint32_t agents);

}  // namespace crowdbench::bench
