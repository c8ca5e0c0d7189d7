#include "bench/experiments/build_runs.h"

#include <fmt/format.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <cstdlib>
#include <filesystem>

#include "core/command_line.h"
#include "core/error.h"
#include "core/files.h"
#include "core/progress.h"

namespace crowdbench::bench {
namespace {
namespace fs = std::filesystem;

// Removed with all that it holds.
class TemporaryFolder {
 public:
  TemporaryFolder() {
    std::string name = (fs::temp_directory_path() / "crowdbench-regress-XXXXXX").string();
    if (::mkdtemp(name.data()) == nullptr)
      throw Error(fs::temp_directory_path().string(), "no folder can be made there",
                  "set TMPDIR to one that is writable");
    path_ = name;
  }
  ~TemporaryFolder() {
    std::error_code ignored;
    fs::remove_all(path_, ignored);
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  const fs::path& path() const { return path_; }

 private:
  fs::path path_;
};

std::string last_line(const fs::path& log) {
  std::error_code missing;
  if (!fs::exists(log, missing)) return "it said nothing";
  std::string text = read_text(log);
  while (!text.empty() && text.back() == '\n') text.pop_back();
  const size_t from = text.rfind('\n');
  return text.empty() ? "it said nothing" : printable(text.substr(from == std::string::npos ? 0 : from + 1), 300);
}

StoreContents run_once(const std::string& program, const std::string& arguments, const fs::path& file) {
  const std::string out = shell_quoted(file.string());
  const std::string command =
      fmt::format("{} bench {} --out {} >/dev/null 2>{}.log", shell_quoted(program), arguments, out, out);
  const int status = std::system(command.c_str());
  throw_if_interrupted();
  // By the shell's way of telling a signal. A program that crashed is not one that somebody stopped.
  const int ended = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  if (ended == 128 + SIGINT || ended == 128 + SIGTERM)
    throw Error(program, fmt::format("`bench {}` was stopped from outside", arguments), "run regress again");
  if (ended > 1 || !fs::exists(file))
    throw Error(program, fmt::format("`bench {}` failed: {}", arguments, last_line(file.string() + ".log")),
                "--program takes programs of crowdbench; run it by itself to see more");
  return read_store(file, true);
}

}  // namespace

BuildRuns run_builds(const std::string& a, const std::string& b, const std::string& arguments, int runs) {
  const TemporaryFolder folder;
  BuildRuns all;
  Progress progress("runs", 2 * static_cast<size_t>(runs));
  for (int run = 0; run < runs; ++run) {
    all.a.push_back(run_once(a, arguments, folder.path() / fmt::format("a{}.sqlite", run)));
    progress.advance();
    all.b.push_back(run_once(b, arguments, folder.path() / fmt::format("b{}.sqlite", run)));
    progress.advance();
  }
  return all;
}

}  // namespace crowdbench::bench
