// One condition of a plan measured: its points, the reference and its A/A twin, drawn in the same rounds.
#pragma once
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "bench/sweep/plan.h"
#include "bench/timing/timing_method.h"
#include "renderers/gl/context.h"
#include "store/store.h"

namespace crowdbench::bench::sweep {

// What a condition becomes in the store, not yet written: ids are given by it.
struct MeasuredPoint {
  SweepPointRow row;
  std::optional<MeasurementRow> measurement;
  std::vector<RatioRow> ratios;
  std::optional<ComparisonRow> comparison;
  std::vector<PictureRow> pictures;
};
struct MeasuredCondition {
  RunRow run;
  std::vector<MeasuredPoint> points;  // those of the plan in its order, then the reference and its twin
};

class ConditionBench {
 public:
  // note: called with what is going on now. All must outlive it.
  ConditionBench(gl::Context& context, const TimingMethod& method, const Plan& plan,
                 std::function<void(const std::string&)> note);
  ~ConditionBench();

  // What cannot be drawn is a point with its reason, never an exception; Interrupted passes through. What it shows does
  // not depend on the conditions measured before: characters and bakes are kept from one to the next, nothing else.
  MeasuredCondition measure(size_t condition, int repetition);

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

// One transaction: all rows of a condition and repetition, or none. Throws Error.
void write_condition(StoreWriter& store, int64_t sweep, const MeasuredCondition& measured);

}  // namespace crowdbench::bench::sweep
