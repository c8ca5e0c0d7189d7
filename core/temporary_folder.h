// A folder for a while: nobody else's, whatever runs beside it, and removed with all that it holds.
#pragma once
#include <filesystem>
#include <string>

namespace crowdbench {

class TemporaryFolder {
 public:
  // name: "test" makes "crowdbench-test-" and six letters below TMPDIR. Throws Error.
  explicit TemporaryFolder(const std::string& name);
  ~TemporaryFolder();
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;

  const std::filesystem::path& path() const { return path_; }
  std::filesystem::path operator/(const std::string& name) const { return path_ / name; }

 private:
  std::filesystem::path path_;
};

}  // namespace crowdbench
