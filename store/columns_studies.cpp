// What the answers of studies are stored as.
#include "store/column_fields.h"

namespace crowdbench {

using namespace column_fields;

// clang-format off
template <>
const Table<StudyParticipantRow>& table<StudyParticipantRow>() {
  using R = StudyParticipantRow;
  static const Table<R> made = make_table<R>(
      {.name = "study_participant",
       .rows = "participants",
       .meaning = "Somebody who takes part in a study (`study serve`). Who withdraws leaves a row that says so and "
                  "nothing else.",
       .index = {"study", "participant"},
       .since = 5},
      &StoreContents::participants,
      id_field<&R::id>(),
      field<&R::study>({.name = "study", .meaning = "hash of the plan that the page was exported from"}),
      field<&R::participant>({.name = "participant",
                              .meaning = "SHA-256 that the page made of the study and the participant's id, which is "
                                         "never sent; empty after withdrawal",
                              .check = "(participant = '') = (state = 'withdrawn')"}),
      field<&R::list>({.name = "list", .meaning = "which of the study's orders of trials"}),
      field<&R::state>({.name = "state",
                        .meaning = "started; finished: all was answered; withdrawn: what was sent is deleted",
                        .values = {"started", "finished", "withdrawn"}}),
      field<&R::token>({.name = "token",
                        .meaning = "SHA-256 of the secret that the participant's page sends along; empty: none is "
                                   "taken"}),
      field<&R::started>({.name = "started",
                          .meaning = "UTC, ISO 8601, when the server gave the list; only the day after withdrawal"}),
      field<&R::ended>({.name = "ended", .meaning = "UTC, when all was answered"}),
      field<&R::pixels_per_degree>({.name = "pixels_per_degree",
                                    .unit = "px",
                                    .meaning = "of CSS in one degree of the visual field, by the page's calibration"}),
      field<&R::pixels_per_degree_se>({.name = "pixels_per_degree_se",
                                       .unit = "px",
                                       .meaning = "its standard error, spread between eyes included"}),
      field<&R::begun>({.name = "begun",
                        .meaning = "JSON, an object: how often each trial was begun, as the page said when it began; "
                                   "answers carry it as restarts",
                        .since = 8}));
  return made;
}

template <>
const Table<StudyAnswerRow>& table<StudyAnswerRow>() {
  using R = StudyAnswerRow;
  static const Table<R> made = make_table<R>(
      {.name = "study_answer",
       .rows = "answers",
       .meaning = "What a participant answered to one trial, or to a page before or after the trials. Written, and "
                  "only then acknowledged, one transaction each.",
       .index = {"participant", "item"},
       .since = 5},
      &StoreContents::answers,
      id_field<&R::id>(),
      field<&R::participant>({.name = "participant", .meaning = "who", .references = "study_participant"}),
      field<&R::item>({.name = "item", .meaning = "the trial's id in the list, or the page's name"}),
      field<&R::kind>({.name = "kind",
                       .meaning = "of the trial; page: consent, calibration and the like",
                       .values = {"training", "main", "catch", "page"}}),
      field<&R::stimulus>({.name = "stimulus", .meaning = "id of what was shown; nothing but the study's sides.json "
                                                          "says what it is"}),
      field<&R::block>({.name = "block", .meaning = "of the list, from 1; 0: training"}),
      field<&R::answer>({.name = "answer", .meaning = "value of the answer that was chosen"}),
      field<&R::rt>({.name = "rt_ms",
                     .unit = "ms",
                     .meaning = "from the end of the clip's first showing to the answer, hidden time included"}),
      field<&R::replays>({.name = "replays", .meaning = "how often the clip was shown again"}),
      field<&R::frames_dropped>({.name = "frames_dropped",
                                 .unit = "frames",
                                 .meaning = "of all showings, as the browser counts them; absent where it does not"}),
      field<&R::hidden>({.name = "hidden", .meaning = "how often the page was hidden during the trial"}),
      field<&R::restarts>({.name = "restarts", .meaning = "how often the trial was begun before, and cut short"}),
      field<&R::received>({.name = "received", .meaning = "UTC, ISO 8601, by the server"}),
      field<&R::data>({.name = "data", .meaning = "the page's whole record, JSON", .bulky = true}));
  return made;
}
// clang-format on

}  // namespace crowdbench
