// What a tuning measures of one character: errors by height, what an agent costs, and what a switch shows.
#pragma once
#include <map>
#include <span>
#include <tuple>
#include <vector>

#include "bench/experiments/quality.h"
#include "bench/experiments/tune.h"

namespace crowdbench::bench {

// A score's value turned so that more is worse, infinite ones made large numbers; and back, where means
// and quantiles that an infinite value is part of are infinite.
double badness_of(const metrics::Score& score, double value);
double value_of_badness(const metrics::Score& score, double badness);
double badness_tail(std::span<const double> badnesses);  // the 95th percentile

// A 95 % interval of the 95th percentile of what values are drawn from, from their ranks: the number of values below
// that percentile is binomial, whatever the distribution. Fewer than 72 values have none that is above it with 97.5 %
// confidence: then the largest stands for it.
// Based on: W. J. Conover, "Practical nonparametric statistics", 3rd ed., 1999, section 3.2.
Interval tail_interval(std::vector<double> badnesses);
inline constexpr size_t kTailValues = 72;

// The moments of a clip at which the crowd's pose bank has a sample: there what a representation gets wrong is its own,
// not the bank's. (A crowd's agents are between samples too, in every representation alike.)
class Moments {
 public:
  explicit Moments(const TuneSubject& subject);
  double time(double place) const;  // of the file, seconds; place: of the clip, [0, 1)
  size_t count() const { return count_; }

 private:
  double start_ = 0, step_ = 0;
  size_t count_ = 1;
};

// The directions and moments of a request, at no height yet; no more moments than the clip has samples.
std::vector<QualityView> tune_views(const TuneBlocks& blocks, const TuneSubject& subject, uint64_t seed);

class TuneMeasurement {
 public:
  // context and request must outlive this. Measures errors and costs. Throws Error and Interrupted.
  TuneMeasurement(gl::Context& context, const TuneRequest& request, size_t subject);
  const TuneMeasured& measured() const { return measured_; }
  // What changing from one candidate to the other between bin - 1 and bin shows, measured once.
  const TunePop& pop(size_t from, size_t to, size_t bin);
  // The table of blocks and rounds drawn anew.
  SwitchTable resampled(size_t resample) const;

 private:
  QualitySetup setup_of(const std::vector<size_t>& candidates, const std::vector<double>& heights,
                        metrics::ScoreTable table) const;
  void measure_errors();
  void judge(TuneError& error) const;
  void measure_costs();
  SwitchTable table_of(const std::vector<std::vector<AgentCost>>& costs) const;
  std::vector<AgentCost> resampled_costs(std::vector<AgentCost> costs, size_t resample) const;
  TunePop measured_pop(size_t from, size_t to, double height) const;
  double worst_step(const renderers::Capture& a, const renderers::Capture& b) const;

  gl::Context& context_;
  const TuneRequest& request_;
  size_t index_;  // of the subject
  const TuneSubject& subject_;
  std::vector<QualityView> blocks_;
  std::vector<size_t> timed_;  // candidates that were not refused
  std::map<std::tuple<size_t, size_t, size_t>, TunePop> pops_;
  TuneMeasured measured_;
};

}  // namespace crowdbench::bench
