// Error: the one exception for whatever a user or a machine can cause (a bad file, a bad value, a missing driver).
#pragma once
#include <fmt/format.h>

#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace crowdbench {

// Carries what was wrong, where, and what to do. `what()` joins them into one line: "where: what; what to do".
// The driver prints that line on stderr and exits 2. A broken invariant is an assertion, never an Error.
class Error : public std::runtime_error {
 public:
  // where: a file, "file:line", a JSON path or an option's name; empty when nothing narrower than the program is known.
  // wrong: what is wrong, no full stop. advice: what to do about it; may be empty.
  Error(std::string where, std::string wrong, std::string advice = {});

  std::string where;
  std::string wrong;
  std::string advice;
};

// For text that a user or a file gave, before it enters a message: replaces control characters by '?', so that it
// cannot break the one line or drive a terminal, and keeps at most `limit` bytes of it, whole characters, with "..."
// after what was cut. What the program itself says is never cut.
std::string printable(std::string_view text, size_t limit = 200);

// The candidate nearest to `name` by edit distance, for "did you mean": case counts for nothing, two letters swapped
// for one. Empty when none is near; the first of several.
std::string nearest_name(std::string_view name, const std::vector<std::string>& candidates);

// "walk, Walking_A, run and 12 more": as many whole candidates as `most`, in their own order where all are shown, else
// the nearest to `name` first.
std::string nearest_first(std::string_view name, const std::vector<std::string>& candidates, size_t most = 12);

}  // namespace crowdbench
