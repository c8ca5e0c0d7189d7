#include "store/store.h"

#include <fmt/format.h>
#include <sqlite3.h>

#include <cassert>
#include <map>
#include <system_error>
#include <type_traits>

#include "core/error.h"
#include "core/files.h"
#include "store/columns.h"
#include "store/database.h"
#include "store/row_statements.h"
#include "store/schema.h"

namespace crowdbench {
namespace {

using namespace store;

// A file without tables: what is left where its maker was stopped, or the disk was full, before the tables were there.
bool is_blank(sqlite3* database, const std::string& where) {
  Statement tables(database, where, "SELECT count(*) FROM sqlite_master");
  return pragma(database, where, "application_id") == 0 && pragma(database, where, "user_version") == 0 &&
         tables.step() && tables.read_integer() == 0;
}

// The schema of the file, this one or an older one. Throws Error where it is not ours or is newer.
int schema_of(sqlite3* database, const std::string& where) {
  const int64_t id = pragma(database, where, "application_id");
  if (is_blank(database, where))
    throw Error(where, "holds nothing: whoever made it was stopped at once", "measure into it again");
  if (id != kStoreApplicationId)
    throw Error(where, "a SQLite file of another program, not a result store",
                "name a file that `crowdbench bench --out` made");
  const int64_t version = pragma(database, where, "user_version");
  if (version > kStoreSchemaVersion)
    throw Error(
        where,
        fmt::format("written by a newer crowdbench (schema {}, this one knows {})", version, kStoreSchemaVersion),
        "update crowdbench");
  if (version < 1)
    throw Error(where, fmt::format("has schema {}, which no crowdbench writes", version),
                "the file is damaged; measure again into a new file");
  return static_cast<int>(version);
}

template <typename Row>
void read_table(sqlite3* database, const std::string& where, int schema, std::vector<Row>& rows) {
  const TableDescription& description = table<Row>().description;
  Statement all(database, where,
                fmt::format("SELECT {} FROM {} ORDER BY id", selected(description, schema), description.name));
  while (all.step()) rows.push_back(read_row<Row>(all));
}

template <typename Row>
void read_owned(sqlite3* database, const std::string& where, int schema, std::vector<Row>& owners) {
  using OwnedRow = typename std::remove_reference_t<decltype(owners.front().*Owned<Row>::rows)>::value_type;
  const TableDescription& description = table<OwnedRow>().description;
  std::map<int64_t, Row*> by_id;
  for (Row& owner : owners) by_id[owner.id] = &owner;
  Statement all(database, where,
                fmt::format("SELECT {} FROM {} ORDER BY {}, {}", selected(description, schema), description.name,
                            description.owner, description.within));
  while (all.step()) {
    const auto found = by_id.find(all.read_integer());
    if (found != by_id.end()) (found->second->*Owned<Row>::rows).push_back(read_row<OwnedRow>(all));
  }
}

}  // namespace

struct StoreWriter::State {
  std::string where;
  Database database;
  bool open = false;  // a transaction of the caller's
  mutable std::map<std::string, Statement> statements;

  Statement& statement(const std::string& sql) const {
    const auto found = statements.find(sql);
    if (found != statements.end()) return found->second;
    return statements.emplace(sql, Statement(database.get(), where, sql)).first->second;
  }

