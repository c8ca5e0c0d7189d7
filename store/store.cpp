#include "store/store.h"

#include <fmt/format.h>
#include <sqlite3.h>

#include <cassert>
#include <cctype>
#include <charconv>
#include <cstring>
#include <map>
#include <system_error>
#include <type_traits>

#include "core/error.h"

namespace crowdbench {
namespace {

// The view `results` is for whoever opens the file with another tool: one row a measurement, provenance included.
constexpr const char* kSchema = R"sql(
CREATE TABLE run (
  id INTEGER PRIMARY KEY,
  command TEXT NOT NULL, arguments TEXT NOT NULL, started TEXT NOT NULL,
  version TEXT NOT NULL, revision TEXT NOT NULL,
  scenario_name TEXT NOT NULL, scenario TEXT NOT NULL, scenario_hash TEXT NOT NULL, seed TEXT NOT NULL,
  gl_vendor TEXT NOT NULL, gl_renderer TEXT NOT NULL, gl_version TEXT NOT NULL,
  software INTEGER NOT NULL CHECK (software IN (0, 1)), headline TEXT NOT NULL CHECK (headline IN ('cpu', 'wall', 'gpu')),
  cpu_model TEXT NOT NULL, cpu_threads INTEGER NOT NULL, os TEXT NOT NULL, timer_cost_ns REAL NOT NULL);
CREATE TABLE measurement (
  id INTEGER PRIMARY KEY,
  run INTEGER NOT NULL REFERENCES run (id),
  representation TEXT NOT NULL, character TEXT NOT NULL, agents INTEGER NOT NULL, width_px INTEGER NOT NULL,
  height_px INTEGER NOT NULL, requested_occupancy REAL NOT NULL,
  status TEXT NOT NULL CHECK (status IN ('valid', 'invalid', 'unreachable', 'skipped', 'stopped')),
  reason TEXT NOT NULL CHECK (status = 'valid' OR reason <> ''), reference TEXT NOT NULL,
  achieved_occupancy REAL, covered_px INTEGER, reference_px INTEGER, moved_px INTEGER, touched_px INTEGER,
  agents_wholly INTEGER, agents_partly INTEGER, agents_off INTEGER, triangles_per_agent INTEGER,
  rounds INTEGER NOT NULL, warmup_frames INTEGER NOT NULL, settled INTEGER NOT NULL,
  frame_ns REAL, frame_ns_low REAL, frame_ns_high REAL, frame_ns_p05 REAL, frame_ns_p95 REAL, frame_ns_p99 REAL,
  cpu_ns REAL, cpu_ns_low REAL, cpu_ns_high REAL, cpu_ns_p05 REAL, cpu_ns_p95 REAL, cpu_ns_p99 REAL,
  main_cpu_ns REAL, main_cpu_ns_low REAL, main_cpu_ns_high REAL, main_cpu_ns_p05 REAL, main_cpu_ns_p95 REAL,
  main_cpu_ns_p99 REAL,
  gpu_ns REAL, gpu_ns_low REAL, gpu_ns_high REAL, gpu_ns_p05 REAL, gpu_ns_p95 REAL, gpu_ns_p99 REAL,
  low_1_percent_fps REAL,
  vertices_shaded INTEGER, primitives INTEGER, fragments INTEGER, samples_passed INTEGER,
  texture_bytes INTEGER, buffer_bytes INTEGER, upload_bytes_per_frame INTEGER, disk_bytes INTEGER, shared_bytes INTEGER,
  bake_seconds REAL, bake_cached INTEGER);
CREATE INDEX measurement_key ON measurement (representation, agents, requested_occupancy);
CREATE TABLE sample (
  measurement INTEGER NOT NULL REFERENCES measurement (id), round INTEGER NOT NULL, tick INTEGER NOT NULL,
  frame_ns INTEGER NOT NULL, cpu_ns INTEGER NOT NULL, main_cpu_ns INTEGER NOT NULL, gpu_ns INTEGER,
  PRIMARY KEY (measurement, round)) WITHOUT ROWID;
CREATE TABLE ratio (
  id INTEGER PRIMARY KEY,
  run INTEGER NOT NULL REFERENCES run (id),
  kind TEXT NOT NULL CHECK (kind IN ('speed', 'floor')),
  representation TEXT NOT NULL, character TEXT NOT NULL, agents INTEGER NOT NULL, width_px INTEGER NOT NULL,
  height_px INTEGER NOT NULL, requested_occupancy REAL NOT NULL,
  "to" TEXT NOT NULL, metric TEXT NOT NULL CHECK (metric IN ('cpu', 'wall', 'gpu')),
  ratio REAL NOT NULL, ratio_low REAL NOT NULL, ratio_high REAL NOT NULL, pairs INTEGER NOT NULL);
CREATE TABLE comparison (
  id INTEGER PRIMARY KEY,
  run INTEGER NOT NULL REFERENCES run (id),
  kind TEXT NOT NULL CHECK (kind IN ('crowd', 'agent')),
  representation TEXT NOT NULL, reference TEXT NOT NULL, character TEXT NOT NULL,
  agents INTEGER NOT NULL, requested_occupancy REAL NOT NULL, tick INTEGER NOT NULL,
  height_px REAL, azimuth_deg REAL, elevation_deg REAL, clip TEXT NOT NULL, time_s REAL);
CREATE TABLE score (
  comparison INTEGER NOT NULL REFERENCES comparison (id), name TEXT NOT NULL, value REAL,
  reason TEXT NOT NULL CHECK (value IS NOT NULL OR reason <> ''),
  PRIMARY KEY (comparison, name)) WITHOUT ROWID;
CREATE TABLE picture (
  id INTEGER PRIMARY KEY,
  run INTEGER NOT NULL REFERENCES run (id),
  comparison INTEGER REFERENCES comparison (id),
  role TEXT NOT NULL, caption TEXT NOT NULL, width_px INTEGER NOT NULL, height_px INTEGER NOT NULL, png BLOB NOT NULL);
CREATE VIEW results AS
  SELECT measurement.*, run.command, run.started, run.version, run.revision, run.scenario_name, run.scenario_hash,
         run.seed, run.gl_vendor, run.gl_renderer, run.gl_version, run.software, run.headline, run.cpu_model,
         run.cpu_threads, run.os
  FROM measurement JOIN run ON run.id = measurement.run;
)sql";

constexpr const char* kMeasurementColumns =
    "run, representation, character, agents, width_px, height_px, requested_occupancy, status, reason, reference, "
    "achieved_occupancy, covered_px, reference_px, moved_px, touched_px, agents_wholly, agents_partly, agents_off, "
    "triangles_per_agent, rounds, warmup_frames, settled, "
    "frame_ns, frame_ns_low, frame_ns_high, frame_ns_p05, frame_ns_p95, frame_ns_p99, "
    "cpu_ns, cpu_ns_low, cpu_ns_high, cpu_ns_p05, cpu_ns_p95, cpu_ns_p99, "
    "main_cpu_ns, main_cpu_ns_low, main_cpu_ns_high, main_cpu_ns_p05, main_cpu_ns_p95, main_cpu_ns_p99, "
    "gpu_ns, gpu_ns_low, gpu_ns_high, gpu_ns_p05, gpu_ns_p95, gpu_ns_p99, "
    "low_1_percent_fps, vertices_shaded, primitives, fragments, samples_passed, "
    "texture_bytes, buffer_bytes, upload_bytes_per_frame, disk_bytes, shared_bytes, bake_seconds, bake_cached";

constexpr const char* kRunColumns =
    "command, arguments, started, version, revision, scenario_name, scenario, scenario_hash, seed, gl_vendor, "
    "gl_renderer, gl_version, software, headline, cpu_model, cpu_threads, os, timer_cost_ns";
constexpr const char* kSampleColumns = "measurement, round, tick, frame_ns, cpu_ns, main_cpu_ns, gpu_ns";
constexpr const char* kRatioColumns =
    "run, kind, representation, character, agents, width_px, height_px, requested_occupancy, \"to\", metric, ratio, "
    "ratio_low, ratio_high, pairs";
constexpr const char* kComparisonColumns =
    "run, kind, representation, reference, character, agents, requested_occupancy, tick, height_px, azimuth_deg, "
    "elevation_deg, clip, time_s";
constexpr const char* kPictureColumns = "run, comparison, role, caption, width_px, height_px, png";

std::string insert_into(const char* table, const std::string& columns) {
  std::string places = "?";
  for (const char c : columns)
    if (c == ',') places += ", ?";
  return fmt::format("INSERT INTO {} ({}) VALUES ({})", table, columns, places);
}

struct Close {
  void operator()(sqlite3* database) const { sqlite3_close_v2(database); }
  void operator()(sqlite3_stmt* statement) const { sqlite3_finalize(statement); }
};
using Database = std::unique_ptr<sqlite3, Close>;

[[noreturn]] void fail(const std::string& where, int code, const char* message) {
  switch (code & 0xff) {
    case SQLITE_NOTADB: throw Error(where, "not a SQLite file", "name a file that `crowdbench bench --out` made");
    case SQLITE_CORRUPT: throw Error(where, "the file is damaged", "measure again into a new file");
    case SQLITE_FULL:
      throw Error(where, "the disk is full", "what was finished before is kept; free some space and run again");
    case SQLITE_READONLY:
    case SQLITE_PERM: throw Error(where, "the file or its folder cannot be written", "choose another --out");
    case SQLITE_BUSY:
    case SQLITE_LOCKED:
      throw Error(where, "another program is writing to it", "wait until it has ended, or choose another --out");
    case SQLITE_CANTOPEN: throw Error(where, "cannot be opened", "check the path and its permissions");
    case SQLITE_IOERR:
      throw Error(where, fmt::format("cannot be read or written ({})", message),
                  "what was finished before is kept; check the disk");
    default: throw Error(where, fmt::format("SQLite says: {}", message));
  }
}

// One prepared statement, bound from left to right and read from left to right.
class Statement {
 public:
  Statement(sqlite3* database, const std::string& where, const std::string& sql) : database_(database), where_(where) {
    sqlite3_stmt* statement = nullptr;
    const int code = sqlite3_prepare_v2(database, sql.c_str(), -1, &statement, nullptr);
    statement_.reset(statement);
    if (code != SQLITE_OK) fail(where_, code, sqlite3_errmsg(database_));
  }

