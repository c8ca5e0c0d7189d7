#include "bench/sweep/merge.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <fstream>
#include <map>
#include <optional>
#include <set>
#include <string_view>
#include <system_error>

#include "core/counted.h"
#include "core/error.h"
#include "core/files.h"
#include "core/progress.h"

namespace crowdbench::bench::sweep {
namespace {

struct FinishedShard {
  std::filesystem::path path;
  StoreContents contents;
  const SweepRow& sweep() const { return contents.sweeps.front(); }
};

bool is_result_file(const std::filesystem::path& path) {
  std::array<char, 16> head{};
  std::ifstream file(path, std::ios::binary);
  return file.read(head.data(), head.size()) && std::string_view(head.data(), 15) == "SQLite format 3";
}

std::vector<FinishedShard> read_shards(const MergeRequest& request) {
  std::vector<FinishedShard> shard_files;
  for (const std::filesystem::path& path : request.shards) {
    throw_if_interrupted();
    std::error_code failed;
    // A shard that was not finished: what is missing is said of all together.
    if (!std::filesystem::exists(path, failed)) continue;
    shard_files.push_back({path, read_store(path, true, true)});
    if (shard_files.back().contents.sweeps.size() != 1)
      throw Error(path.string(), "is not a shard of a sweep", "name files that `crowdbench sweep` made");
  }
  std::sort(shard_files.begin(), shard_files.end(),
            [](const FinishedShard& a, const FinishedShard& b) { return a.sweep().shard < b.sweep().shard; });
  return shard_files;
}

void require_one_plan(const std::vector<FinishedShard>& shard_files) {
  const SweepRow& first = shard_files.front().sweep();
  std::map<uint32_t, const FinishedShard*> by_shard;
  for (const FinishedShard& held : shard_files) {
    const SweepRow& row = held.sweep();
    if (row.plan_hash != first.plan_hash)
      throw Error(held.path.string(), fmt::format("is of another plan than {}", shard_files.front().path.string()),
                  "merge the shards of one plan");
    if (row.shards != first.shards)
      throw Error(
          held.path.string(),
          fmt::format("is one of {} shards, {} one of {}", row.shards, shard_files.front().path.string(), first.shards),
          "merge shards that were cut alike");
    if (const auto [place, fresh] = by_shard.emplace(row.shard, &held); !fresh)
      throw Error(held.path.string(), fmt::format("is shard {} again, as {}", row.shard, place->second->path.string()),
                  "name each shard once");
  }
}

// Throws where shards come from different programs or drivers; or remarks it.
void check_provenance(const std::vector<FinishedShard>& shard_files, bool mixed, std::vector<std::string>& remarks) {
  const auto check = [&](const char* what, const auto& of) {
    const FinishedShard& first = shard_files.front();
    for (const FinishedShard& held : shard_files) {
      for (const RunRow& run : held.contents.runs) {
        const std::string expected = of(first.sweep());
        const std::string found = of(run);
        if (found == expected) continue;
        const std::string text = fmt::format("{} is '{}', that of {} is '{}'", what, printable(found, 80),
                                             first.path.string(), printable(expected, 80));
        if (!mixed)
          throw Error(held.path.string(), text, "measure it anew with the same, or merge them nonetheless: --mixed");
        remarks.push_back(held.path.string() + ": " + text);
        return;
      }
    }
  };
  check("its program", [](const auto& row) { return row.revision; });
  check("its driver", [](const auto& row) { return row.gl_renderer; });
  check("its driver's version", [](const auto& row) { return row.gl_version; });
}

void check_complete(const std::vector<FinishedShard>& shard_files, bool allow_missing,
                    std::vector<std::string>& remarks) {
  const SweepRow& sweep = shard_files.front().sweep();
  std::set<uint32_t> here;
  std::set<std::pair<uint32_t, uint32_t>> cells;
  for (const FinishedShard& held : shard_files) {
    here.insert(held.sweep().shard);
    for (const SweepPointRow& row : held.contents.sweep_points) cells.emplace(row.condition, row.repetition);
  }
  std::vector<uint32_t> missing;
  size_t of_missing = 0;
  for (uint32_t shard = 1; shard <= sweep.shards; ++shard)
    if (!here.contains(shard)) {
      missing.push_back(shard);
      for (uint32_t c = shard - 1; c < sweep.conditions; c += sweep.shards) of_missing += sweep.repetitions;
    }
  const size_t expected = size_t{sweep.conditions} * sweep.repetitions;
  if (cells.size() == expected) return;
  std::string text;
  if (!missing.empty())
    text = fmt::format("of {} are missing: {}", counted(sweep.shards, "shard", "shards"), fmt::join(missing, ", "));
  if (cells.size() + of_missing < expected)
    text += fmt::format("{}missing in the shards named: {}", text.empty() ? "" : "; ",
                        counted(expected - of_missing - cells.size(), "condition", "conditions"));
  if (!allow_missing) throw MissingShards{text};
  remarks.push_back(text);
}

// Gives every row of the shards its new place, condition by condition.
class Merger {
 public:
  Merger(StoreWriter& store, const SweepRow& first) : store_(store) {
    SweepRow row = first;
    row.shard = 1;
    row.shards = 1;
    contents_.sweeps.push_back(row);
    contents_.sweeps.back().id = store_.write(row);
  }

