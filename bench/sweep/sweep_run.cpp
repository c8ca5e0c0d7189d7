#include "bench/sweep/sweep_run.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <charconv>
#include <cstring>
#include <system_error>

#include "bench/timing/run_facts.h"
#include "core/command_line.h"
#include "core/error.h"
#include "core/files.h"
#include "core/progress.h"
#include "core/term_status.h"

namespace crowdbench::bench::sweep {
namespace {
namespace fs = std::filesystem;

void sync(const fs::path& path, int flags) {
  const int fd = ::open(path.c_str(), flags | O_CLOEXEC);
  const bool done = fd >= 0 && ::fsync(fd) == 0;
  const int failed = errno;
  if (fd >= 0) ::close(fd);
  if (!done) throw Error(path.string(), fmt::format("cannot be synced to the disk: {}", std::strerror(failed)));
}

void remove_with_log(const fs::path& path) {
  std::error_code ignored;
  for (const char* ending : {"", "-wal", "-shm"}) fs::remove(path.string() + ending, ignored);
}

SweepRow sweep_row(const Plan& plan, const Shard& shard, const RunRow& program) {
  SweepRow row;
  row.plan_name = plan.name;
  row.plan_hash = plan.hash;
  row.plan = plan.text;
  row.conditions = static_cast<uint32_t>(plan.conditions.size());
  row.repetitions = static_cast<uint32_t>(plan.repetitions);
  row.points = plan.points();
  row.shard = shard.index;
  row.shards = shard.count;
  row.revision = program.revision;
  row.gl_renderer = program.gl_renderer;
  row.gl_version = program.gl_version;
  return row;
}

// Throws Error where the file does not hold this shard of this plan.
void require_same(const fs::path& path, const StoreContents& contents, const Plan& plan, const Shard& shard) {
  if (contents.sweeps.size() != 1)
    throw Error(path.string(), contents.sweeps.empty() ? "holds no sweep" : "holds several sweeps",
                "choose another --out");
  const SweepRow& row = contents.sweeps.front();
  if (row.plan_hash != plan.hash)
    throw Error(path.string(), fmt::format("holds another plan, '{}'", printable(row.plan_name, 80)),
                "choose another --out, or remove it");
  if (row.shard != shard.index || row.shards != shard.count)
    throw Error(path.string(), fmt::format("holds shard {}/{}", row.shard, row.shards),
                "choose another --out, or remove it");
}

void require_same_program(const fs::path& path, const SweepRow& row, const RunRow& program) {
  const auto differs = [&](const char* what, const std::string& there, const std::string& here) {
    if (there != here)
      throw Error(path.string(),
                  fmt::format("was begun by {} '{}', this is '{}'", what, printable(there, 80), printable(here, 80)),
                  "remove it to begin anew, or go on with --mixed");
  };
  differs("revision", row.revision, program.revision);
  differs("the driver", row.gl_renderer, program.gl_renderer);
  differs("the driver's version", row.gl_version, program.gl_version);
}

}  // namespace

Shard parse_shard(const std::string& text) {
  Shard shard;
  const size_t slash = text.find('/');
  const auto number = [](std::string_view digits, uint32_t& out) {
    const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), out);
    return error == std::errc() && end == digits.data() + digits.size();
  };
  const std::string_view whole = text;
  if (slash == std::string::npos || !number(whole.substr(0, slash), shard.index) ||
      !number(whole.substr(slash + 1), shard.count))
    throw Error("--shard", fmt::format("'{}' is not a shard", printable(text, 60)), "write I/K: 1/8 to 8/8");
  if (shard.count < 1 || shard.count > kMostShards || shard.index < 1 || shard.index > shard.count)
    throw Error("--shard", fmt::format("there is no shard {} of {}", shard.index, shard.count),
                fmt::format("shards count from 1, and there are up to {}", kMostShards));
  return shard;
}

fs::path partial_file(const fs::path& out) { return out.string() + ".partial"; }

std::vector<Cell> cells_of(const Plan& plan, const Shard& shard) {
  std::vector<Cell> cells;
  for (size_t c = 0; c < plan.conditions.size(); ++c)
    if (shard.holds(c))
      for (int r = 0; r < plan.repetitions; ++r) cells.emplace_back(c, r);
  return cells;
}

