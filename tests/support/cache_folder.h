// A cache of bakes for one test: empty, nobody else's, and gone afterwards.
#pragma once

#include <stdlib.h>

#include <optional>
#include <string>

#include "tests/support/scratch_folder.h"

namespace crowdbench::support {

class CacheFolder {
 public:
  CacheFolder() {
    if (const char* before = getenv("CROWDBENCH_CACHE_DIR")) before_ = before;
    use(folder_.path());
  }
  ~CacheFolder() { before_ ? setenv("CROWDBENCH_CACHE_DIR", before_->c_str(), 1) : unsetenv("CROWDBENCH_CACHE_DIR"); }
  CacheFolder(const CacheFolder&) = delete;
  CacheFolder& operator=(const CacheFolder&) = delete;

  // Another path in its place, until the end of the test.
  void use(const std::filesystem::path& path) { setenv("CROWDBENCH_CACHE_DIR", path.c_str(), 1); }
  std::filesystem::path operator/(const std::string& name) const { return folder_ / name; }
  std::filesystem::path bakes() const { return folder_ / "bakes"; }

 private:
  ScratchFolder folder_;
  std::optional<std::string> before_;
};

}  // namespace crowdbench::support
