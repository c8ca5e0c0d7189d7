// The result store: one SQLite file (write-ahead log), one row a measurement, raw samples kept apart from aggregates.
// Its rows are in store/rows.h, what each of their columns is in store/columns.h.
//
// Every time is a column of its own with its unit in its name; what was not available is std::nullopt here and NULL
// there, never 0. A point that failed is a row with its status and the reason, never a hole. Each write_* call is one
// transaction, so that Ctrl-C or a full disk leaves a file that holds every point finished before, and no half of one.
#pragma once
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>

#include "store/rows.h"

namespace crowdbench {

// SQLite's application_id of our files ("crwd") and the version of the schema (its user_version).
inline constexpr int kStoreApplicationId = 0x63727764;
inline constexpr int kStoreSchemaVersion = 9;

// A file that measurements are added to; made when it does not exist, continued when it does. A file of an older schema
// is first brought to this one, in one transaction.
class StoreWriter {
 public:
  // Throws Error: not a SQLite file, another program's, a newer schema, read-only, locked by another writer, disk full.
  explicit StoreWriter(const std::filesystem::path& path);
  ~StoreWriter();
  StoreWriter(const StoreWriter&) = delete;
  StoreWriter& operator=(const StoreWriter&) = delete;

  // Row: one of those with an id. Returns the new row's id (the row's own is not looked at); one transaction, with the
  // rows that it holds. Throws Error; the file then holds what it held before.
  template <typename Row>
  int64_t write(const Row& row);

  // All writes between begin and commit are one transaction (one point of a sweep). Without commit the next begin, or
  // the destructor, takes them back.
  void begin();
  void commit();
  void rollback();

  // The latest row with this key (without samples) under a run of the same scenario, program revision and GL renderer:
  // what `bench` skips, and learns where a curve ended from, when it continues a file.
  std::optional<MeasurementRow> find(const RunRow& run, const PointKey& key) const;

  // The file may grow to this many pages of 4 KiB; beyond, a write fails as on a full disk.
  void limit_pages(int pages);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

// Reads a whole file, of this schema or an older one; never writes to it (a file on a read-only medium is fine). What
// an older file could not hold is absent. Throws Error: missing, not ours, newer.
StoreContents read_store(const std::filesystem::path& path, bool with_samples = false, bool with_pictures = true);

}  // namespace crowdbench