  Statement& operator<<(const std::string& text) {
    return check(
        sqlite3_bind_text(statement_.get(), ++bound_, text.data(), static_cast<int>(text.size()), SQLITE_TRANSIENT));
  }
  Statement& operator<<(const char* text) { return *this << std::string(text); }
  Statement& operator<<(double value) { return check(sqlite3_bind_double(statement_.get(), ++bound_, value)); }
  template <typename Integer>
  requires std::is_integral_v<Integer> Statement& operator<<(Integer value) {
    return check(sqlite3_bind_int64(statement_.get(), ++bound_, static_cast<sqlite3_int64>(value)));
  }
  template <typename T>
  Statement& operator<<(const std::optional<T>& value) {
    return value ? *this << *value : check(sqlite3_bind_null(statement_.get(), ++bound_));
  }
  Statement& operator<<(const std::vector<uint8_t>& bytes) {
    return check(sqlite3_bind_blob64(statement_.get(), ++bound_, bytes.data(), bytes.size(), SQLITE_TRANSIENT));
  }
  Statement& operator<<(const PointKey& key) {
    return *this << key.representation << key.character << key.agents << key.width << key.height
                 << key.requested_occupancy;
  }
  Statement& operator<<(const std::optional<TimeSummary>& time) {
    if (time) return *this << time->median << time->low << time->high << time->p05 << time->p95 << time->p99;
    for (int i = 0; i < 6; ++i) check(sqlite3_bind_null(statement_.get(), ++bound_));
    return *this;
  }

