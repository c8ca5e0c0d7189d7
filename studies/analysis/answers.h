// Answers of a study, whatever file they come from: one structure that every analysis reads.
//
// An answer is one of three: yes (right, seen, the first of two things), no, or "cannot tell". A row holds how many of
// each: one alone for a trial, any number for a table of counts.
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "studies/analysis/table.h"

namespace crowdbench::studies {

// Which column of a table plays which role. A table must have `answer`, or `yes` and one of `no` and `total`.
//   participant, trial  who, and which of theirs; a trial of a participant may stand in one row only
//   task                what was asked; answers of several tasks are analysed apart
//   condition           what is compared; several columns may be conditions (their values are joined)
//   clip                what was shown, where several clips show one condition
//   stimulus            what exactly was shown, by the id that study.json has: for objective scores
//   level               a number: the axis of the psychometric function (distance, height, ratio); 0, or of a size
//                       from 1e-15 to 1e15
//   signal              whether there was something to see (1) or not (0): d' and criterion
//   item_a, item_b      the two things compared, by name; `yes` is then a choice of item_a
//   shown_first         the item that stood first (above, or left): for the effect of position
//   yes_first           whether what counts as yes stood first (above, or left; 1) or second (0), or empty: for the
//                       preference of a side
//   answer              one trial: yes/no, 1/0, true/false, right/wrong, seen/unseen; of two things a/b,
//                       first/second, or an item's name; "cannot tell", tie, none
//   expected            the right answer, in the same words: the answer counts as yes where it is that one
//   yes, no, ties, total  counts in place of `answer`
//   rt                  response time in milliseconds
//   frames_dropped      how many of the clip's frames were not shown
//   hidden              how often the page was out of sight meanwhile
//   study               the hash of the plan that was answered
//   pixels_per_degree, pixels_per_degree_se
//                       the participant's calibration, in CSS pixels, and its standard error; empty, or what
//                       core/screen_calibration.h does not take: not calibrated
//   css_px_per_clip_px  how large a pixel of the clip was shown, in CSS pixels; without the column 1
//   catch               kind of catch trial; empty, 0, no, none: an ordinary trial
//   observers           who answered: "simulated" of simulated observers, which all that is made of them says;
//                       else people
enum class Role {
  participant,
  trial,
  task,
  condition,
  clip,
  stimulus,
  level,
  signal,
  item_a,
  item_b,
  shown_first,
  answer,
  expected,
  yes,
  no,
  ties,
  total,
  rt,
  frames_dropped,
  hidden,
  study,
  catch_kind,
  pixels_per_degree,
  pixels_per_degree_se,
  css_px_per_clip_px,
  observers,
  yes_first,
};

struct ColumnMap {
  std::vector<std::pair<Role, std::string>> columns;
};
// "participant=observer,level=distance_m,condition=character,condition=clip". Throws Error naming `where`.
ColumnMap parse_column_map(const std::string& text, const std::string& where);
// Every column whose name is that of a role.
ColumnMap columns_by_name(const Table& table);

struct Answer {
  size_t source = 0;  // of Answers::sources
  size_t line = 0;
  // Indices into the names below; nothing where the table has no such column.
  std::optional<uint32_t> participant, task, condition, clip, item_a, item_b, stimulus, study;
  std::optional<bool> shown_first_is_a;
  std::optional<bool> signal;
  std::optional<bool> yes_first;
  std::optional<double> level;  // finite
  std::optional<double> rt_ms;
  uint64_t frames_dropped = 0;
  uint64_t hidden = 0;
  // Only where both are there and can be those of a screen.
  std::optional<double> pixels_per_degree, pixels_per_degree_se;
  double css_px_per_clip_px = 1;
  bool simulated = false;  // by a simulated observer
  std::string trial;
  std::string catch_kind;  // empty: an ordinary trial
  uint64_t yes = 0;
  uint64_t ties = 0;
  uint64_t no = 0;

  uint64_t count() const { return yes + ties + no; }
};

struct Answers {
  std::vector<std::string> sources;
  std::vector<std::string> participants, tasks, conditions, clips, items, stimuli, studies;
  std::vector<std::string> condition_columns;  // what the names of conditions are joined of
  std::vector<Answer> rows;
};

// Adds a table's rows. Throws Error at "file:line": a column that is not there, a field that is missing or is not what
// its role takes, a trial of a participant twice, an item compared with itself, counts that do not add up.
void add_answers(Answers& to, const Table& table, const ColumnMap& map);

// A participant and how they did on catch trials.
struct Exclusion {
  std::string participant;
  uint64_t right = 0;
  uint64_t of = 0;
};
// Takes out whom the rule excludes (a share of right answers to catch trials below `least`) with all their rows, and
// every catch trial of the others; says whom. Who had no catch trials stays.
std::vector<Exclusion> exclude_by_catch(Answers& answers, double least);

// Which single trials count for nothing.
struct TrialRules {
  double shortest_rt_ms = 0;                    // answers that came sooner
  std::optional<uint64_t> most_frames_dropped;  // more frames than this were not shown
  bool hidden = false;                          // the page was out of sight
};
// How many rows each rule took out; a row counts for the first that does.
struct LeftOut {
  size_t fast = 0, dropped = 0, hidden = 0;
  size_t hidden_catch = 0;  // catch trials out of sight: they stay, and count as wrong
};
// Who puts the page out of sight in every catch trial has not passed them: those are not left out, and turn wrong.
LeftOut leave_out(Answers& answers, const TrialRules& rules);

}  // namespace crowdbench::studies
