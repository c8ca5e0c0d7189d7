// Runs the built driver as a user would: a process of its own, its exit status, what it prints.
#pragma once

#include <sys/wait.h>

#include <array>
#include <cstdio>
#include <filesystem>
#include <string>

#include "core/files.h"

namespace crowdbench::support {

struct Outcome {
  int status = -1;   // -1: ended by a signal, or not started
  std::string text;  // stdout, and stderr when asked for
};

inline bool driver_is_built() { return std::filesystem::exists(program_directory() / "crowdbench"); }

// A line of the shell.
inline Outcome run_shell(const std::string& command) {
  Outcome out;
  FILE* pipe = popen(command.c_str(), "r");
  if (!pipe) return out;
  std::array<char, 4096> buffer{};
  while (const size_t n = fread(buffer.data(), 1, buffer.size(), pipe)) out.text.append(buffer.data(), n);
  const int status = pclose(pipe);
  out.status = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  return out;
}

// `prefix` stands before the driver in the shell's line: variables (A=1) or `cd DIR;`. `with_stderr`: false for JSON.
inline Outcome run_driver(const std::string& prefix, const std::string& arguments, bool with_stderr = true) {
  return run_shell(prefix + " '" + (program_directory() / "crowdbench").string() + "' " + arguments +
                   (with_stderr ? " 2>&1" : " 2>/dev/null"));
}

}  // namespace crowdbench::support
