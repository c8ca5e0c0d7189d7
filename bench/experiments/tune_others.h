// What a tuning of several characters promises of a character that it was not of: how much slower or uglier a new one
// may be is read from what the rule does to each tuned character that it was not made from.
//
// Of every character the rule of all the others is sought and drawn: a crowd of that character alone on a seed of its
// own, and unseen figures of it. Each character so gives one ratio, one mean score and one bad end's 5 %, as a new
// character does under the rule of all; what is promised of the new one is the 95 % prediction interval of each of the
// three (prediction_interval: as if characters were drawn from one normal distribution). Of fewer than three nothing is
// promised: two have no spread that an interval could be made of. Rules within a budget promise nothing either: the
// rule of fewer agents has more time for each.
// Based on: leave-one-out prediction, M. Stone, "Cross-validatory choice and assessment of statistical predictions",
// 1974; the interval, G. J. Hahn and W. Q. Meeker, "Statistical Intervals", 1991, chapter 4.
#pragma once
#include <string>
#include <vector>

#include "bench/experiments/tune_proof.h"

namespace crowdbench::bench {

inline constexpr size_t kLeastCharacters = 3;
// Why a request promises nothing of other characters; empty where it does.
std::string no_promise_of_others(const TuneRequest& request);

// A character under a rule that was made without it.
struct CharacterDrawn {
  std::string character;
  std::string representation;      // of the rule
  std::vector<SeedTimes> times;    // of crowds of it alone; at least one
  std::vector<SeedScores> scores;  // of the same seeds
  double ratio = 0;                // reference over rule: the geometric mean of the seeds'
  double mean = 0;                 // of the error's score, over all figures
  double tail = 0;                 // the bad end's 5 % of them
};
// request: its scenario has that character alone. Throws Error and Interrupted.
CharacterDrawn draw_character(gl::Context& context, const TuneRequest& tuned, const TuneProofRequest& request,
                              const TuneSubject& subject, const std::vector<uint64_t>& seeds);
inline constexpr size_t kCharacterFigures = 72;  // of a character, over all its seeds

struct OthersPromise {
  std::vector<CharacterDrawn> left_out;  // by subject
  double ratio = 0, mean = 0, tail = 0;  // over them, the ratio's in its logarithm
  Interval ratio_of_another, mean_of_another, tail_of_another;
};
// left_out: at least kLeastCharacters.
OthersPromise promised_of_others(const metrics::Score& score, std::vector<CharacterDrawn> left_out);

// One new character is one draw, whatever the number of its seeds.
struct OtherProof {
  CharacterDrawn drawn;
  bool ratio_within = false, mean_within = false, tail_within = false;
  bool holds() const { return ratio_within && mean_within && tail_within; }
};
OtherProof prove_other(const OthersPromise& promise, CharacterDrawn drawn);

}  // namespace crowdbench::bench
