// Answers on their way out of the result file: jsPsych's JSON, JSON lines, and the table that `study analyze` reads, in
// which what was shown is said by name.
#pragma once
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "store/rows.h"

namespace crowdbench::studies {

struct StudyAnswers {
  std::string study;  // hash of the plan
  std::vector<StudyParticipantRow> participants;
  std::vector<StudyAnswerRow> answers;
};

// Of a result file, or of files that the page saved where no server of ours was (JSON). study: the plan's hash; rows of
// other studies in a result file are left out, a saved file of another one is refused. Throws Error: no such file,
// neither of both, a participant in two saved files, no answers at all.
StudyAnswers read_study_answers(const std::vector<std::filesystem::path>& files, const std::string& study);

// A stimulus as sides.json says it; empty texts: does not apply.
struct ShownStimulus {
  std::string condition;     // by name
  std::string series;        // the condition without the level that a curve is over
  std::string clip;          // which crowd
  std::string level;         // a number
  std::string kind;          // "test", "alike", "identical", "broken" or "pair"
  std::string upper, lower;  // items
  std::string expected;      // the answer that counts as yes
};
// By id. out: the exported folder. study: whose it is to be, where that is known. Throws Error: it is none, of another
// format or of another study.
std::map<std::string, ShownStimulus> read_sides(const std::filesystem::path& out, const std::string& study = {});

// Every record as the page made it, in jsPsych's form: an array, or one record a line.
std::string jspsych_json(const StudyAnswers& answers);
std::string json_lines(const StudyAnswers& answers);

// One row a trial, in the columns that `study analyze` knows by name (observers, study, participant, trial, condition,
// clip, level, signal, answer, expected, rt, frames_dropped, hidden, catch; item_a, item_b and shown_first where items
// are ranked) as far as the study has them, and behind them list, block, stimulus, upper, lower, replays, restarts,
// pixels_per_degree and its standard error, and `state`, which is "finished" of who came to the end. frames_dropped: of
// one showing, the share of all showings that the browser dropped; empty where it does not say. Same or different:
// `signal` is 1 where the halves differ, and `expected` is always "different", so that yes means "said different".
// Left out: training, and trials that have no right answer. `level` is there where all trials have one; levels: only
// trials that do (others: infinity). `condition` is what else than
// the level a condition is made of, where there is one. out: the exported folder; its sides.json says what each
// stimulus was. Throws Error.
std::string answers_csv(const StudyAnswers& answers, const std::filesystem::path& out, bool levels = false);

}  // namespace crowdbench::studies
