#include "store/answer_store.h"

#include <fmt/format.h>
#include <sqlite3.h>

#include <algorithm>
#include <map>
#include <mutex>

#include "store/database.h"
#include "store/row_statements.h"
#include "store/schema.h"
#include "store/store.h"

namespace crowdbench {

using namespace store;

struct AnswerStore::State {
  std::string where;
  std::mutex turn;
  Database database;
  std::map<std::string, Statement> statements;
  bool truncate_due = false;  // what was withdrawn may still stand in the write-ahead log

  Statement& statement(const std::string& sql) {
    const auto found = statements.find(sql);
    if (found != statements.end()) return found->second;
    return statements.emplace(sql, Statement(database.get(), where, sql)).first->second;
  }
  // One transaction; `body` runs alone.
  template <typename Body>
  auto transaction(const Body& body) {
    const std::scoped_lock lock(turn);
    execute(database.get(), where, "BEGIN IMMEDIATE");
    try {
      auto result = body();
      execute(database.get(), where, "COMMIT");
      // Says 1 where a reader stood in the way: then after the next change again.
      if (truncate_due) truncate_due = pragma(database.get(), where, "wal_checkpoint(TRUNCATE)") != 0;
      return result;
    } catch (...) {
      statements.clear();  // a statement left in mid-step would hold the transaction open
      sqlite3_exec(database.get(), "ROLLBACK", nullptr, nullptr, nullptr);
      throw;
    }
  }
  // All rows of the statement, which can be bound anew after, even after an Error.
  template <typename Row>
  static std::vector<Row> rows(Statement& select) {
    std::vector<Row> all;
    try {
      while (select.step()) all.push_back(read_row<Row>(select));
    } catch (...) {
      select.reset();
      throw;
    }
    return all;
  }
  template <typename Row>
  int64_t insert(const Row& row) {
    Statement& to = statement(insert_sql(table<Row>().description));
    bind_row(to, row);
    to.step();
    return sqlite3_last_insert_rowid(database.get());
  }
  template <typename Row>
  static std::string select(const char* condition) {
    const TableDescription& description = table<Row>().description;
    return fmt::format("SELECT {} FROM {} WHERE {} ORDER BY id", selected(description, kStoreSchemaVersion),
                       description.name, condition);
  }
  std::vector<StudyParticipantRow> participants(const std::string& study, const char* column,
                                                const std::string& value) {
    Statement& of = statement(select<StudyParticipantRow>(fmt::format("study = ? AND {} = ?", column).c_str()));
    of.bind(study).bind(value);
    return rows<StudyParticipantRow>(of);
  }
  // Of `lists` the first of those that fewest have.
  std::string fewest(const std::string& study, const std::vector<std::string>& lists) {
    std::map<std::string, int64_t> started;
    Statement& count = statement(
        "SELECT count(*), list FROM study_participant WHERE study = ? AND state <> 'withdrawn' GROUP BY list");
    count.bind(study);
    while (count.step()) {
      const int64_t number = count.read_integer();
      started[std::get<std::string>(count.read(ColumnType::text))] = number;
    }
    return *std::min_element(lists.begin(), lists.end(),
                             [&](const std::string& a, const std::string& b) { return started[a] < started[b]; });
  }
};

AnswerStore::AnswerStore(const std::filesystem::path& file) : state_(new State) {
  { const StoreWriter made(file); }
  state_->where = file.string();
  state_->database = store::open(state_->where, state_->where, SQLITE_OPEN_READWRITE);
  execute(state_->database.get(), state_->where,
          "PRAGMA foreign_keys=ON; PRAGMA synchronous=FULL; PRAGMA secure_delete=ON");
}

AnswerStore::~AnswerStore() { state_->statements.clear(); }

AnswerStore::Start AnswerStore::start(const std::string& study, const std::string& participant,
                                      const std::string& token, const std::vector<std::string>& lists,
                                      const std::optional<std::string>& wanted, const std::string& now) {
  return state_->transaction([&] {
    Start out;
    const std::vector<StudyParticipantRow> before = state_->participants(study, "participant", participant);
    if (!before.empty()) {
      out = {before.front(), true};
      out.row.token = token;
      Statement& renew = state_->statement("UPDATE study_participant SET token = ? WHERE id = ?");
      renew.bind(token).bind(out.row.id);
      renew.step();
      return out;
    }
    out.row.study = study;
    out.row.participant = participant;
    out.row.list = wanted ? *wanted : state_->fewest(study, lists);
    out.row.state = "started";
    out.row.token = token;
    out.row.started = now;
    out.row.id = state_->insert(out.row);
    return out;
  });
}

std::optional<StudyParticipantRow> AnswerStore::by_token(const std::string& study, const std::string& token) {
  const std::scoped_lock lock(state_->turn);
  if (token.empty()) return std::nullopt;
  const std::vector<StudyParticipantRow> found = state_->participants(study, "token", token);
  return found.empty() ? std::nullopt : std::optional(found.front());
}

std::vector<StudyAnswerRow> AnswerStore::answers(int64_t participant) {
  const std::scoped_lock lock(state_->turn);
  Statement& of = state_->statement(State::select<StudyAnswerRow>("participant = ?"));
  of.bind(participant);
  return State::rows<StudyAnswerRow>(of);
}

AnswerStore::Kept AnswerStore::add(const StudyAnswerRow& row) {
  return state_->transaction([&] {
    Statement& same = state_->statement(State::select<StudyAnswerRow>("participant = ? AND item = ?"));
    same.bind(row.participant).bind(row.item);
    const std::vector<StudyAnswerRow> before = State::rows<StudyAnswerRow>(same);
    if (!before.empty()) return before.front().data == row.data ? Kept::same : Kept::different;
    Statement& who = state_->statement(State::select<StudyParticipantRow>("id = ? AND state = 'started'"));
    who.bind(row.participant);
    if (State::rows<StudyParticipantRow>(who).empty()) return Kept::closed;
    state_->insert(row);
    return Kept::added;
  });
}

void AnswerStore::begin(int64_t participant, const std::string& trial, uint32_t count) {
  state_->transaction([&] {
    Statement& set = state_->statement(
        "UPDATE study_participant SET begun = json_set(coalesce(begun, '{}'), ?2, "
        "max(?3, coalesce(json_extract(begun, ?2), 0))) WHERE id = ?1 AND state = 'started'");
    set.bind(participant).bind("$." + trial).bind(static_cast<int64_t>(count));
    return set.step();
  });
}

void AnswerStore::calibrate(int64_t participant, double pixels_per_degree, double standard_error) {
  state_->transaction([&] {
    Statement& set =
        state_->statement("UPDATE study_participant SET pixels_per_degree = ?, pixels_per_degree_se = ? WHERE id = ?");
    set.bind(ColumnType::real, pixels_per_degree).bind(ColumnType::real, standard_error).bind(participant);
    return set.step();
  });
}

void AnswerStore::finish(int64_t participant, const std::string& now) {
  state_->transaction([&] {
    Statement& set = state_->statement(
        "UPDATE study_participant SET state = 'finished', ended = ? WHERE id = ? AND state = 'started'");
    set.bind(now).bind(participant);
    return set.step();
  });
}

void AnswerStore::withdraw(int64_t participant, const std::string& day) {
  state_->transaction([&] {
    Statement& rows = state_->statement("DELETE FROM study_answer WHERE participant = ?");
    rows.bind(participant);
    rows.step();
    Statement& who = state_->statement(
        "UPDATE study_participant SET state = 'withdrawn', participant = '', token = '', started = ?, ended = NULL, "
        "pixels_per_degree = NULL, pixels_per_degree_se = NULL, begun = NULL WHERE id = ?");
    who.bind(day).bind(participant);
    state_->truncate_due = true;
    return who.step();
  });
}

}  // namespace crowdbench
