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

// Replaces control characters by '?', so that text from a file cannot break the one line or drive a terminal.
// At most `limit` bytes are kept; a cut text ends in "...".
std::string printable(std::string_view text, size_t limit = 200);

// The candidate nearest to `name` by edit distance, for "did you mean"; empty when none is near.
std::string nearest_name(std::string_view name, const std::vector<std::string>& candidates);

}  // namespace crowdbench
