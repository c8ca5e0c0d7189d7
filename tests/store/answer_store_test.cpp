#include "store/answer_store.h"

#include <gtest/gtest.h>
#include <sqlite3.h>

#include "core/error.h"
#include "store/database.h"
#include "store/store.h"
#include "tests/support/scratch_folder.h"

namespace crowdbench {
namespace {

const std::vector<std::string> kLists = {"b", "a", "c"};

class AnswerStoreTest : public testing::Test {
 protected:
  AnswerStore::Start start(const std::string& participant, const std::optional<std::string>& wanted = {}) {
    return store_.start("study", participant, "token of " + participant, kLists, wanted, "2026-01-02T03:04:05Z");
  }
  static StudyAnswerRow answer(int64_t participant, const std::string& item, const std::string& data) {
    StudyAnswerRow row;
    row.participant = participant;
    row.item = item;
    row.kind = "main";
    row.data = data;
    return row;
  }

  support::ScratchFolder folder_;
  std::filesystem::path file_ = folder_ / "answers.sqlite";
  AnswerStore store_{file_};
};

TEST_F(AnswerStoreTest, GivesTheListThatFewestHaveTheFirstOfThese) {
  EXPECT_EQ(start("p1").row.list, "b");
  EXPECT_EQ(start("p2").row.list, "a");
  EXPECT_EQ(start("p3").row.list, "c");
  EXPECT_EQ(start("p4", "c").row.list, "c");
  EXPECT_EQ(start("p5").row.list, "b");
  EXPECT_EQ(start("p6").row.list, "a");
  // Who withdraws is replaced.
  store_.withdraw(start("p2").row.id, "2026-01-03");
  EXPECT_EQ(start("p7").row.list, "a");
  // Who comes again keeps theirs, under a new token.
  const AnswerStore::Start again = store_.start("study", "p1", "another token", kLists, "c", "2026-01-04T00:00:00Z");
  EXPECT_TRUE(again.resumed);
  EXPECT_EQ(again.row.list, "b");
  EXPECT_EQ(again.row.started, "2026-01-02T03:04:05Z");
  EXPECT_FALSE(store_.by_token("study", "token of p1"));
  EXPECT_EQ(store_.by_token("study", "another token").value().id, again.row.id);
  EXPECT_FALSE(store_.by_token("another study", "another token"));
  EXPECT_FALSE(store_.by_token("study", "")) << "as who withdrew has";
  // Another study in the same file counts for itself.
  EXPECT_EQ(store_.start("another study", "p1", "t", kLists, {}, "").row.list, "b");
}

TEST_F(AnswerStoreTest, KeepsOneAnswerAnItemUntilTheEnd) {
  using Kept = AnswerStore::Kept;
  const int64_t id = start("p1").row.id;
  EXPECT_EQ(store_.add(answer(id, "t1", "{1}")), Kept::added);
  EXPECT_EQ(store_.add(answer(id, "t1", "{1}")), Kept::same);
  EXPECT_EQ(store_.add(answer(id, "t1", "{2}")), Kept::different);
  EXPECT_EQ(store_.add(answer(id, "t2", "{1}")), Kept::added);
  EXPECT_EQ(store_.add(answer(id + 1, "t1", "{1}")), Kept::closed) << "there is nobody of that number";
  store_.calibrate(id, 36.5, 3.25);
  store_.begin(id, "t1", 1);
  store_.begin(id, "t2", 3);
  store_.begin(id, "t2", 2);
  store_.finish(id, "2026-01-02T03:34:05Z");
  EXPECT_EQ(store_.add(answer(id, "t1", "{1}")), Kept::same);
  EXPECT_EQ(store_.add(answer(id, "t3", "{1}")), Kept::closed);
  store_.begin(id, "t3", 1);
  const std::vector<StudyAnswerRow> rows = store_.answers(id);
  ASSERT_EQ(rows.size(), 2U);
  EXPECT_EQ(rows[0].data, "{1}");
  EXPECT_EQ(rows[1].item, "t2");
  const StudyParticipantRow who = start("p1").row;
  EXPECT_EQ(who.state, "finished");
  EXPECT_EQ(who.ended, "2026-01-02T03:34:05Z");
  EXPECT_EQ(who.pixels_per_degree, 36.5);
  EXPECT_EQ(who.pixels_per_degree_se, 3.25);
  EXPECT_EQ(who.begun, R"({"t1":1,"t2":3})") << "the largest count of each, until the end";
}

TEST_F(AnswerStoreTest, WithdrawalLeavesTheListAndTheDay) {
  const int64_t id = start("p1").row.id;
  store_.add(answer(id, "t1", "{1}"));
  store_.calibrate(id, 36.5, 3.25);
  store_.begin(id, "t1", 1);
  store_.withdraw(id, "2026-01-03");
  EXPECT_TRUE(store_.answers(id).empty());
  const StoreContents all = read_store(file_);
  ASSERT_EQ(all.participants.size(), 1U);
  StudyParticipantRow left;
  left.id = id;
  left.study = "study";
  left.list = "b";
  left.state = "withdrawn";
  left.started = "2026-01-03";
  EXPECT_TRUE(all.participants[0] == left);
  EXPECT_NE(start("p1").row.id, id) << "nobody remembers them";
}

TEST_F(AnswerStoreTest, WhatWasWithdrawnLeavesTheLogOnceNobodyReads) {
  const int64_t id = start("p1").row.id;
  store_.add(answer(id, "t1", "{1}"));
  const std::string where = file_.string();
  const store::Database reader = store::open(where, where, SQLITE_OPEN_READWRITE);
  store::execute(reader.get(), where, "BEGIN");
  store::Statement(reader.get(), where, "SELECT count(*) FROM study_answer").step();
  store_.withdraw(id, "2026-01-03");
  EXPECT_GT(std::filesystem::file_size(where + "-wal"), 0U);
  store::execute(reader.get(), where, "COMMIT");
  start("p2");
  EXPECT_EQ(std::filesystem::file_size(where + "-wal"), 0U);
}

TEST_F(AnswerStoreTest, ReadsAgainAfterAReadThatFailed) {
  const int64_t id = start("p1").row.id;
  store_.add(answer(id, "t1", "{1}"));
  ASSERT_EQ(store_.answers(id).size(), 1U);
  const std::string where = file_.string();
  const store::Database other = store::open(where, where, SQLITE_OPEN_READWRITE);
  store::execute(other.get(), where, "ALTER TABLE study_answer RENAME TO elsewhere");
  EXPECT_THROW(store_.answers(id), Error);
  store::execute(other.get(), where, "ALTER TABLE elsewhere RENAME TO study_answer");
  EXPECT_EQ(store_.answers(id).size(), 1U);
}

}  // namespace
}  // namespace crowdbench