  bool step() {
    column_ = 0;
    const int code = sqlite3_step(statement_.get());
    if (code == SQLITE_ROW) return true;
    if (code != SQLITE_DONE) fail(where_, code, sqlite3_errmsg(database_));
    reset();
    return false;
  }
  void reset() {
    sqlite3_reset(statement_.get());
    bound_ = 0;
  }

  Statement& operator>>(std::string& text) {
    const auto* bytes = sqlite3_column_text(statement_.get(), column_);
    const auto size = static_cast<size_t>(sqlite3_column_bytes(statement_.get(), column_++));
    text = bytes != nullptr ? std::string(reinterpret_cast<const char*>(bytes), size) : std::string();
    return *this;
  }
  Statement& operator>>(double& value) {
    value = sqlite3_column_double(statement_.get(), column_++);
    return *this;
  }
  template <typename Integer>
  requires std::is_integral_v<Integer> Statement& operator>>(Integer& value) {
    value = static_cast<Integer>(sqlite3_column_int64(statement_.get(), column_++));
    return *this;
  }
  template <typename T>
  Statement& operator>>(std::optional<T>& value) {
    if (null()) {
      value = std::nullopt;
      ++column_;
      return *this;
    }
    T present{};
    *this >> present;
    value = std::move(present);
    return *this;
  }
  Statement& operator>>(std::vector<uint8_t>& bytes) {
    const auto* data = static_cast<const uint8_t*>(sqlite3_column_blob(statement_.get(), column_));
    const auto size = static_cast<size_t>(sqlite3_column_bytes(statement_.get(), column_++));
    bytes.assign(data, data + size);
    return *this;
  }
  Statement& operator>>(PointKey& key) {
    return *this >> key.representation >> key.character >> key.agents >> key.width >> key.height >>
           key.requested_occupancy;
  }
  Statement& operator>>(std::optional<TimeSummary>& time) {
    if (null()) {
      time = std::nullopt;
      column_ += 6;
      return *this;
    }
    TimeSummary present;
    *this >> present.median >> present.low >> present.high >> present.p05 >> present.p95 >> present.p99;
    time = present;
    return *this;
  }

