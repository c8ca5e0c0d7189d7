#include "renderers/bake/cache_entries.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <chrono>
#include <cstdlib>
#include <limits>
#include <string_view>
#include <tuple>

#include "core/error.h"
#include "core/files.h"

namespace crowdbench::renderers {
namespace fs = std::filesystem;
namespace {

constexpr uint64_t kMiB = 1 << 20;

// What lies in the folder; a file that another process removes meanwhile is passed over.
std::vector<fs::path> files_in(const fs::path& folder) {
  std::vector<fs::path> files;
  std::error_code error;
  for (fs::directory_iterator it(folder, error), end; !error && it != end; it.increment(error))
    files.push_back(it->path());
  return files;
}

// "<kind>-<key>.bake", as BakeCache names them; the kind may hold '-' too.
bool is_named_as_entry(const fs::path& file) {
  const std::string stem = file.stem().string();
  const size_t dash = stem.rfind('-');
  return file.extension() == ".bake" && stem.front() != '.' && dash != std::string::npos && dash > 0 &&
         dash + 1 < stem.size() && stem.find_first_not_of("0123456789abcdef", dash + 1) == std::string::npos;
}

// What PendingFile (core/files.h) writes before it renames: long after, nobody will.
bool is_left_behind(const fs::path& file) {
  std::error_code error;
  const fs::file_time_type written = fs::last_write_time(file, error);
  const std::string name = file.filename().string();
  return !error && name.front() == '.' && name.find(".part") != std::string::npos && file.extension() == ".bake" &&
         fs::file_time_type::clock::now() - written > std::chrono::hours(24);
}

}  // namespace

fs::path bake_folder() { return cache_directory() / "bakes"; }

uint64_t cache_limit_bytes() {
  const char* set = std::getenv("CROWDBENCH_CACHE_LIMIT_MIB");
  if (set == nullptr || *set == 0) return kDefaultCacheLimitMiB * kMiB;
  const std::string_view text = set;
  uint64_t mib = 0;
  const auto [end, fault] = std::from_chars(text.data(), text.data() + text.size(), mib);
  if (fault != std::errc() || end != text.data() + text.size() || mib > (1U << 30))
    throw Error("CROWDBENCH_CACHE_LIMIT_MIB", fmt::format("'{}' is not a number of MiB", text),
                fmt::format("a whole number from 0 (no limit) to {}, for example {}", 1U << 30, kDefaultCacheLimitMiB));
  return mib == 0 ? std::numeric_limits<uint64_t>::max() : mib * kMiB;
}

std::vector<CacheEntry> cache_entries(const fs::path& folder) {
  std::vector<CacheEntry> entries;
  for (const fs::path& file : files_in(folder)) {
    if (!is_named_as_entry(file)) continue;
    std::error_code no_size;
    std::error_code no_time;
    const std::string stem = file.stem().string();
    const size_t dash = stem.rfind('-');
    CacheEntry entry = {.file = file,
                        .kind = stem.substr(0, dash),
                        .key = stem.substr(dash + 1),
                        .bytes = fs::file_size(file, no_size),
                        .last_use = fs::last_write_time(file, no_time)};
    if (!no_size && !no_time) entries.push_back(std::move(entry));
  }
  std::sort(entries.begin(), entries.end(), [](const CacheEntry& a, const CacheEntry& b) {
    return std::tie(a.last_use, a.file) < std::tie(b.last_use, b.file);
  });
  return entries;
}

void mark_used(const fs::path& file) noexcept {
  std::error_code ignored;
  fs::last_write_time(file, fs::file_time_type::clock::now(), ignored);
}

RemovedEntries trim_cache(const fs::path& folder, uint64_t bytes, const fs::path& keep) {
  const std::vector<CacheEntry> entries = cache_entries(folder);
  uint64_t held = 0;
  for (const CacheEntry& entry : entries) held += entry.bytes;
  RemovedEntries removed;
  for (const CacheEntry& entry : entries) {
    if (held <= bytes) break;
    std::error_code error;
    if (entry.file == keep || !fs::remove(entry.file, error)) continue;
    held -= entry.bytes;
    ++removed.count;
    removed.bytes += entry.bytes;
  }
  return removed;
}

RemovedEntries clear_cache(const fs::path& folder) {
  const RemovedEntries removed = trim_cache(folder, 0);
  std::error_code ignored;
  for (const fs::path& file : files_in(folder))
    if (is_left_behind(file)) fs::remove(file, ignored);
  return removed;
}

}  // namespace crowdbench::renderers
