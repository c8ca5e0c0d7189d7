// The built driver while it runs: for signals, and for how long it takes to answer them.
#pragma once

#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <filesystem>
#include <string>
#include <thread>
#include <vector>

#include "core/files.h"

namespace crowdbench::support {

class RunningDriver {
 public:
  // Runs in `folder`, which must exist; what it says on either stream goes to a file in `log_folder`.
  RunningDriver(const std::vector<std::string>& arguments, const std::filesystem::path& folder,
                const std::filesystem::path& log_folder)
      : log_(log_folder / "said.txt") {
    std::vector<std::string> words = {(program_directory() / "crowdbench").string()};
    words.insert(words.end(), arguments.begin(), arguments.end());
    std::vector<char*> raw;
    for (std::string& word : words) raw.push_back(word.data());
    raw.push_back(nullptr);
    const int log = ::open(log_.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
    pid_ = ::fork();
    if (pid_ == 0) {
      ::dup2(log, STDOUT_FILENO);
      ::dup2(log, STDERR_FILENO);
      if (::chdir(folder.c_str()) == 0) ::execv(raw[0], raw.data());
      ::_exit(127);
    }
    ::close(log);
  }
  ~RunningDriver() {
    if (pid_ <= 0 || status_ >= 0) return;
    ::kill(pid_, SIGKILL);
    ::waitpid(pid_, nullptr, 0);
  }
  RunningDriver(const RunningDriver&) = delete;
  RunningDriver& operator=(const RunningDriver&) = delete;

  std::string said() const { return read_text(log_); }
  // Until it has said this; false when it ended or `seconds` went by before.
  bool wait_until_it_says(const std::string& text, double seconds) {
    return wait(seconds, [&] { return said().find(text) != std::string::npos; }) && status_ < 0;
  }
  void send(int signal_number) const { ::kill(pid_, signal_number); }
  // Waits for its end: seconds that took, or `seconds` when it still runs.
  double wait_for_end(double seconds) {
    const auto begun = std::chrono::steady_clock::now();
    wait(seconds, [] { return false; });
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - begun).count();
  }
  int status() const { return status_; }  // as a shell gives it: 128 + the signal that killed it; -1 while it runs

 private:
  template <typename Done>
  bool wait(double seconds, const Done& done) {
    const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>(seconds);
    while (std::chrono::steady_clock::now() < end) {
      int raw = 0;
      if (status_ < 0 && ::waitpid(pid_, &raw, WNOHANG) == pid_)
        status_ = WIFEXITED(raw) ? WEXITSTATUS(raw) : 128 + WTERMSIG(raw);
      if (done()) return true;
      if (status_ >= 0) return false;
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
    return false;
  }

  std::filesystem::path log_;
  pid_t pid_ = -1;
  int status_ = -1;
};

}  // namespace crowdbench::support
