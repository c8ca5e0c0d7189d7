// The design that follows from a plan: which clips are drawn, which pairs of them are shown, and in which order and on
// which side every participant sees them. A pure function of the plan.
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "studies/plan/plan.h"

namespace crowdbench::studies {

// One crowd drawn once from one camera: half of some stimuli.
struct PlannedHalf {
  std::string key;           // of all that decides its frames, 16 hexadecimal digits
  size_t condition = 0;      // whose scenario and camera it has
  scene::Scenario scenario;  // with this half's seed
  renderers::Spec spec;
};

enum class StimulusKind : uint8_t {
  test,       // the half under test against the reference
  alike,      // reference against reference: nothing to see but the crowd, or the same picture twice
  identical,  // a catch trial: one picture twice
  broken,     // a catch trial: the wrong half is seen by anybody
  pair        // two conditions against each other, for scaling
};
const char* stimulus_word(StimulusKind kind);

struct Stimulus {
  std::string id;  // "s001": by a permutation, so that it tells nothing
  StimulusKind kind = StimulusKind::test;
  size_t upper = 0, lower = 0;         // halves
  std::optional<bool> test_on_top;     // of test, broken and pair (whose first item stands for the test)
  size_t condition = 0;                // pair: the first item's
  uint32_t crowd = 0;                  // which of the plan's crowds the test half shows
  std::optional<size_t> twin;          // the reference's half of the crowd that the test half shows
  std::string item_upper, item_lower;  // what is compared, by name
  // The answer that counts as yes: "upper", "lower", "same", "different"; empty: none is right, as of
  // what is identical, whose answers show side bias.
  std::string expected;
};

enum class TrialKind : uint8_t { training, main, catch_trial };
const char* trial_word(TrialKind kind);

struct Trial {
  size_t stimulus = 0;
  uint32_t block = 0;  // 0: training, then from 1
  TrialKind kind = TrialKind::main;
};

struct StudyDesign {
  std::vector<PlannedHalf> halves;
  std::vector<Stimulus> stimuli;          // by id
  std::vector<std::vector<Trial>> lists;  // one a list
};

StudyDesign make_design(const StudyPlan& plan);

// What a round of a list orders: the conditions, twice of same-different trials, or what is ranked.
uint32_t order_items(const StudyPlan& plan);
// The smallest number of lists over which orders (Williams 1949) and sides are balanced; multiples of it are, too.
uint32_t balanced_lists(const StudyPlan& plan);
uint64_t main_trials(const StudyPlan& plan);            // of one participant, without catch and training trials
uint64_t trials_of_participant(const StudyPlan& plan);  // all of them
// After how many trials of a list, training included, a block ends and another follows.
std::vector<uint64_t> breaks_of(const StudyPlan& plan);
// Rows of the answers that a task has, as trials.json lists them: value, label, key.
struct AnswerChoice {
  std::string value, label, key;
};
std::vector<AnswerChoice> answer_choices(Task task);

}  // namespace crowdbench::studies
