#include "store/columns.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>
#include <string>

#include "store/store.h"
#include "tests/support/field_count.h"

namespace crowdbench {
namespace {

using support::field_count;

struct Three {
  int a;
  std::optional<std::string> b;
  PointKey c;
};

TEST(FieldCount, CountsMembersAndNotMembersOfMembers) {
  EXPECT_EQ(field_count<Three>(), 3U);
  EXPECT_EQ(field_count<PointKey>(), 6U);
  EXPECT_EQ(field_count<TimeSummary>(), 6U);
}

// That each column is its own member is what the tests of the store show: every field there has a value of its own.
TEST(Columns, EveryFieldOfARowHasOne) {
  const auto columns = []<typename Row>(const Table<Row>& table) { return table.fields.size(); };
  constexpr size_t held = 1;  // samples, scores, bins: rows of their own table
  EXPECT_EQ(columns(table<RunRow>()), field_count<RunRow>());
  EXPECT_EQ(columns(table<MeasurementRow>()),
            field_count<MeasurementRow>() - held + field_count<PointKey>() - 1 + 4 * (field_count<TimeSummary>() - 1));
  EXPECT_EQ(columns(table<SampleRow>()), field_count<SampleRow>());
  EXPECT_EQ(columns(table<RatioRow>()), field_count<RatioRow>() + field_count<PointKey>() - 1);
  EXPECT_EQ(columns(table<ControlRow>()), field_count<ControlRow>() + field_count<PointKey>() - 1);
  EXPECT_EQ(columns(table<ComparisonRow>()), field_count<ComparisonRow>() - held);
  EXPECT_EQ(columns(table<ScoreRow>()), field_count<ScoreRow>());
  EXPECT_EQ(columns(table<SweepRow>()), field_count<SweepRow>());
  EXPECT_EQ(columns(table<SweepPointRow>()), field_count<SweepPointRow>());
  EXPECT_EQ(columns(table<PictureRow>()), field_count<PictureRow>());
  EXPECT_EQ(columns(table<CurveRow>()), field_count<CurveRow>() - held);
  EXPECT_EQ(columns(table<CurveBinRow>()), field_count<CurveBinRow>());
  EXPECT_EQ(columns(table<ThresholdRow>()), field_count<ThresholdRow>());
  EXPECT_EQ(columns(table<CauseRangeRow>()), field_count<CauseRangeRow>() - held);
  EXPECT_EQ(columns(table<CauseShareRow>()), field_count<CauseShareRow>());
  EXPECT_EQ(columns(table<PopRow>()), field_count<PopRow>() - held);
  EXPECT_EQ(columns(table<PopScoreRow>()), field_count<PopScoreRow>());
  EXPECT_EQ(columns(table<TuningRow>()), field_count<TuningRow>() - held);
  EXPECT_EQ(columns(table<TunedSwitchRow>()), field_count<TunedSwitchRow>());
  EXPECT_EQ(columns(table<StabilityCaseRow>()), field_count<StabilityCaseRow>());
  EXPECT_EQ(columns(table<StudyParticipantRow>()), field_count<StudyParticipantRow>());
  EXPECT_EQ(columns(table<StudyAnswerRow>()), field_count<StudyAnswerRow>());
}

// Of three booleans two are equal in any row: such tables are in StoreTest.BooleansAreToldApart. The two of `run`
// differ in StoreTest.EveryFieldIsInTheColumnOfItsName.
TEST(Columns, NoOtherTableHasSeveralBooleans) {
  const std::set<std::string> told_apart = {"measurement", "run", "stability_case", "tuning"};
  for_each_table([&](const auto& table) {
    const auto& columns = table.description.columns;
    const auto booleans = std::count_if(columns.begin(), columns.end(),
                                        [](const Column& column) { return column.type == ColumnType::boolean; });
    EXPECT_TRUE(booleans < 2 || told_apart.contains(table.description.name)) << table.description.name;
  });
}

TEST(Columns, EveryVectorOfTheContentsIsATable) {
  size_t tables = 0;
  for_each_table([&](const auto& table) { tables += table.rows != nullptr ? 1 : 0; });
  EXPECT_EQ(tables, field_count<StoreContents>() - 1) << "`sources` is of no file";
}

TEST(Columns, AreNamedOnceExplainedAndCarryTheirUnits) {
  const std::vector<std::pair<std::string, std::string>> endings = {
      {"_px", "px"}, {"_bytes", "bytes"}, {"_deg", "degrees"}, {"_mhz", "MHz"},     {"_s", "s"},
      {"_ns", "ns"}, {"_fps", "1/s"},     {"_seconds", "s"},   {"agents", "agents"}};
  for_each_table([&](const auto& table) {
    const TableDescription& description = table.description;
    SCOPED_TRACE(description.name);
    EXPECT_FALSE(description.meaning.empty());
    EXPECT_FALSE(description.rows.empty());
    std::set<std::string> names;
    for (const Column& column : description.columns) {
      SCOPED_TRACE(column.name);
      EXPECT_TRUE(names.insert(column.name).second);
      EXPECT_FALSE(column.meaning.empty());
      for (const auto& [ending, unit] : endings) {
        EXPECT_TRUE(!column.name.ends_with(ending) || column.unit == unit) << column.unit;
      }
    }
  });
}

// A file written before has no value for a new column, and none may be invented.
TEST(Columns, ThoseOfLaterSchemasMayBeAbsent) {
  for_each_table([](const auto& table) {
    EXPECT_LE(table.description.since, kStoreSchemaVersion);
    for (const Column& column : table.description.columns) {
      SCOPED_TRACE(column.name);
      EXPECT_LE(std::max(column.since, column.changed), kStoreSchemaVersion);
      EXPECT_TRUE(column.since <= table.description.since || column.optional);
      EXPECT_EQ(column.before.empty(), column.changed == 1);
    }
  });
}

}  // namespace
}  // namespace crowdbench
