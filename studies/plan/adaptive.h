// Methods that choose the next stimulus by the answers so far: what they may choose from, and the rule.
//
// The study's page chooses while a participant sits there (studies/page/adaptive.js); the rule here is the same one,
// and a test holds both to the same choices. It uses one participant's own answers alone, and no state but these: after
// a reload it goes on as it would have.
#pragma once
#include <map>
#include <span>
#include <string>
#include <vector>

#include "core/json.h"
#include "studies/analysis/quest_plus.h"
#include "studies/plan/design.h"

namespace crowdbench::studies {

// A level, or a pair of items, and the stimuli that show it.
struct AdaptiveChoice {
  double level = 0;                  // quest-plus
  size_t a = 0, b = 0;               // active-pairs: items
  std::vector<std::string> stimuli;  // every crowd, either way up
};

struct AdaptiveRule {
  Method method = Method::quest_plus;  // not constant
  // quest-plus. The grid: 31 thresholds over the levels, nine slopes, guess and lapse as far as the analysis does not
  // hold them. threshold and slope are location and scale of studies/analysis/psychometric.h.
  Curve curve = Curve::logistic;
  bool falling = false;
  std::vector<double> threshold, slope, guess, lapse;
  std::vector<std::string> items;       // active-pairs: what is ranked
  std::vector<AdaptiveChoice> choices;  // levels ascending; pairs by items
  std::vector<std::string> alike;       // same-different: stimuli with nothing to see
  // By stimulus, the answer that counts as yes: right, or "different"; of a pair, that its first item is chosen.
  std::map<std::string, std::string> yes;
};

// plan: of a method that adapts.
AdaptiveRule adaptive_rule(const StudyPlan& plan, const StudyDesign& design);
// Whether the trial's stimulus is chosen when its turn comes: main trials that show a level or a pair. All else (catch
// and training trials, and what is alike of same-different) is of the list.
bool is_chosen(const StudyPlan& plan, const StudyDesign& design, const Trial& trial);

struct GivenAnswer {
  std::string stimulus, answer;
};
// By choice, how much its answer is expected to tell, in nats: the information of pairs; of levels minus the entropy
// that is left, which differs from it by what all choices have in common. before: as below.
std::vector<double> choice_worths(const AdaptiveRule& rule, std::span<const GivenAnswer> before);
// The stimulus of a chosen trial. Of the levels, or pairs, whose answer is expected to tell most (equal to 1e-9 nats:
// the first by SHA-256 of "STUDY/LIST/TRIAL/INDEX"); of its stimuli one that was shown least often so far (equal: the
// first by SHA-256 of "STUDY/LIST/TRIAL/STIMULUS"). before: this participant's answers to main trials, in the order of
// the list.
std::string chosen_stimulus(const AdaptiveRule& rule, const std::string& study, const std::string& list,
                            const std::string& trial, std::span<const GivenAnswer> before);

// The rule as trials.json and study.json hold it.
Json adaptive_json(const AdaptiveRule& rule);
// Such a rule, read again; items have no names there. Throws Error at `where`: no such rule, or one that nothing can be
// chosen by.
AdaptiveRule parse_adaptive(const std::string& json, const std::string& where);
// What a frozen plan says of it: the method's settings, without what an export names.
Json adaptive_meaning(const StudyPlan& plan);

}  // namespace crowdbench::studies
