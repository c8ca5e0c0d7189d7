// Whole files in, whole files out: nothing is ever left half-written.
#pragma once
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace crowdbench {

// The bytes of a regular file. Throws Error when it is missing, a directory, unreadable or larger than `limit` bytes.
std::vector<uint8_t> read_file(const std::filesystem::path& path, size_t limit = size_t{1} << 31);
std::string read_text(const std::filesystem::path& path, size_t limit = size_t{16} << 20);

// Throws Error where nothing can be written under this name: its folder does not exist (no folder is ever made for a
// file), or the name is that of a directory or a device.
void require_writable_file(const std::filesystem::path& path);
// The same for a folder, which may be missing itself but not the folder that it is to lie in.
void require_writable_folder(const std::filesystem::path& path);

// require_writable_folder(), then makes it where it is missing.
void make_folder(const std::filesystem::path& path);

// Writes beside the target and renames, so that a reader sees the old file or the new one, never a part. Throws Error
// (as require_writable_file, disk full, no permission) and leaves no temporary file behind.
void write_file(const std::filesystem::path& path, const void* data, size_t size);
void write_file(const std::filesystem::path& path, std::string_view text);

// A file that something else writes (a database, an encoder): use path() as the name to write, then commit().
// Without commit() the destructor removes what was written.
class PendingFile {
 public:
  explicit PendingFile(std::filesystem::path target);
  ~PendingFile();
  PendingFile(const PendingFile&) = delete;
  PendingFile& operator=(const PendingFile&) = delete;
  const std::filesystem::path& path() const { return temporary_; }  // keeps the target's extension
  void commit();

 private:
  std::filesystem::path target_;
  std::filesystem::path temporary_;
  bool committed_ = false;
};

// Removes what every PendingFile of this process wrote so far, and lets none begin or commit any more: for a process
// that ends without its destructors.
void remove_pending_files() noexcept;

// $XDG_CACHE_HOME/crowdbench or ~/.cache/crowdbench; $CROWDBENCH_CACHE_DIR overrides both. Not created here.
std::filesystem::path cache_directory();
// The folder of the running program: modules and bundled data lie there.
std::filesystem::path program_directory();

}  // namespace crowdbench
