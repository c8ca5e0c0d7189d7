// How long an export will still take: from estimates of one machine, corrected by what was measured on this one.
// Internal to studies/plan.
#pragma once
#include <cstddef>

namespace crowdbench::studies {

// Drawing and encoding go by what each step was estimated to cost, in seconds of another machine: what was made says
// how much faster or slower this one is. Bakes are counted apart, since one takes as long as many clips and the first
// of a representation alone: a bake that is still to come takes what those so far took on average, `bake_guess` before
// the first.
class TimeLeft {
 public:
  TimeLeft(double seconds, double bake_guess) : left_(seconds), guess_(bake_guess) {}

  void set_bakes(size_t to_come) { bakes_ = to_come; }
  // bakes: made or read from the cache within a step, in so many seconds.
  void baked(size_t bakes, double seconds) {
    baked_ += bakes;
    bake_spent_ += seconds;
  }
  // A step is over, estimated to take `seconds`; made: it was not kept from before, and took `spent`, bakes left out.
  void step(double seconds, bool made, double spent) {
    left_ -= seconds;
    if (!made) return;
    made_ += seconds;
    spent_ += spent;
  }

  double seconds() const {
    const double bake = baked_ > 0 ? bake_spent_ / static_cast<double>(baked_) : guess_;
    return left_ * (made_ > 0 ? spent_ / made_ : 1) + static_cast<double>(bakes_) * bake;
  }

 private:
  double left_ = 0, made_ = 0, spent_ = 0;
  double guess_ = 0, bake_spent_ = 0;
  size_t bakes_ = 0, baked_ = 0;
};

}  // namespace crowdbench::studies
