// Simulated observers who answer an exported study: its lists, its trials in their order, adaptive ones by the study's
// own rule. They are no people, and every record says so.
#pragma once
#include <filesystem>
#include <map>
#include <optional>
#include <string>

#include "studies/analysis/simulated.h"
#include "studies/server/answers_export.h"

namespace crowdbench::bench {

// A trial whose stimulus has a level is seen with the probability 1 / (1 + exp(-eta)), eta as SimulatedObservers has
// it, with the clip's effect by crowd; a level that is infinite is seen always, or never. What is seen is answered
// rightly but for slips (`lapse`); of what is not seen, "cannot tell" is said at the rate `cannot_tell` where the task
// offers it, and else the right answer is guessed at the rate `guess`, which the side's bias moves. Of halves that are
// alike, "different" is said at that rate.
//
// Where no level is a number, and of pairs, the halves have worths: Bradley and Terry's choice with Davidson's ties.
// Broken halves are seen by everybody; of a picture shown twice nothing is seen.
struct SimulatedStudy {
  uint32_t observers = 24;
  uint64_t seed = 1;
  studies::SimulatedObservers who;  // its guess is not looked at
  std::optional<double> guess;      // 0.5, and 0.1 of same-different
  double cannot_tell = 0.5;
  std::map<std::string, double> log_worth;  // by item as sides.json calls it; 0 of others
  double log_nu = -1;                       // of ties
};

// out: the exported folder. Observer k answers list k modulo the lists. All of them finish. Throws Error: not an
// exported study, an item that is not in it; Interrupted.
studies::StudyAnswers simulate_study(const std::filesystem::path& out, const SimulatedStudy& simulated);

// As a new result file. Throws Error: it is there already, since simulated answers are not added to others.
void write_simulated(const studies::StudyAnswers& answers, const std::filesystem::path& file);

}  // namespace crowdbench::bench
