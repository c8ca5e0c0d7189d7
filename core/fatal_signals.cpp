#include "core/fatal_signals.h"

#include <unistd.h>

#include <csignal>
#include <string_view>

#include "core/sanitizer.h"

namespace crowdbench {
namespace {

constexpr struct {
  int number;
  std::string_view line;
} kFatal[] = {
    {SIGSEGV, "crowdbench: ended by SIGSEGV, a fault in this program or in a driver; "},
    {SIGBUS, "crowdbench: ended by SIGBUS, a fault in this program or in a driver, or a file cut under it; "},
    {SIGILL, "crowdbench: ended by SIGILL: this processor lacks what the program or a driver was built for; "},
    {SIGFPE, "crowdbench: ended by SIGFPE, a fault in this program or in a driver; "},
    {SIGABRT, "crowdbench: ended by SIGABRT, a fault in this program or in a driver; "},
};
constexpr std::string_view kAdvice =
    "finished work is kept; raise limits of memory (ulimit -v), or report the command line\n";

void say(std::string_view text) {
  [[maybe_unused]] const auto ignored = ::write(STDERR_FILENO, text.data(), text.size());
}

// Only what a signal's handler may call.
void on_fatal_signal(int number) {
  std::signal(number, SIG_DFL);
  for (const auto& fatal : kFatal)
    if (fatal.number == number) say(fatal.line);
  say(kAdvice);
  ::raise(number);
}

}  // namespace

void install_fatal_signal_line() {
  if (CROWDBENCH_HAS_SANITIZER) return;
  for (const auto& fatal : kFatal) std::signal(fatal.number, on_fatal_signal);
}

}  // namespace crowdbench
