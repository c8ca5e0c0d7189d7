// One process at a time measures into a file.
#pragma once
#include <filesystem>

namespace crowdbench {

// Held from construction to destruction by the file FILE.lock beside FILE, which goes with it; a process that is killed
// leaves it lying, and holds nothing. Not for threads of one process.
class FileLock {
 public:
  // Throws Error, naming the file, where another process holds it or the lock's own file cannot be made.
  explicit FileLock(const std::filesystem::path& file);
  ~FileLock();
  FileLock(const FileLock&) = delete;
  FileLock& operator=(const FileLock&) = delete;

 private:
  std::filesystem::path path_;
  int descriptor_ = -1;
};

}  // namespace crowdbench
