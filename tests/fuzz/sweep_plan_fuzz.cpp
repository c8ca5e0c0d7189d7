// Whatever the text, the parser of a sweep's plan answers with a plan of as many points as it says, or with one Error.
#include <cstdint>
#include <cstdlib>
#include <string>

#include "bench/sweep/plan.h"
#include "tests/fuzz/fuzz_check.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace crowdbench;
  const std::string text(reinterpret_cast<const char*>(data), size);
  bench::sweep::Plan plan;
  if (!fuzz::answers([&] { plan = bench::sweep::parse_plan(text, "fuzz", "/nonexistent"); })) return 0;
  size_t points = 0;
  for (const bench::sweep::Condition& condition : plan.conditions) points += condition.points.size();
  if (points * static_cast<size_t>(plan.repetitions) != plan.points()) std::abort();
  return 0;
}