ShardFile::ShardFile(const fs::path& out, const Plan& plan, const Shard& shard, const RunRow& program, bool mixed)
    : out_(out), partial_(partial_file(out)) {
  require_writable_file(out);
  lock_.emplace(out);
  open(plan, shard, program, mixed);
}

void ShardFile::open(const Plan& plan, const Shard& shard, const RunRow& program, bool mixed) {
  std::error_code ignored;
  if (!fs::exists(partial_, ignored)) {
    // Made under a third name: what stops it in the middle leaves nothing that a later run would have to understand.
    const fs::path fresh = partial_.string() + ".new";
    remove_with_log(fresh);
    StoreWriter(fresh).write(sweep_row(plan, shard, program));
    fs::rename(fresh, partial_);
  }
  const StoreContents contents = read_store(partial_, false, false);
  require_same(partial_, contents, plan, shard);
  if (!mixed) require_same_program(partial_, contents.sweeps.front(), program);
  sweep_ = contents.sweeps.front().id;
  for (const SweepPointRow& row : contents.sweep_points)
    done_.insert({row.condition, static_cast<int>(row.repetition)});
  store_ = std::make_unique<StoreWriter>(partial_);
}

void ShardFile::write(const MeasuredCondition& measured) { write_condition(*store_, sweep_, measured); }

void ShardFile::finish() {
  store_.reset();  // the log goes into the file
  sync(partial_, O_RDWR);
  fs::rename(partial_, out_);
  const fs::path folder = out_.parent_path();
  sync(folder.empty() ? fs::path(".") : folder, O_RDONLY | O_DIRECTORY);
}

bool is_finished(const fs::path& out, const Plan& plan, const Shard& shard) {
  std::error_code ignored;
  if (!fs::exists(out, ignored)) return false;
  const StoreContents contents = read_store(out, false, false);
  require_same(out, contents, plan, shard);
  return true;
}

SweepOutcome run_shard(gl::Context& context, const TimingMethod& method, const Plan& plan, const Shard& shard,
                       const fs::path& out, bool mixed) {
  const auto now = [clock = system_clocks().wall] { return 1e-9 * static_cast<double>(clock()); };
  const double begun = now();
  ShardFile file(out, plan, shard, describe_run(context, method, scene::Scenario(), "sweep", command_line()), mixed);
  SweepOutcome outcome;
  const std::vector<Cell> cells = cells_of(plan, shard);
  outcome.cells = cells.size();
  say_when_interrupted(fmt::format("finished conditions are in {}, the same command goes on from there",
                                   printable(partial_file(out).string())));
  set_term_status(kRetryStatus);
  Progress progress("sweep", cells.size() - file.done().size());
  std::string where;
  ConditionBench bench(context, method, plan, [&](const std::string& now_doing) { progress.note(where + now_doing); });
  for (const Cell& cell : cells) {
    if (file.done().contains(cell)) {
      ++outcome.held;
      continue;
    }
    where = fmt::format("condition {}: ", cell.first + 1);
    const double before = now();
    const MeasuredCondition measured = bench.measure(cell.first, cell.second);
    outcome.measuring_s += now() - before;
    file.write(measured);
    ++outcome.measured;
    progress.advance();
  }
  file.finish();
  outcome.seconds = now() - begun;
  return outcome;
}

int PointStates::status() const {
  if (done == 0) return 3;
  return invalid + failed == 0 ? 0 : 1;
}

std::string PointStates::text() const {
  std::string text = fmt::format("{} {} done", done, done == 1 ? "point" : "points");
  const auto add = [&](size_t count, const char* what) {
    if (count > 0) text += fmt::format(", {} {}", count, what);
  };
  add(invalid, "invalid (the picture check failed)");
  add(unreachable, "unreachable");
  add(failed, "failed");
  return text;
}

PointStates states_of(const StoreContents& contents) {
  PointStates states;
  for (const SweepPointRow& row : contents.sweep_points) {
    if (row.role != "point") continue;
    if (row.state == "done") ++states.done;
    if (row.state == "invalid") ++states.invalid;
    if (row.state == "unreachable") ++states.unreachable;
    if (row.state == "failed") ++states.failed;
  }
  return states;
}

}  // namespace crowdbench::bench::sweep