 private:
  bool null() const { return sqlite3_column_type(statement_.get(), column_) == SQLITE_NULL; }
  Statement& check(int code) {
    if (code != SQLITE_OK) fail(where_, code, sqlite3_errmsg(database_));
    return *this;
  }
  sqlite3* database_;
  std::string where_;
  std::unique_ptr<sqlite3_stmt, Close> statement_;
  int bound_ = 0;
  int column_ = 0;
};

void execute(sqlite3* database, const std::string& where, const char* sql) {
  const int code = sqlite3_exec(database, sql, nullptr, nullptr, nullptr);
  if (code != SQLITE_OK) fail(where, code, sqlite3_errmsg(database));
}

int64_t pragma(sqlite3* database, const std::string& where, const char* name) {
  Statement statement(database, where, fmt::format("PRAGMA {}", name));
  int64_t value = 0;
  if (statement.step()) statement >> value;
  return value;
}

Database open(const std::string& name, const std::string& where, int flags) {
  sqlite3* raw = nullptr;
  const int code = sqlite3_open_v2(name.c_str(), &raw, flags, nullptr);
  Database database(raw);
  if (code != SQLITE_OK) fail(where, code, raw != nullptr ? sqlite3_errmsg(raw) : sqlite3_errstr(code));
  sqlite3_extended_result_codes(raw, 1);
  sqlite3_busy_timeout(raw, 2000);
  return database;
}

void refuse_what_is_not_ours(sqlite3* database, const std::string& where) {
  const int64_t id = pragma(database, where, "application_id");
  if (id != kStoreApplicationId)
    throw Error(where, "a SQLite file of another program, not a result store",
                "name a file that `crowdbench bench --out` made");
  const int64_t version = pragma(database, where, "user_version");
  if (version > kStoreSchemaVersion)
    throw Error(
        where,
        fmt::format("written by a newer crowdbench (schema {}, this one knows {})", version, kStoreSchemaVersion),
        "update crowdbench");
  if (version < kStoreSchemaVersion)
    throw Error(where, fmt::format("has schema {}, this crowdbench reads {}", version, kStoreSchemaVersion),
                "measure again into a new file");
}

// A path as a SQLite URI: everything but plain characters is escaped.
std::string uri_of(const std::filesystem::path& path, const char* query) {
  std::string uri = "file:";
  for (const char c : std::filesystem::absolute(path).string()) {
    const bool plain = std::isalnum(static_cast<unsigned char>(c)) != 0 || std::strchr("/-_.~", c) != nullptr;
    uri += plain ? std::string(1, c) : fmt::format("%{:02X}", static_cast<unsigned char>(c));
  }
  return uri + query;
}

void read_measurement(Statement& statement, MeasurementRow& row) {
  std::string status;
  statement >> row.id >> row.run >> row.key >> status >> row.reason >> row.reference >> row.achieved_occupancy >>
      row.covered_px >> row.reference_px >> row.moved_px >> row.touched_px >> row.agents_wholly >> row.agents_partly >>
      row.agents_off >> row.triangles_per_agent >> row.rounds >> row.warmup_frames >> row.settled >> row.frame_ns >>
      row.cpu_ns >> row.main_cpu_ns >> row.gpu_ns >> row.low_1_percent_fps >> row.vertices_shaded >> row.primitives >>
      row.fragments >> row.samples_passed >> row.texture_bytes >> row.buffer_bytes >> row.upload_bytes_per_frame >>
      row.disk_bytes >> row.shared_bytes >> row.bake_seconds >> row.bake_cached;
  row.status = status_of(status);
}

}  // namespace