  void run(const std::vector<FinishedShard>& shard_files) {
    struct Place {
      uint32_t condition, repetition;
      const FinishedShard* held;
      int64_t run;
      auto operator<=>(const Place&) const = default;
    };
    std::set<Place> places;
    for (const FinishedShard& held : shard_files)
      for (const SweepPointRow& row : held.contents.sweep_points)
        places.insert({row.condition, row.repetition, &held, row.run});
    std::map<const FinishedShard*, Index> indices;
    for (const FinishedShard& held : shard_files) indices.emplace(&held, Index(held.contents));
    for (const Place& place : places) {
      throw_if_interrupted();
      add(indices.at(place.held), place.run, place.held->path);
    }
  }
  StoreContents take() { return std::move(contents_); }

 private:
  // Rows of a shard by their run.
  struct Index {
    explicit Index(const StoreContents& all) {
      for (const RunRow& row : all.runs) runs[row.id] = &row;
      for (const MeasurementRow& row : all.measurements) measurements[row.run].push_back(&row);
      for (const RatioRow& row : all.ratios) ratios[row.run].push_back(&row);
      for (const ComparisonRow& row : all.comparisons) comparisons[row.run].push_back(&row);
      for (const PictureRow& row : all.pictures) pictures[row.run].push_back(&row);
      for (const SweepPointRow& row : all.sweep_points) points[row.run].push_back(&row);
    }
    std::map<int64_t, const RunRow*> runs;
    std::map<int64_t, std::vector<const MeasurementRow*>> measurements;
    std::map<int64_t, std::vector<const RatioRow*>> ratios;
    std::map<int64_t, std::vector<const ComparisonRow*>> comparisons;
    std::map<int64_t, std::vector<const PictureRow*>> pictures;
    std::map<int64_t, std::vector<const SweepPointRow*>> points;
  };

  // Writes a row of the new run, keeps it without what is bulky, and returns its id.
  template <typename Row>
  int64_t write(const Row& row, std::vector<Row>& kept) {
    const int64_t id = store_.write(row);
    kept.push_back(row);
    kept.back().id = id;
    return id;
  }

  static std::optional<int64_t> moved(const std::map<int64_t, int64_t>& ids, const std::optional<int64_t>& old) {
    const auto found = old ? ids.find(*old) : ids.end();
    return found == ids.end() ? std::nullopt : std::optional(found->second);
  }

  void add(const Index& index, int64_t old_run, const std::filesystem::path& path) {
    const auto found = index.runs.find(old_run);
    if (found == index.runs.end())
      throw Error(path.string(), fmt::format("a point is of run {}, which it does not hold", old_run),
                  "the file is damaged: measure the shard again");
    const int64_t run = write(*found->second, contents_.runs);
    std::map<int64_t, int64_t> measurements;
    std::map<int64_t, int64_t> comparisons;
    for (const MeasurementRow* old : rows_of(index.measurements, old_run)) {
      MeasurementRow row = *old;
      row.run = run;
      measurements[old->id] = store_.write(row);
      row.id = measurements[old->id];
      row.samples.clear();
      contents_.measurements.push_back(std::move(row));
    }
    for (const RatioRow* old : rows_of(index.ratios, old_run)) {
      RatioRow row = *old;
      row.run = run;
      write(row, contents_.ratios);
    }
    for (const ComparisonRow* old : rows_of(index.comparisons, old_run)) {
      ComparisonRow row = *old;
      row.run = run;
      comparisons[old->id] = write(row, contents_.comparisons);
    }
    for (const PictureRow* old : rows_of(index.pictures, old_run)) {
      PictureRow row = *old;
      row.run = run;
      row.comparison = moved(comparisons, old->comparison);
      store_.write(row);
    }
    for (const SweepPointRow* old : rows_of(index.points, old_run)) {
      SweepPointRow row = *old;
      row.sweep = contents_.sweeps.front().id;
      row.run = run;
      row.measurement = moved(measurements, old->measurement);
      row.comparison = moved(comparisons, old->comparison);
      write(row, contents_.sweep_points);
    }
  }

  template <typename Row>
  static const std::vector<const Row*>& rows_of(const std::map<int64_t, std::vector<const Row*>>& rows, int64_t run) {
    static const std::vector<const Row*> none;
    const auto found = rows.find(run);
    return found == rows.end() ? none : found->second;
  }

  StoreWriter& store_;
  StoreContents contents_;
};

}  // namespace

MergeOutcome merge_shards(const MergeRequest& request) {
  MergeOutcome outcome;
  // A file that is not one of results is somebody's, a plan's for example.
  if (std::filesystem::exists(request.out) && !is_result_file(request.out))
    throw Error(request.out.string(), "is there and is not a result file", "choose another file to merge into");
  const std::vector<FinishedShard> shard_files = read_shards(request);
  if (shard_files.empty()) throw MissingShards{"none of the shards is there"};
  require_one_plan(shard_files);
  check_provenance(shard_files, request.mixed, outcome.remarks);
  check_complete(shard_files, request.allow_missing, outcome.remarks);
  PendingFile pending(request.out);
  {
    StoreWriter store(pending.path());
    store.begin();
    Merger merger(store, shard_files.front().sweep());
    merger.run(shard_files);
    store.commit();
    outcome.contents = merger.take();
  }
  pending.commit();
  return outcome;
}

}  // namespace crowdbench::bench::sweep
