// Whatever the text, the parser of a study's plan answers with a plan that has a meaning and a hash, or with one Error.
#include <cstdint>
#include <cstdlib>
#include <string>

#include "studies/plan/plan.h"
#include "tests/fuzz/fuzz_check.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace crowdbench;
  const std::string text(reinterpret_cast<const char*>(data), size);
  studies::StudyPlan plan;
  if (fuzz::answers([&] { plan = studies::parse_study_plan(text, "fuzz", "/nonexistent"); }))
    if (plan.hash().size() != 64) std::abort();
  return 0;
}