const char* status_name(Status status) {
  switch (status) {
    case Status::valid: return "valid";
    case Status::invalid: return "invalid";
    case Status::unreachable: return "unreachable";
    case Status::skipped: return "skipped";
    case Status::stopped: return "stopped";
  }
  return "invalid";
}

Status status_of(const std::string& name) {
  for (const Status status : {Status::valid, Status::invalid, Status::unreachable, Status::skipped, Status::stopped})
    if (name == status_name(status)) return status;
  throw Error("status", fmt::format("unknown status \"{}\"", printable(name)));
}

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
  int64_t last() const { return sqlite3_last_insert_rowid(database.get()); }

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
  if (std::filesystem::is_directory(path, ignored)) throw Error(where, "is a folder", "name a file");
  if (path.has_parent_path()) {
    std::error_code failed;
    std::filesystem::create_directories(path.parent_path(), failed);
    if (failed) throw Error(path.parent_path().string(), "cannot make this folder: " + failed.message());
  }
  // Look before touching: opening another program's file read-write could replay or checkpoint its log.
  const bool existed = std::filesystem::exists(path, ignored) && std::filesystem::file_size(path, ignored) > 0;
  if (existed) {
    const Database looked = open(where, where, SQLITE_OPEN_READONLY);
    refuse_what_is_not_ours(looked.get(), where);
  }
  state_->database = open(where, where, SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE);
  sqlite3* database = state_->database.get();
  if (sqlite3_db_readonly(database, "main") == 1) fail(where, SQLITE_READONLY, "");
  if (!existed) {
    execute(database, where, "PRAGMA journal_mode=WAL");
    execute(database, where,
            fmt::format("BEGIN IMMEDIATE; PRAGMA application_id={}; PRAGMA user_version={};{} COMMIT;",
                        kStoreApplicationId, kStoreSchemaVersion, kSchema)
                .c_str());
    // The main file alone shall say whose it is, even when this process is killed.
    execute(database, where, "PRAGMA wal_checkpoint(TRUNCATE)");
  } else {
    // Fails at once, not after the first point, when another process writes.
    execute(database, where, "BEGIN IMMEDIATE; COMMIT;");
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
  execute(state_->database.get(), state_->where, fmt::format("PRAGMA max_page_count={}", pages).c_str());
}

