// Whatever the bytes, a picture has as many samples as its size says, or is refused by one Error. The first byte
// chooses the format that the file's name claims.
#include <array>
#include <cstdint>
#include <cstdlib>
#include <span>
#include <variant>

#include "core/image_io.h"
#include "tests/fuzz/fuzz_check.h"

// OpenImageIO 2.4 leaks the message of a reader that failed to open (31 bytes of a cut PNG).
extern "C" const char* __lsan_default_suppressions() { return "leak:libOpenImageIO"; }

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace crowdbench;
  if (size == 0) return 0;
  constexpr std::array kFormats{"png", "exr", "jpg", "webp", "hdr"};
  const std::span<const uint8_t> bytes(data + 1, size - 1);
  fuzz::answers([&] {
    const AnyImage image = read_image(bytes, kFormats[data[0] % kFormats.size()], "fuzz", 1 << 16);
    std::visit(
        [](const auto& picture) {
          if (picture.width < 1 || picture.height < 1) std::abort();
          if (picture.data.size() != size_t(picture.width) * picture.height * picture.channels) std::abort();
        },
        image);
  });
  return 0;
}
