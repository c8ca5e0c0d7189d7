// Whether this is a sanitizer build. Our code takes four to nine times as long in one, a driver's own code no longer.
//
// A test that only repeats there what a quicker one runs too is left out, and says which one that is; a size or a
// count that only makes a measurement finer is chosen smaller. What runs nowhere else stays as it is.
#pragma once

#include "core/sanitizer.h"

namespace crowdbench::support {

inline constexpr bool kSanitized = CROWDBENCH_HAS_SANITIZER;

}  // namespace crowdbench::support

// Ends the test in a sanitizer build. `by`: what runs the same code there.
#define CROWDBENCH_SKIP_SANITIZED(by) \
  if (::crowdbench::support::kSanitized) GTEST_SKIP() << "left out of sanitizer builds: its code is run by " << (by)
