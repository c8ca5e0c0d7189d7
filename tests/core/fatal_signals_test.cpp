#include "core/fatal_signals.h"

#include <gtest/gtest.h>

#include <csignal>

#include "tests/support/sanitized.h"

namespace crowdbench {
namespace {

TEST(FatalSignalsDeathTest, OneLineAndTheSameEnd) {
  CROWDBENCH_SKIP_SANITIZED("the sanitizers' own reports");
  for (const int number : {SIGSEGV, SIGBUS, SIGILL, SIGFPE, SIGABRT})
    EXPECT_EXIT(
        {
          install_fatal_signal_line();
          ::raise(number);
        },
        testing::KilledBySignal(number), "^crowdbench: ended by SIG[A-Z]+[^\n]*report the command line\n$");
}

}  // namespace
}  // namespace crowdbench
