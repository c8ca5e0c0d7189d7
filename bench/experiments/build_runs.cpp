#include "bench/experiments/build_runs.h"

#include <fmt/format.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <filesystem>
#include <thread>

#include "core/command_line.h"
#include "core/error.h"
#include "core/files.h"
#include "core/progress.h"
#include "core/temporary_folder.h"

namespace crowdbench::bench {
namespace {
namespace fs = std::filesystem;

std::string last_line(const fs::path& log) {
  std::error_code missing;
  if (!fs::exists(log, missing)) return "it said nothing";
  std::string text = read_text(log);
  while (!text.empty() && text.back() == '\n') text.pop_back();
  const size_t from = text.rfind('\n');
  return text.empty() ? "it said nothing" : printable(text.substr(from == std::string::npos ? 0 : from + 1), 300);
}

// The status of a shell's command as the shell tells it: 128 and the signal's number where one ended it. The command is
// a process group of its own, which a wish to stop ends whole: nothing of it runs on.
int run_in_group(const std::string& command) {
  const pid_t child = ::fork();
  if (child < 0) throw Error("regress", "no process could be begun", "end other work, or raise the limit of processes");
  if (child == 0) {
    ::setpgid(0, 0);
    ::execl("/bin/sh", "sh", "-c", command.c_str(), static_cast<char*>(nullptr));
    ::_exit(127);
  }
  ::setpgid(child, child);  // whichever of the two is first
  int status = 0;
  while (::waitpid(child, &status, WNOHANG) == 0) {
    if (interrupted()) {
      ::kill(-child, SIGKILL);
      ::waitpid(child, &status, 0);
      throw Interrupted();
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

StoreContents run_once(const std::string& program, const std::string& arguments, const fs::path& file) {
  const std::string out = shell_quoted(file.string());
  const std::string command =
      fmt::format("{} bench {} --out {} >/dev/null 2>{}.log", shell_quoted(program), arguments, out, out);
  if (run_in_group(command) > 1 || !fs::exists(file))
    throw Error(program, fmt::format("`bench {}` failed: {}", arguments, last_line(file.string() + ".log")),
                "--program takes programs of crowdbench; run it by itself to see more");
  return read_store(file, true);
}

}  // namespace

BuildRuns run_builds(const std::string& a, const std::string& b, const std::string& arguments, int runs) {
  const TemporaryFolder folder("regress");
  BuildRuns all;
  Progress progress("runs", 2 * static_cast<size_t>(runs));
  for (int run = 0; run < runs; ++run) {
    all.a.push_back(run_once(a, arguments, folder / fmt::format("a{}.sqlite", run)));
    progress.advance();
    all.b.push_back(run_once(b, arguments, folder / fmt::format("b{}.sqlite", run)));
    progress.advance();
  }
  return all;
}

}  // namespace crowdbench::bench
