// The proof of a tuning: the representation that it wrote is run on crowds, directions, heights and moments that were
// not measured, and held against what was promised.
//
// What is promised:
//   speed  the reference's frame over the plan's on the scenario with another seed: a 95 % prediction interval, from
//          the logarithms of a few seeds' ratios, normal with an unknown deviation (Student's t);
//   error  of the figures that a bin of the plan draws no more than 5 % are worse than TuneError::promised.
// What the proof says: speed holds unless so few of the unseen seeds lie within the interval as would in less than
// 2.5 % of such proofs were the promise true (chance_of_so_few: all of them meet one interval, which is itself of a few
// seeds, so that they are not independent); error unless so many figures are worse as would
// in less than 2.5 % (binomial, 5 % worse).
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

// The prediction interval alone: positive ratios, at least two.
SpeedPromise promised_speed(std::vector<SeedTimes> seeds);

// Times reference and plan in the same rounds on each of the seeds. Throws Error and Interrupted.
std::vector<SeedTimes> time_seeds(gl::Context& context, const TuneProofRequest& request,
                                  const std::vector<uint64_t>& seeds);
// `count` seeds that differ from `seed` and, for another purpose, from each other's.
enum class SeedsFor : uint8_t { promise, proof };
std::vector<uint64_t> derived_seeds(uint64_t seed, SeedsFor purpose, size_t count);

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
// `views` figures of heights even in their logarithm over the tuning's, unseen directions and moments.
// subject: may be of another character than was tuned: then its own promise is the first subject's.
ErrorProof prove_errors(gl::Context& context, const TuneRequest& request, const TuneResult& result,
                        const TuneSubject& subject, size_t index, const renderers::Spec& representation, size_t views,
                        uint64_t seed);

struct SpeedProof {
  std::vector<SeedTimes> seeds;
  size_t within = 0;
  bool holds = false;
};
// The chance that at most `within` of `unseen` normal values lie within the 95 % prediction interval of `promised`
// others of the same distribution. By simulation of 10,000 promises: the same figure every time, to 0.003.
double chance_of_so_few(size_t within, size_t unseen, size_t promised);
SpeedProof prove_speed(const SpeedPromise& promise, std::vector<SeedTimes> unseen);

}  // namespace crowdbench::bench