int64_t StoreWriter::write(const RunRow& run) {
  return state_->transaction([&] {
    Statement& insert = state_->statement(insert_into("run", kRunColumns));
    insert << run.command << run.arguments << run.started << run.version << run.revision << run.scenario_name
           << run.scenario << run.scenario_hash << std::to_string(run.seed) << run.gl_vendor << run.gl_renderer
           << run.gl_version << run.software << run.headline << run.cpu_model << run.cpu_threads << run.os
           << run.timer_cost_ns;
    insert.step();
    return state_->last();
  });
}

int64_t StoreWriter::write(const MeasurementRow& row) {
  return state_->transaction([&] {
    Statement& insert = state_->statement(insert_into("measurement", kMeasurementColumns));
    insert << row.run << row.key << status_name(row.status) << row.reason << row.reference << row.achieved_occupancy
           << row.covered_px << row.reference_px << row.moved_px << row.touched_px << row.agents_wholly
           << row.agents_partly << row.agents_off << row.triangles_per_agent << row.rounds << row.warmup_frames
           << row.settled << row.frame_ns << row.cpu_ns << row.main_cpu_ns << row.gpu_ns << row.low_1_percent_fps
           << row.vertices_shaded << row.primitives << row.fragments << row.samples_passed << row.texture_bytes
           << row.buffer_bytes << row.upload_bytes_per_frame << row.disk_bytes << row.shared_bytes << row.bake_seconds
           << row.bake_cached;
    insert.step();
    const int64_t id = state_->last();
    for (const SampleRow& sample : row.samples) {
      Statement& one = state_->statement(insert_into("sample", kSampleColumns));
      one << id << sample.round << sample.tick << sample.frame_ns << sample.cpu_ns << sample.main_cpu_ns
          << sample.gpu_ns;
      one.step();
    }
    return id;
  });
}

int64_t StoreWriter::write(const RatioRow& row) {
  return state_->transaction([&] {
    Statement& insert = state_->statement(insert_into("ratio", kRatioColumns));
    insert << row.run << row.kind << row.of << row.to << row.metric << row.ratio << row.low << row.high << row.pairs;
    insert.step();
    return state_->last();
  });
}

int64_t StoreWriter::write(const ComparisonRow& row) {
  return state_->transaction([&] {
    Statement& insert = state_->statement(insert_into("comparison", kComparisonColumns));
    insert << row.run << row.kind << row.representation << row.reference << row.character << row.agents
           << row.requested_occupancy << row.tick << row.height_px << row.azimuth_deg << row.elevation_deg << row.clip
           << row.time;
    insert.step();
    const int64_t id = state_->last();
    for (const ScoreRow& score : row.scores) {
      Statement& one = state_->statement(insert_into("score", "comparison, name, value, reason"));
      one << id << score.name << score.value << score.reason;
      one.step();
    }
    return id;
  });
}

int64_t StoreWriter::write(const PictureRow& row) {
  return state_->transaction([&] {
    Statement& insert = state_->statement(insert_into("picture", kPictureColumns));
    insert << row.run << row.comparison << row.role << row.caption << row.width << row.height << row.png;
    insert.step();
    return state_->last();
  });
}

