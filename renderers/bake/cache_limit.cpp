#include "renderers/bake/cache_limit.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cstdlib>
#include <string_view>
#include <system_error>
#include <tuple>

#include "core/error.h"
#include "core/files.h"

namespace crowdbench::renderers {
namespace fs = std::filesystem;

fs::path bake_folder() { return cache_directory() / "bakes"; }

std::vector<CachedBake> cached_bakes(const fs::path& folder) {
  std::vector<CachedBake> out;
  std::error_code error;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, error)) {
    const std::string name = entry.path().stem().string();
    const size_t dash = name.rfind('-');
    if (entry.path().extension() != ".bake" || dash == std::string::npos || !entry.is_regular_file(error)) continue;
    CachedBake bake{entry.path(), name.substr(0, dash), name.substr(dash + 1), 0, {}};
    bake.bytes = entry.file_size(error);
    if (!error) bake.used = entry.last_write_time(error);
    if (!error) out.push_back(std::move(bake));  // else it has gone meanwhile
  }
  std::sort(out.begin(), out.end(), [](const CachedBake& a, const CachedBake& b) {
    return std::tie(a.used, a.file) < std::tie(b.used, b.file);
  });
  return out;
}

uint64_t bake_limit() {
  constexpr const char* kName = "CROWDBENCH_CACHE_MIB";
  constexpr uint64_t kMost = 1'000'000'000;
  const char* text = std::getenv(kName);
  if (text == nullptr || *text == '\0') return uint64_t{4} << 30;
  const std::string_view value = text;
  uint64_t mib = 0;
  const auto [end, fault] = std::from_chars(value.data(), value.data() + value.size(), mib);
  if (fault != std::errc{} || end != value.data() + value.size() || mib > kMost)
    throw Error(kName, fmt::format("'{}' is not a whole number of MiB", printable(text, 40)),
                fmt::format("0 to {}, or leave it unset for 4096", kMost));
  return mib << 20;
}

uint64_t shrink_bakes(const fs::path& folder, uint64_t limit, const fs::path& keep) {
  const std::vector<CachedBake> bakes = cached_bakes(folder);
  uint64_t total = 0;
  for (const CachedBake& bake : bakes) total += bake.bytes;
  uint64_t removed = 0;
  for (const CachedBake& bake : bakes) {
    if (total - removed <= limit) break;
    if (bake.file == keep) continue;
    std::error_code error;
    fs::remove(bake.file, error);
    if (!error) removed += bake.bytes;
  }
  return removed;
}

}  // namespace crowdbench::renderers
