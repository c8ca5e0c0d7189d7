#include <fmt/format.h>
#include <malloc.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <exception>
#include <iostream>
#include <limits>
#include <new>
#include <system_error>

#include "bench/commands/command_line.h"
#include "bench/commands/commands.h"
#include "core/command_line.h"
#include "core/error.h"
#include "core/fatal_signals.h"
#include "core/progress.h"
#include "core/version.h"

namespace {

using namespace crowdbench;

// What the program said on stdout has arrived, or the status says that it has not. fault: of an earlier try to write
// there, 0 for none.
int flushed(int status, int fault) {
  errno = 0;
  std::cout.flush();
  const bool arrived = std::cout.good() && std::fflush(stdout) == 0 && std::ferror(stdout) == 0;
  if (arrived) return status;
  if (fault != 0) errno = fault;
  // A reader that has seen enough (`| head`) needs no message.
  if (errno != EPIPE)
    fmt::print(stderr, "crowdbench: standard output: cannot be written{}; free some space or choose another place\n",
               errno != 0 ? fmt::format(": {}", std::strerror(errno)) : "");
  return 2;
}

// stdout_fault: set to the error number where standard output could not be written.
int run_command(int argc, char** argv, int& stdout_fault) {
  const bench::About about = {
      .name = "crowdbench",
      .description =
          "crowdbench: draws one seeded crowd by several representations and measures what each costs and gets wrong",
      .version = fmt::format("{} ({})", version(), git_revision())};
  bench::Run run;
  try {
    return bench::run_command_line(
        argc, argv, about, [&](bench::Command& program) { bench::add_all_commands(program, run); },
        [&] { return run ? run() : 0; });
  } catch (const Error& error) {
    fmt::print(stderr, "crowdbench: {}\n", error.what());
  } catch (const Interrupted&) {
    fmt::print(stderr, "{}", interrupt_line());
    return interrupt_status();
  } catch (const std::bad_alloc&) {
    fmt::print(stderr, "crowdbench: out of memory; use fewer agents, smaller pictures or a smaller character\n");
  } catch (const std::system_error& error) {
    if (std::ferror(stdout) != 0)
      stdout_fault = error.code().value();
    else
      fmt::print(stderr, "crowdbench: the system refuses a thread or memory ({}); raise its limits (ulimit -u, -v)\n",
                 printable(error.what(), 500));
  } catch (const std::exception& error) {
    if (std::ferror(stdout) == 0) fmt::print(stderr, "crowdbench: {}\n", printable(error.what(), 500));
  }
  return 2;
}

// A software rasteriser takes and gives back hundreds of megabytes a frame. Whether malloc hands that to the system
// each time depends on what was allocated before: with relief's bake loaded first, frames of the mesh took 3.5 times as
// long (pages that are mapped anew are cleared). Measured beside each other, all keep what they have.
void keep_freed_memory() {
  mallopt(M_MMAP_THRESHOLD, 32 << 20);
  mallopt(M_TRIM_THRESHOLD, std::numeric_limits<int>::max());
}

}  // namespace

int main(int argc, char** argv) {
  keep_freed_memory();
  set_command_line(argc, argv);
  install_interrupt_handler();
  install_fatal_signal_line();
  int stdout_fault = 0;
  const int status = run_command(argc, argv, stdout_fault);
  return flushed(status, stdout_fault);
}
