// A shard of a plan, measured into a file: resumed where it was left, renamed when it is whole.
//
// While it goes on the rows are in FILE.partial, a result file like any other; each condition and repetition is one
// transaction there. When all are there it is synced to the disk and becomes FILE, and its folder is synced. So FILE is
// a whole shard or does not exist, whenever the process, or the machine, stops.
#pragma once
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <utility>

#include "bench/sweep/condition_bench.h"
#include "bench/sweep/plan.h"
#include "core/file_lock.h"

namespace crowdbench::bench::sweep {

struct Shard {
  uint32_t index = 1;  // from 1
  uint32_t count = 1;
  bool holds(size_t condition) const { return condition % count == index - 1; }
};
inline constexpr uint32_t kMostShards = 10'000;
// "2/8". Throws Error naming --shard.
Shard parse_shard(const std::string& text);

// What a program leaves behind that a scheduler shall start again, perhaps elsewhere (EX_TEMPFAIL of sysexits.h).
inline constexpr int kRetryStatus = 75;

std::filesystem::path partial_file(const std::filesystem::path& out);

// A condition and repetition.
using Cell = std::pair<size_t, int>;
std::vector<Cell> cells_of(const Plan& plan, const Shard& shard);

// FILE.partial, held by this process alone. Throws Error: another process has it, it holds another plan or shard, or
// rows of another program or driver (unless `mixed`).
class ShardFile {
 public:
  ShardFile(const std::filesystem::path& out, const Plan& plan, const Shard& shard, const RunRow& program, bool mixed);

  const std::set<Cell>& done() const { return done_; }
  void write(const MeasuredCondition& measured);
  void finish();  // all is there: FILE

 private:
  void open(const Plan& plan, const Shard& shard, const RunRow& program, bool mixed);

  std::filesystem::path out_, partial_;
  std::optional<FileLock> lock_;
  int64_t sweep_ = 0;
  std::set<Cell> done_;
  std::unique_ptr<StoreWriter> store_;
};

// Whether FILE holds this shard of this plan. Throws Error where it is something else.
bool is_finished(const std::filesystem::path& out, const Plan& plan, const Shard& shard);

struct SweepOutcome {
  size_t cells = 0, held = 0, measured = 0;  // conditions and repetitions: of the shard, found done, measured now
  double seconds = 0, measuring_s = 0;       // of all, and of it in ConditionBench
};
// Throws Interrupted after Ctrl-C or SIGTERM, the latter with kRetryStatus: what was measured of the condition in hand
// is dropped, since its points are worth something together alone, and the rest waits.
SweepOutcome run_shard(gl::Context& context, const TimingMethod& method, const Plan& plan, const Shard& shard,
                       const std::filesystem::path& out, bool mixed);

// How many points of a file are in which state, and what follows from it: 0 all are done, 1 some failed, or their
// picture check did, 3 none is done.
struct PointStates {
  size_t done = 0, invalid = 0, unreachable = 0, failed = 0;
  int status() const;
  std::string text() const;  // "12 points done, 1 failed"
};
PointStates states_of(const StoreContents& contents);

}  // namespace crowdbench::bench::sweep