std::optional<MeasurementRow> StoreWriter::find(const RunRow& run, const PointKey& key) const {
  Statement& select = state_->statement(
      fmt::format("SELECT id, {} FROM measurement WHERE representation = ? AND character = ? AND agents = ? AND "
                  "width_px = ? AND height_px = ? AND requested_occupancy = ? AND run IN (SELECT id FROM run WHERE "
                  "scenario_hash = ? AND revision = ? AND gl_renderer = ? AND gl_version = ?) "
                  "ORDER BY id DESC LIMIT 1",
                  kMeasurementColumns));
  select << key << run.scenario_hash << run.revision << run.gl_renderer << run.gl_version;
  if (!select.step()) return std::nullopt;
  MeasurementRow row;
  read_measurement(select, row);
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
  Database database =
      log ? open(where, where, SQLITE_OPEN_READONLY) : open(alone, where, SQLITE_OPEN_READONLY | SQLITE_OPEN_URI);
  const char* probe = "SELECT count(*) FROM sqlite_master";
  int code = sqlite3_exec(database.get(), probe, nullptr, nullptr, nullptr);
  if ((code & 0xff) == SQLITE_CANTOPEN || (code & 0xff) == SQLITE_READONLY) {
    // The log cannot be opened in a folder that is not writable; then nobody else writes there either.
    database = open(alone, where, SQLITE_OPEN_READONLY | SQLITE_OPEN_URI);
    code = sqlite3_exec(database.get(), probe, nullptr, nullptr, nullptr);
  }
  if (code != SQLITE_OK) fail(where, code, sqlite3_errmsg(database.get()));
  refuse_what_is_not_ours(database.get(), where);
  // One snapshot, even while a sweep goes on writing.
  execute(database.get(), where, "BEGIN");

  StoreContents all;
  Statement runs(database.get(), where, fmt::format("SELECT id, {} FROM run ORDER BY id", kRunColumns));
  while (runs.step()) {
    RunRow& run = all.runs.emplace_back();
    std::string seed;
    runs >> run.id >> run.command >> run.arguments >> run.started >> run.version >> run.revision >> run.scenario_name >>
        run.scenario >> run.scenario_hash >> seed >> run.gl_vendor >> run.gl_renderer >> run.gl_version >>
        run.software >> run.headline >> run.cpu_model >> run.cpu_threads >> run.os >> run.timer_cost_ns;
    std::from_chars(seed.data(), seed.data() + seed.size(), run.seed);
  }
  Statement measurements(database.get(), where,
                         fmt::format("SELECT id, {} FROM measurement ORDER BY id", kMeasurementColumns));
  std::map<int64_t, size_t> place;
  while (measurements.step()) {
    read_measurement(measurements, all.measurements.emplace_back());
    place[all.measurements.back().id] = all.measurements.size() - 1;
  }
  if (with_samples) {
    Statement samples(database.get(), where,
                      fmt::format("SELECT {} FROM sample ORDER BY measurement, round", kSampleColumns));
    while (samples.step()) {
      int64_t measurement = 0;
      SampleRow sample;
      samples >> measurement >> sample.round >> sample.tick >> sample.frame_ns >> sample.cpu_ns >> sample.main_cpu_ns >>
          sample.gpu_ns;
      const auto found = place.find(measurement);
      if (found != place.end()) all.measurements[found->second].samples.push_back(sample);
    }
  }
  Statement ratios(database.get(), where, fmt::format("SELECT id, {} FROM ratio ORDER BY id", kRatioColumns));
  while (ratios.step()) {
    RatioRow& row = all.ratios.emplace_back();
    ratios >> row.id >> row.run >> row.kind >> row.of >> row.to >> row.metric >> row.ratio >> row.low >> row.high >>
        row.pairs;
  }
  Statement comparisons(database.get(), where,
                        fmt::format("SELECT id, {} FROM comparison ORDER BY id", kComparisonColumns));
  place.clear();
  while (comparisons.step()) {
    ComparisonRow& row = all.comparisons.emplace_back();
    comparisons >> row.id >> row.run >> row.kind >> row.representation >> row.reference >> row.character >>
        row.agents >> row.requested_occupancy >> row.tick >> row.height_px >> row.azimuth_deg >> row.elevation_deg >>
        row.clip >> row.time;
    place[row.id] = all.comparisons.size() - 1;
  }
  Statement scores(database.get(), where,
                   "SELECT comparison, name, value, reason FROM score ORDER BY comparison, name");
  while (scores.step()) {
    int64_t comparison = 0;
    ScoreRow score;
    scores >> comparison >> score.name >> score.value >> score.reason;
    const auto found = place.find(comparison);
    if (found != place.end()) all.comparisons[found->second].scores.push_back(score);
  }
  if (with_pictures) {
    Statement pictures(database.get(), where, fmt::format("SELECT id, {} FROM picture ORDER BY id", kPictureColumns));
    while (pictures.step()) {
      PictureRow& row = all.pictures.emplace_back();
      pictures >> row.id >> row.run >> row.comparison >> row.role >> row.caption >> row.width >> row.height >> row.png;
    }
  }
  return all;
}

}  // namespace crowdbench