  // Runs `body` inside the caller's transaction, or inside one of its own.
  template <typename Body>
  int64_t transaction(const Body& body) {
    const bool own = !open;
    if (own) execute(database.get(), where, "BEGIN IMMEDIATE");
    try {
      const int64_t id = body();
      if (own) execute(database.get(), where, "COMMIT");
      return id;
    } catch (...) {
      statements.clear();  // a statement left in mid-step would hold the transaction open
      sqlite3_exec(database.get(), "ROLLBACK", nullptr, nullptr, nullptr);
      open = false;
      throw;
    }
  }
};

StoreWriter::StoreWriter(const std::filesystem::path& path) : state_(new State) {
  state_->where = path.string();
  const std::string& where = state_->where;
  std::error_code ignored;
  require_writable_file(path);
  // Look before touching: opening another program's file read-write could replay or checkpoint its log.
  bool existed = std::filesystem::exists(path, ignored) && std::filesystem::file_size(path, ignored) > 0;
  if (existed) {
    const Database seen = store::open(where, where, SQLITE_OPEN_READONLY);
    existed = !is_blank(seen.get(), where);
    if (existed) schema_of(seen.get(), where);
  }
  state_->database = store::open(where, where, SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE);
  sqlite3* database = state_->database.get();
  if (sqlite3_db_readonly(database, "main") == 1) fail(where, SQLITE_READONLY, "");
  if (!existed) {
    execute(database, where, "PRAGMA journal_mode=WAL");
    execute(database, where,
            fmt::format("BEGIN IMMEDIATE; PRAGMA application_id={}; PRAGMA user_version={}; {} COMMIT;",
                        kStoreApplicationId, kStoreSchemaVersion, create_sql()));
    // The main file alone shall say whose it is, even when this process is killed.
    execute(database, where, "PRAGMA wal_checkpoint(TRUNCATE)");
  } else {
    execute(database, where, "PRAGMA foreign_keys=OFF");  // tables are replaced; migrate() checks the keys
    state_->transaction([&] {
      // Also fails at once, not after the first point, when another process writes.
      if (const int schema = schema_of(database, where); schema < kStoreSchemaVersion) migrate(database, where, schema);
      return 0;
    });
  }
  execute(database, where, "PRAGMA foreign_keys=ON; PRAGMA synchronous=NORMAL;");
}

StoreWriter::~StoreWriter() {
  if (state_->open) rollback();
  state_->statements.clear();
}

void StoreWriter::begin() {
  if (state_->open) rollback();
  execute(state_->database.get(), state_->where, "BEGIN IMMEDIATE");
  state_->open = true;
}

void StoreWriter::commit() {
  assert(state_->open);
  execute(state_->database.get(), state_->where, "COMMIT");
  state_->open = false;
}

void StoreWriter::rollback() {
  sqlite3_exec(state_->database.get(), "ROLLBACK", nullptr, nullptr, nullptr);
  state_->open = false;
}

void StoreWriter::limit_pages(int pages) {
  execute(state_->database.get(), state_->where, fmt::format("PRAGMA max_page_count={}", pages));
}

template <typename Row>
int64_t StoreWriter::write(const Row& row) {
  return state_->transaction([&] {
    Statement& insert = state_->statement(insert_sql(table<Row>().description));
    bind_row(insert, row);
    insert.step();
    const int64_t id = sqlite3_last_insert_rowid(state_->database.get());
    if constexpr (OwnsRows<Row>) {
      for (const auto& owned : row.*Owned<Row>::rows) {
        Statement& one = state_->statement(insert_sql(table<std::decay_t<decltype(owned)>>().description));
        one.bind(id);
        bind_row(one, owned);
        one.step();
      }
    }
    return id;
  });
}

std::optional<MeasurementRow> StoreWriter::find(const RunRow& run, const PointKey& key) const {
  const Table<MeasurementRow>& measurements = table<MeasurementRow>();
  const MeasurementRow wanted{.key = key};
  std::string where;
  for (const Column& column : measurements.description.columns)
    if (column.point) where += identifier(column.name) + " = ? AND ";
  Statement& select = state_->statement(
      fmt::format("SELECT {} FROM measurement WHERE {} run IN (SELECT id FROM run WHERE scenario_hash = ? AND "
                  "revision = ? AND gl_renderer = ? AND gl_version = ?) ORDER BY id DESC LIMIT 1",
                  selected(measurements.description, kStoreSchemaVersion), where));
  for (const Field<MeasurementRow>& field : measurements.fields)
    if (field.column.point) select.bind(field.column.type, field.get(wanted));
  select.bind(run.scenario_hash).bind(run.revision).bind(run.gl_renderer).bind(run.gl_version);
  if (!select.step()) return std::nullopt;
  MeasurementRow row = read_row<MeasurementRow>(select);
  select.reset();
  return row;
}

StoreContents read_store(const std::filesystem::path& path, bool with_samples, bool with_pictures) {
  const std::string where = path.string();
  std::error_code failed;
  if (!std::filesystem::exists(path, failed))
    throw Error(where, "no such file", "make one with `crowdbench bench --out`");
  if (std::filesystem::is_directory(path, failed)) throw Error(where, "is a folder, not a result store");
  // Without a log nobody has the file open, and it can be read without leaving a log's files beside it.
  const bool log = std::filesystem::exists(path.string() + "-wal", failed);
  const std::string alone = uri_of(path, "?immutable=1");
  Database database = log ? store::open(where, where, SQLITE_OPEN_READONLY)
                          : store::open(alone, where, SQLITE_OPEN_READONLY | SQLITE_OPEN_URI);
  const char* probe = "SELECT count(*) FROM sqlite_master";
  int code = sqlite3_exec(database.get(), probe, nullptr, nullptr, nullptr);
  if ((code & 0xff) == SQLITE_CANTOPEN || (code & 0xff) == SQLITE_READONLY) {
    // The log cannot be opened in a folder that is not writable; then nobody else writes there either.
    database = store::open(alone, where, SQLITE_OPEN_READONLY | SQLITE_OPEN_URI);
    code = sqlite3_exec(database.get(), probe, nullptr, nullptr, nullptr);
  }
  if (code != SQLITE_OK) fail(where, code, sqlite3_errmsg(database.get()));
  // One snapshot, even while a sweep goes on writing or migrates the file.
  execute(database.get(), where, "BEGIN");
  const int schema = schema_of(database.get(), where);

  StoreContents all;
  for_each_table([&]<typename Row>(const Table<Row>& table) {
    if (table.rows == nullptr || !has_table(table.description, schema)) return;
    if (has_bytes(table.description) && !with_pictures) return;
    std::vector<Row>& rows = all.*table.rows;
    read_table(database.get(), where, schema, rows);
    if constexpr (OwnsRows<Row>)
      if (!std::is_same_v<Row, MeasurementRow> || with_samples) read_owned(database.get(), where, schema, rows);
  });
  return all;
}

// One line a table whose rows have an id.
template int64_t StoreWriter::write(const RunRow&);
template int64_t StoreWriter::write(const MeasurementRow&);
template int64_t StoreWriter::write(const RatioRow&);
template int64_t StoreWriter::write(const ControlRow&);
template int64_t StoreWriter::write(const ComparisonRow&);
template int64_t StoreWriter::write(const SweepRow&);
template int64_t StoreWriter::write(const SweepPointRow&);
template int64_t StoreWriter::write(const PictureRow&);
template int64_t StoreWriter::write(const CurveRow&);
template int64_t StoreWriter::write(const ThresholdRow&);
template int64_t StoreWriter::write(const CauseRangeRow&);
template int64_t StoreWriter::write(const PopRow&);
template int64_t StoreWriter::write(const TuningRow&);
template int64_t StoreWriter::write(const StabilityCaseRow&);
template int64_t StoreWriter::write(const StudyParticipantRow&);
template int64_t StoreWriter::write(const StudyAnswerRow&);

}  // namespace crowdbench
