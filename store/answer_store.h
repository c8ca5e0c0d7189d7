// Answers of a study as they come in: each is on the disk before it is acknowledged. Behind `crowdbench study serve`.
//
// A file of the result store (store/store.h), opened for this alone: SQLite's write-ahead log with synchronous=FULL,
// one transaction a change. What a call has returned from survives SIGKILL and, as far as the disk keeps what it says
// that it kept, a power failure. All functions may be called from several threads; they take turns.
#pragma once
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "store/rows.h"

namespace crowdbench {

class AnswerStore {
 public:
  // Made where it does not exist; an older schema is brought to the present one. Throws Error as StoreWriter does.
  explicit AnswerStore(const std::filesystem::path& file);
  ~AnswerStore();
  AnswerStore(const AnswerStore&) = delete;
  AnswerStore& operator=(const AnswerStore&) = delete;

  struct Start {
    StudyParticipantRow row;
    bool resumed = false;  // the participant had started before
  };
  // A new participant gets `wanted`, or else of `lists` (not empty) the one that fewest others have who did not
  // withdraw, the first of these; one who has started before keeps theirs. `token`, a hash, replaces the one before.
  Start start(const std::string& study, const std::string& participant, const std::string& token,
              const std::vector<std::string>& lists, const std::optional<std::string>& wanted, const std::string& now);

  // The participant of a study whose token that is.
  std::optional<StudyParticipantRow> by_token(const std::string& study, const std::string& token);
  // In the order in which they came.
  std::vector<StudyAnswerRow> answers(int64_t participant);

  enum class Kept {
    added,
    same,       // it was there already, byte for byte: a post whose acknowledgement got lost
    different,  // another answer to that item was there, and stays
    closed      // the participant has finished or withdrawn
  };
  Kept add(const StudyAnswerRow& row);
  // That a trial (its id in the list: letters and digits) is shown for the count-th time; a smaller count than before
  // changes nothing, nor does any once the participant has finished or withdrawn.
  void begin(int64_t participant, const std::string& trial, uint32_t count);
  void calibrate(int64_t participant, double pixels_per_degree, double standard_error);
  void finish(int64_t participant, const std::string& now);
  // Deletes all that the participant sent, overwrites it in the file and empties the log. What stays is a row that says
  // that somebody withdrew, with the list and the day (`day`: "2026-01-31").
  void withdraw(int64_t participant, const std::string& day);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace crowdbench
