// The folder of bakes on disk as a whole: what is in it, and how large it may grow.
#pragma once
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace crowdbench::renderers {

struct CachedBake {
  std::filesystem::path file;
  std::string kind;  // of BakeCache: "flat"
  std::string key;
  uint64_t bytes = 0;
  std::filesystem::file_time_type used;  // last written or read
};

// Where the program keeps its bakes.
std::filesystem::path bake_folder();
// Every bake in a folder, the one that was not used for longest first; none where there is no such folder.
std::vector<CachedBake> cached_bakes(const std::filesystem::path& folder);

// Bytes that bakes may take on disk: $CROWDBENCH_CACHE_MIB, else 4 GiB. Throws Error where that is no number of MiB.
uint64_t bake_limit();
// Removes bakes, those not used for longest first, until the rest takes at most `limit` bytes. `keep` stays, whatever
// its size. A bake that another process removes meanwhile is no fault. Returns the bytes removed.
uint64_t shrink_bakes(const std::filesystem::path& folder, uint64_t limit, const std::filesystem::path& keep = {});

}  // namespace crowdbench::renderers
