// Work in a child process of its own: for a library that may crash, hang or take all memory on a file that somebody
// made for that. Internal to the loader.
#pragma once
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

namespace crowdbench::scene {

struct IsolationLimits {
  uint64_t memory_bytes = uint64_t{2} << 30;  // of address space, beyond what the process already has
  uint64_t cpu_seconds = 60;
  int idle_seconds = 10;  // in a row without CPU time
  uint64_t output_bytes = uint64_t{512} << 20;
};

struct IsolatedOutput {
  std::vector<uint8_t> bytes;  // whatever was written before the end
  std::string failure;         // what ended it ("ran into signal 11"); empty: all went well
};

// Runs work(fd) in a child made by fork(), in which what it throws, crashes or exceeds ends
// the child alone; what it writes to fd comes back. The child's stdout and stderr go nowhere, and it ends without
// destructors. `what` is said as progress. Throws Error where no process can be made, Interrupted on Ctrl-C.
IsolatedOutput run_isolated(const std::string& what, const std::function<void(int fd)>& work,
                            const IsolationLimits& limits = {});

}  // namespace crowdbench::scene
