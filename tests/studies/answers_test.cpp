// Tables as they come from outside, and answers made of them: what is taken, and every refusal with its line.
#include "studies/analysis/answers.h"

#include <gtest/gtest.h>

#include "core/error.h"
#include "tests/studies/answer_tables.h"

namespace crowdbench::studies {
namespace {

using test::answers_of;

std::string refusal(const std::string& text, const std::string& columns = "") {
  try {
    const Table table = parse_table(text, "t.csv");
    Answers answers;
    add_answers(answers, table, columns.empty() ? columns_by_name(table) : parse_column_map(columns, "--columns"));
    return "taken";
  } catch (const Error& error) {
    const std::string what = error.what();
    EXPECT_EQ(what.find('\n'), std::string::npos) << "one line";
    return what;
  }
}

TEST(Tables, TakeWhatSpreadsheetsWrite) {
  const Table t =
      parse_table("\xef\xbb\xbfname,\"a \"\"b\"\"\", c \r\n\"x, y\",\"two\nlines\", 3 \r\n\r\nü,,\"\"\r\n", "t.csv");
  EXPECT_EQ(t.columns, (std::vector<std::string>{"name", "a \"b\"", "c"}));
  ASSERT_EQ(t.rows.size(), 2U);
  EXPECT_EQ(t.rows[0].fields, (std::vector<std::string>{"x, y", "two\nlines", "3"}));
  EXPECT_EQ(t.rows[0].line, 2U);
  EXPECT_EQ(t.rows[1].fields, (std::vector<std::string>{"ü", "", ""}));
  EXPECT_EQ(t.rows[1].line, 5U) << "a quoted line break and an empty line count";
  EXPECT_EQ(parse_table("a\tb\n1\t2", "t.tsv").rows[0].fields, (std::vector<std::string>{"1", "2"}));
  EXPECT_EQ(parse_table("a,b\n1,", "t.csv").rows[0].fields, (std::vector<std::string>{"1", ""}));
}

TEST(Tables, KeepWhatIsAskedFor) {
  Table t = parse_table("kind,answer\npage,\ntrial,yes\npage,\ntrial,no\n", "t.csv");
  keep_rows(t, "kind", "trial");
  ASSERT_EQ(t.rows.size(), 2U);
  EXPECT_EQ(t.rows[1].line, 5U);
  EXPECT_THROW(keep_rows(t, "knd", "trial"), Error);
  EXPECT_THROW(keep_rows(t, "kind", "page"), Error);
}

TEST(Tables, RefuseWithTheLine) {
  const std::pair<std::string, std::string> wrong[] = {
      {"", "t.csv:1: the file is empty"},
      {"\n\n", "t.csv:1: the file is empty"},
      {"answer\n", "t.csv:1: there are no rows"},
      {"a,a\n1,2\n", "t.csv:1: two columns are named 'a'"},
      {"a;answer\n1,5;yes\n", "t.csv:1: separates columns by semicolons"},
      {"a,,c\n1,2,3\n", "t.csv:1: column 2 has no name"},
      {"answer,x\n1,2\n1\n", "t.csv:3: has 1 fields where there are 2 columns"},
      {"answer,x\n1,2,3\n", "t.csv:2: has 3 fields where there are 2 columns"},
      {"answer,x\n1,\"2\n\n", "t.csv:2: opens a quote that is not closed"},
      {"answer,x\n1,2\"3\n", "t.csv:2: has a quote within a bare field"},
      {"answer,x\n1,\"2\"3\n", "t.csv:2: goes on after a closing quote"},
      {std::string("answer\n1\n\0\n", 11), "t.csv:3: holds a NUL byte"},
      {"answer\n1\n\xff\n", "t.csv:3: is not UTF-8"},
      {"answer\n\xed\xa0\x80\n", "t.csv:2: is not UTF-8"},
      {"answer\n\xc0\xaf\n", "t.csv:2: is not UTF-8"},
      {"answer\n\xe2\x82", "t.csv:2: is not UTF-8"},
      {std::string(2100, ',') + "\n", "t.csv:1: has more than 1000 fields"},
  };
  for (const auto& [text, says] : wrong) EXPECT_EQ(refusal(text).rfind(says, 0), 0U) << refusal(text);
}

TEST(AnswersOfTables, TakeWordsCountsAndChoices) {
  const Answers words =
      answers_of("who,seen,km\nA,Yes,1\nA,no,2\nB,cannot tell,-3e0\n", "participant=who,answer=seen,level=km");
  ASSERT_EQ(words.rows.size(), 3U);
  EXPECT_EQ(words.participants, (std::vector<std::string>{"A", "B"}));
  EXPECT_EQ(words.rows[0].yes, 1U);
  EXPECT_EQ(words.rows[1].no, 1U);
  EXPECT_EQ(words.rows[2].ties, 1U);
  EXPECT_EQ(*words.rows[2].level, -3);
  const Answers counts = answers_of("level,yes,ties,total\n1,3,2,10\n");
  EXPECT_EQ(counts.rows[0].no, 5U);
  const Answers choices =
      answers_of("item_a,item_b,shown_first,answer\nmesh,flat,flat,flat\nmesh,flat,mesh,a\n1,2,1,2\n");
  EXPECT_EQ(choices.items, (std::vector<std::string>{"mesh", "flat", "1", "2"}));
  EXPECT_EQ(choices.rows[0].no, 1U);
  EXPECT_EQ(choices.rows[0].shown_first_is_a, false);
  EXPECT_EQ(choices.rows[1].yes, 1U);
  EXPECT_EQ(choices.rows[2].no, 1U) << "an item's name goes before the words for first and second";
  const Answers expected = answers_of("answer,expected\nupper,upper\nlower,upper\ncannot tell,upper\n");
  EXPECT_EQ(expected.rows[0].yes, 1U);
  EXPECT_EQ(expected.rows[1].no, 1U);
  EXPECT_EQ(expected.rows[2].ties, 1U);
  const Answers joined =
      answers_of("rep,m,yes,no\nflat,10,1,2\nflat,15,1,2\n", "condition=rep,condition=m,yes=yes,no=no");
  EXPECT_EQ(joined.conditions, (std::vector<std::string>{"flat, 10", "flat, 15"}));
}

TEST(AnswersOfTables, RefuseWithTheLine) {
  const std::array<std::string, 3> wrong[] = {
      {"x\n1\n", "", "t.csv:1: has no column that is the answer"},
      {"answer,yes,no\n1,1,1\n", "", "t.csv:1: has both an `answer` and counts"},
      {"answer\nmaybe\n", "", "t.csv:2: 'maybe' in column 'answer' is not what `answer` takes"},
      {"answer\n\"\"\n", "", "t.csv:2: column 'answer' (answer) is empty"},
      {"answer,level\n1,abc\n", "",
       "t.csv:2: 'abc' in column 'level' is not what `level` takes; it is to be a finite number"},
      {"answer,level\n1,nan\n", "", "t.csv:2: 'nan' in column 'level'"},
      {"answer,level\n1,1e999\n", "", "t.csv:2: '1e999' in column 'level'"},
      {"answer,level\n1,1 km\n", "", "t.csv:2: '1 km' in column 'level'"},
      {"yes,total\n3,2\n", "", "t.csv:2: 3 answers of 2 in all"},
      {"yes,no,total\n3,2,6\n", "", "t.csv:2: 5 answers of 6 in all"},
      {"yes,no\n-1,2\n", "", "t.csv:2: '-1' in column 'yes'"},
      {"yes,no\n1.5,2\n", "", "t.csv:2: '1.5' in column 'yes'"},
      {"yes,no\n1e300,2\n", "", "t.csv:2: '1e300' in column 'yes'"},
      {"participant,trial,answer\nA,1,1\nB,1,1\nA,1,0\n", "", "t.csv:4: trial '1' was answered at t.csv:2 already"},
      {"participant,answer\n,1\n", "", "t.csv:2: column 'participant' (participant) is empty"},
      {"item_a,item_b,answer\nx,x,x\n", "", "t.csv:2: 'x' is compared with itself"},
      {"item_a,item_b,answer\nx,y,z\n", "", "t.csv:2: 'z' in column 'answer'"},
      {"item_a,item_b,shown_first,answer\nx,y,z,x\n", "", "t.csv:2: 'z' in column 'shown_first'"},
      {"item_a,answer\nx,1\n", "", "t.csv:1: has one of `item_a` and `item_b`"},
      {"answer,rt\n1,-5\n", "", "t.csv:2: '-5' in column 'rt'"},
      {"answer,signal\n1,perhaps\n", "", "t.csv:2: 'perhaps' in column 'signal'"},
      {"a\n1\n", "answer=b", "t.csv:1: there is no column 'b'; there are a"},
      {"a\n1\n", "answer", "--columns: 'answer' is not ROLE=COLUMN"},
      {"a\n1\n", "anser=a", "--columns: there is no role 'anser'"},
      {"a,b\n1,1\n", "answer=a,answer=b", "t.csv:1: two columns are to be `answer`"},
  };
  for (const auto& [text, columns, says] : wrong)
    EXPECT_EQ(refusal(text, columns).rfind(says, 0), 0U) << refusal(text, columns) << "\nnot " << says;
}

TEST(AnswersOfTables, CatchTrialsExcludeOpenly) {
  Answers a = answers_of(
      "participant,catch,answer,expected\n"
      "A,broken,upper,upper\nA,broken,lower,lower\nA,,upper,upper\n"
      "B,broken,upper,lower\nB,broken,lower,lower\nB,no,upper,upper\n"
      "C,,lower,upper\n");
  const std::vector<Exclusion> out = exclude_by_catch(a, 0.75);
  ASSERT_EQ(out.size(), 1U);
  EXPECT_EQ(out[0].participant, "B");
  EXPECT_EQ(out[0].right, 1U);
  EXPECT_EQ(out[0].of, 2U);
  ASSERT_EQ(a.rows.size(), 2U) << "of A and C, and no catch trial";
  EXPECT_EQ(a.rows[1].no, 1U);
  // Between two equal things the right answer may be that one cannot tell.
  Answers equal = answers_of(
      "participant,item_a,item_b,catch,answer,expected\nA,x,x,identical,cannot tell,tie\nA,x,x,identical,a,tie\n");
  EXPECT_EQ(equal.rows[0].yes, 1U);
  EXPECT_EQ(equal.rows[1].no, 1U);
}

}  // namespace
}  // namespace crowdbench::studies
