// The result store described once: its tables, and of every column the name, unit, type, meaning, member, and whether
// it may be absent. From this come the SQL schema, writing, reading, migration, every export and the documentation
// (`crowdbench schema --results`).
//
// A new column: a member in store/rows.h and a line in store/columns*.cpp with `.since` = kStoreSchemaVersion + 1,
// which then is the version. It must be one that may be absent: older files have no value for it, and none is invented.
// A new score needs no column: scores are rows of name and value.
//
// A new table (answers of a study, verdicts of a regression): in store/rows.h a struct that begins with `int64_t id`
// and a vector of them in StoreContents; in store/columns*.cpp its table<...>(), with `.since`; here its name in
// StoreTables and the declaration of its table<...>(); at the end of store/store.cpp the line that makes
// StoreWriter::write for it. Rows that belong to one row of another table (samples to a measurement) have an `owner`
// instead of an id, and a line in Owned below. Schema, reading, migration, JSON and documentation follow.
#pragma once
#include <cstdint>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "store/rows.h"

namespace crowdbench {

// What one row holds in one column; std::monostate: absent.
using Value = std::variant<std::monostate, bool, int64_t, uint64_t, double, std::string, std::vector<uint8_t>>;

enum class ColumnType : uint8_t {
  boolean,  // INTEGER 0 or 1
  integer,  // INTEGER; unsigned members too, which stay below 2^63
  seed,     // all 64 bits unsigned, as decimal TEXT: SQLite's integers are signed
  real,     // REAL, infinity included
  text,     // TEXT
  bytes     // BLOB; never exported
};

struct Column {
  std::string name;  // in SQL and in every export
  std::string unit;  // "ns", "px", "bytes", "frames"; empty where there is none
  std::string meaning;
  std::vector<std::string> values;  // the only texts allowed; empty: any
  std::string check;                // a further SQL condition on the row
  std::string references;           // the table whose id this is
  bool bulky = false;               // a text of many lines: left out of the view `results`, of CSV and of Markdown
  int since = 1;                    // the schema that brought the column
  // Where a later schema changed what it holds or whether it may be absent: that schema, and the SQL expression of the
  // older columns that gives its present value. One that is new may have both, of the same schema: what
  // older files said in another column.
  int changed = 1;
  std::string before;
  // Filled from the member; only `seed` is said.
  ColumnType type = ColumnType::text;
  bool optional = false;
  bool key = false;    // the row's own id, given by the store
  bool point = false;  // of the PointKey
};

struct TableDescription {
  std::string name;  // in SQL
  std::string rows;  // in JSON: the plural
  std::string meaning;
  std::string owner;   // the table to whose rows these belong: its id comes first, in a column of its name
  std::string within;  // with an owner: the column that tells its rows apart
  std::vector<std::string> index;
  int since = 1;
  std::vector<Column> columns;  // filled from the fields; the owner's not among them
};

// A column and the member that it is.
template <typename Row>
struct Field {
  Column column;
  Value (*get)(const Row& row);
  void (*set)(Row& row, Value value);  // std::monostate leaves the member of a new row as it is
};

template <typename Row>
struct Table {
  TableDescription description;
  std::vector<Field<Row>> fields;
  std::vector<Row> StoreContents::*rows = nullptr;  // nullptr with an owner
};

template <typename... Rows>
struct RowTypes {};
// Every table, in the order in which they are made and read: what a table references comes before it.
using StoreTables =
    RowTypes<RunRow, MeasurementRow, SampleRow, RatioRow, ControlRow, ComparisonRow, ScoreRow, SweepRow, SweepPointRow,
             PictureRow, CurveRow, CurveBinRow, ThresholdRow, CauseRangeRow, CauseShareRow, PopRow, PopScoreRow,
             TuningRow, TunedSwitchRow, StabilityCaseRow, StudyParticipantRow, StudyAnswerRow>;

// The table whose rows these are.
template <typename Row>
const Table<Row>& table();
template <>
const Table<RunRow>& table();
template <>
const Table<MeasurementRow>& table();
template <>
const Table<SampleRow>& table();
template <>
const Table<RatioRow>& table();
template <>
const Table<ControlRow>& table();
template <>
const Table<ComparisonRow>& table();
template <>
const Table<ScoreRow>& table();
template <>
const Table<SweepRow>& table();
template <>
const Table<SweepPointRow>& table();
template <>
const Table<PictureRow>& table();
template <>
const Table<CurveRow>& table();
template <>
const Table<CurveBinRow>& table();
template <>
const Table<ThresholdRow>& table();
template <>
const Table<CauseRangeRow>& table();
template <>
const Table<CauseShareRow>& table();
template <>
const Table<PopRow>& table();
template <>
const Table<PopScoreRow>& table();
template <>
const Table<TuningRow>& table();
template <>
const Table<TunedSwitchRow>& table();
template <>
const Table<StabilityCaseRow>& table();
template <>
const Table<StudyParticipantRow>& table();
template <>
const Table<StudyAnswerRow>& table();

// Rows that lie in a row of another table.
template <typename Row>
struct Owned {};
template <>
struct Owned<MeasurementRow> {
  static constexpr auto rows = &MeasurementRow::samples;
};
template <>
struct Owned<ComparisonRow> {
  static constexpr auto rows = &ComparisonRow::scores;
};
template <>
struct Owned<CurveRow> {
  static constexpr auto rows = &CurveRow::bins;
};
template <>
struct Owned<CauseRangeRow> {
  static constexpr auto rows = &CauseRangeRow::shares;
};
template <>
struct Owned<PopRow> {
  static constexpr auto rows = &PopRow::scores;
};
template <>
struct Owned<TuningRow> {
  static constexpr auto rows = &TuningRow::switches;
};
template <typename Row>
concept OwnsRows = requires {
  Owned<Row>::rows;
};

template <typename Visit, typename... Rows>
void for_each_table(const Visit& visit, RowTypes<Rows...>) {
  (visit(table<Rows>()), ...);
}
// Calls visit(table) for every table, in order.
template <typename Visit>
void for_each_table(const Visit& visit) {
  for_each_table(visit, StoreTables());
}

const char* type_name(ColumnType type);               // "integer", "real", ... as documented
bool has_bytes(const TableDescription& description);  // a table of pictures: read when asked for, never exported

}  // namespace crowdbench
