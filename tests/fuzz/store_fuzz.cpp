// Whatever the bytes of the file, a result store is read, or refused by one Error.
#include <unistd.h>

#include <cstdint>
#include <filesystem>
#include <string>

#include "core/files.h"
#include "store/store.h"
#include "tests/fuzz/fuzz_check.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace crowdbench;
  static const std::filesystem::path file =
      std::filesystem::temp_directory_path() / ("crowdbench-fuzz-" + std::to_string(getpid()) + ".sqlite");
  write_file(file, data, size);
  fuzz::answers([&] { read_store(file, true); });
  std::filesystem::remove(file);
  return 0;
}
