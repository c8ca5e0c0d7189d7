// The folder of stored bakes as a whole: what lies in it, and how large it may grow.
#pragma once
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace crowdbench::renderers {

// Where bakes are stored: below cache_directory() (core/files.h).
std::filesystem::path bake_folder();

inline constexpr uint64_t kDefaultCacheLimitMiB = 4096;

// Bytes that the folder may hold: $CROWDBENCH_CACHE_LIMIT_MIB, a whole number from 0 to 2^30 (0: without limit,
// returned as UINT64_MAX), else kDefaultCacheLimitMiB. Throws Error where the variable is something else.
uint64_t cache_limit_bytes();

struct CacheEntry {
  std::filesystem::path file;
  std::string kind;  // "flat"
  std::string key;   // hexadecimal
  uint64_t bytes = 0;
  std::filesystem::file_time_type last_use;  // when it was stored, or read since
};

// The folder's entries, the one unused for longest first, ties by name; none where there is no folder. Other files are
// not among them.
std::vector<CacheEntry> cache_entries(const std::filesystem::path& folder);

// Marks an entry as used now. What fails is passed over: the folder may be read-only.
void mark_used(const std::filesystem::path& file) noexcept;

struct RemovedEntries {
  size_t count = 0;
  uint64_t bytes = 0;
};

// Removes entries, the one unused for longest first, until the folder holds no more than `bytes`. `keep`, a file of the
// folder, stays whatever it takes; so does what cannot be removed. A process that reads an entry meanwhile reads it
// whole.
RemovedEntries trim_cache(const std::filesystem::path& folder, uint64_t bytes, const std::filesystem::path& keep = {});

// Removes every entry, and what processes that were killed left half-written a day ago or earlier.
RemovedEntries clear_cache(const std::filesystem::path& folder);

}  // namespace crowdbench::renderers
