// The proof of a tuning: the representation that it wrote is run on crowds, directions, heights and moments that were
// not measured, and held against what was promised.
//
// What is promised of the characters that were tuned:
//   speed  the reference's frame over the plan's on the scenario with another seed: a 95 % prediction interval, from
//          the logarithms of a few seeds' ratios, normal with an unknown deviation (Student's t), which is never taken
//          to be less than what the rounds of one seed leave open: seeds that happen to agree more closely promise
//          nothing that a measurement could keep;
//   score  the mean of the error's score over so many figures as another seed draws: the same interval, but from how
//          much the figures of one height differ between those seeds (promised_score), which says more of the
//          deviation than the few means do;
//   error  of the figures that a bin of the plan draws no more than 5 % are worse than TuneError::promised.
// What the proof says: speed and score hold unless so few of the unseen seeds lie within their interval as would in
// less than 2.5 % of such proofs were the promise true (chance_of_so_few: all of them meet one interval, which is
// itself of a few seeds, so that they are not independent); error unless so many figures are worse as would in less
// than 2.5 % (binomial, 5 % worse). Nothing of this is promised of another character: tune_others.h.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "bench/experiments/tune.h"
#include "bench/stage/stage_scenario.h"

namespace crowdbench::bench {

struct TuneProofRequest {
  scene::Scenario scenario;  // placed: no occupancy is solved for any more
  const scene::Cast* cast = nullptr;
  renderers::Spec representation;  // tuned_representation
  int rounds = 12;
  uint64_t bake_budget = uint64_t{512} << 20;
};

// The frames of one seed.
struct SeedTimes {
  uint64_t seed = 0;
  double ratio = 0;  // reference over plan: the median of the rounds' ratios
  Interval interval;
  double reference_ns = 0, plan_ns = 0;  // medians
};

struct SpeedPromise {
  std::vector<SeedTimes> seeds;  // that it is made from: at least two
  double ratio = 0;              // the geometric mean
  Interval on_another_seed;
  double plan_ns = 0;  // median over the seeds of the plan's frame
};
inline constexpr size_t kPromiseSeeds = 5;

// Positive ratios, at least two.
SpeedPromise promised_speed(std::vector<SeedTimes> seeds);

// Times reference and plan in the same rounds on each of the seeds. Throws Error and Interrupted.
std::vector<SeedTimes> time_seeds(gl::Context& context, const TuneProofRequest& request,
                                  const std::vector<uint64_t>& seeds);
// `count` seeds that differ from `seed` and, for another purpose, from each other's.
enum class SeedsFor : uint8_t { promise, proof, characters };
std::vector<uint64_t> derived_seeds(uint64_t seed, SeedsFor purpose, size_t count);

// A 95 % prediction interval for one more value of what at least two are drawn from, taken to be normal with unknown
// mean and deviation; least_variance: that each has by itself, below which their own is not believed. Unbounded where
// one of them is not finite and not all are the same.
Interval prediction_interval(const std::vector<double>& values, double least_variance = 0);
// The variance of the logarithm of a ratio that its own rounds leave open, from its 95 % interval: the mean over seeds;
// 0 of those without an interval.
double rounds_variance(const std::vector<SeedTimes>& seeds);
// To nine digits.
bool lies_within(const Interval& interval, double value);

// One figure that was not measured, drawn by the plan.
struct UnseenFigure {
  size_t place = 0;  // among those that its seed draws: the same place is the same height of the same subject
  double height_px = 0;
  double value = 0;  // of the error's score
};
// `count` figures of heights even in their logarithm over the tuning's, unseen directions and moments; those that have
// a score. Throws Error and Interrupted.
std::vector<UnseenFigure> draw_unseen(gl::Context& context, const TuneRequest& request, const TuneSubject& subject,
                                      const renderers::Spec& representation, size_t count, uint64_t seed);
inline constexpr size_t kSeedFigures = 24;  // of each subject, a seed

// What the figures of a seed score.
struct SeedScores {
  uint64_t seed = 0;
  size_t figures = 0;  // of all subjects, equally many each
  double mean = 0;
  double tail = 0;               // the bad end's 5 %
  std::vector<double> by_place;  // NaN where a place has no score
};
SeedScores scores_of(const metrics::Score& score, uint64_t seed, const std::vector<UnseenFigure>& figures);

struct ScorePromise {
  std::vector<SeedScores> seeds;  // that it is made from: at least two
  double mean = 0;                // of their means
  Interval on_another_seed;       // of the mean over another seed's figures, no better than the score's best
  double degrees = 0;             // of freedom of what the interval's width is from
};
// The ends of an interval, where they are better than the score's best, put there.
Interval within_range(const metrics::Score& score, Interval interval);
// Figures are drawn independently of each other, each place at its own height: the variance of a seed's mean is that of
// a place between seeds, averaged over the places and divided by their number, with the degrees of freedom of
// Satterthwaite. Of promises from five means alone, as of a normal value, 8 % hold on under 80 % of seeds; of these
// under 1 %. As prediction_interval of the means where figures are not finite, or no place has two. Based on: W. G.
// Cochran, "Sampling Techniques", 1977, chapter 5 (variance of a stratified mean); F. E. Satterthwaite, "An approximate
// distribution of estimates of variance components", Biometrics Bulletin 2 (1946).
ScorePromise promised_score(const metrics::Score& score, std::vector<SeedScores> seeds);

struct ScoreProof {
  std::vector<SeedScores> seeds;
  size_t within = 0;
  bool holds = false;
};
ScoreProof prove_score(const ScorePromise& promise, std::vector<SeedScores> unseen);

// Figures of one subject against the promise of the bins that draw them.
struct ErrorProof {
  size_t subject = 0;
  size_t views = 0;
  size_t worse = 0;           // than was promised of their bin
  size_t over_threshold = 0;  // worse than the request's threshold
  double tail = 0;            // the bad end's 5 % of all of them
  double worst = 0;
  double worst_height_px = 0;
  bool holds = false;
};
// Of the plan for all.
ErrorProof prove_errors(const TuneRequest& request, const TuneResult& result, size_t subject,
                        const std::vector<UnseenFigure>& figures);

struct SpeedProof {
  std::vector<SeedTimes> seeds;
  size_t within = 0;
  bool holds = false;
};
// The chance that at most `within` of `unseen` normal values lie within the 95 % prediction interval of `promised`
// others of the same distribution, whose variance is known with so many degrees of freedom (promised - 1 where it is
// from them alone). By simulation of 10,000 promises: the same figure every time, to 0.003.
double chance_of_so_few(size_t within, size_t unseen, size_t promised, double degrees);
SpeedProof prove_speed(const SpeedPromise& promise, std::vector<SeedTimes> unseen);

}  // namespace crowdbench::bench
