// A virtual X display for window tests, on a free number, ended with the object.
#pragma once
#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <filesystem>
#include <string>

extern char** environ;

namespace crowdbench::test {

class Xvfb {
 public:
  static bool installed() { return std::filesystem::exists("/usr/bin/Xvfb"); }

  Xvfb() {
    int ends[2];
    if (::pipe(ends) != 0) return;
    ::fcntl(ends[0], F_SETFD, FD_CLOEXEC);
    // Xvfb chooses a free display and writes its number, once it is ready, to the descriptor that it is given.
    const std::string descriptor = std::to_string(ends[1]);
    const char* arguments[] = {"Xvfb",       "-displayfd", descriptor.c_str(), "-screen", "0",    "1280x1024x24",
                               "+extension", "GLX",        "-nolisten",        "tcp",     nullptr};
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_addopen(&actions, STDERR_FILENO, "/dev/null", O_WRONLY, 0);
    if (::posix_spawn(&pid_, "/usr/bin/Xvfb", &actions, nullptr, const_cast<char**>(arguments), environ) != 0) {
      pid_ = -1;
    }
    posix_spawn_file_actions_destroy(&actions);
    ::close(ends[1]);
    std::string number;
    char c = 0;
    while (::read(ends[0], &c, 1) == 1 && c != '\n') number += c;
    ::close(ends[0]);
    if (!number.empty()) display_ = ":" + number;
  }
  ~Xvfb() {
    if (pid_ <= 0) return;
    ::kill(pid_, SIGTERM);
    ::waitpid(pid_, nullptr, 0);
  }
  Xvfb(const Xvfb&) = delete;
  Xvfb& operator=(const Xvfb&) = delete;

  // ":7"; empty when it did not start.
  const std::string& display() const { return display_; }

 private:
  pid_t pid_ = -1;
  std::string display_;
};

}  // namespace crowdbench::test
