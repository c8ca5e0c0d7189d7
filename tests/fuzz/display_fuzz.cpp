// Whatever the text, a file of displays is displays with a resolution and a peak, or one Error.
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <string_view>
#include <vector>

#include "metrics/display.h"
#include "tests/fuzz/fuzz_check.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace crowdbench;
  fuzz::answers([&] {
    for (const metrics::Display& display :
         metrics::parse_displays({reinterpret_cast<const char*>(data), size}, "fuzz", "fuzz"))
      if (!std::isfinite(display.pixels_per_degree) || display.pixels_per_degree <= 0) std::abort();
  });
  return 0;
}
