// Whatever the text, a representation's spec is taken apart into one whose text says the same, or refused by one Error.
#include <cstdint>
#include <cstdlib>
#include <string>

#include "renderers/representation.h"
#include "tests/fuzz/fuzz_check.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace crowdbench;
  const std::string text(reinterpret_cast<const char*>(data), size);
  fuzz::answers([&] {
    for (const renderers::Spec& spec : renderers::parse_specs(text)) {
      const std::string written = spec.text();
      std::string again;
      if (!fuzz::answers([&] { again = renderers::parse_spec(written).text(); }) || again != written) std::abort();
    }
  });
  return 0;
}
