#include "renderers/bake/bake_cache.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <cstdio>
#include <fstream>

#include "core/error.h"
#include "core/files.h"
#include "core/hash.h"
#include "renderers/bake/cache_entries.h"

namespace crowdbench::renderers {
namespace fs = std::filesystem;
namespace {

// The last two say the container's version, raised whenever the header's meaning changes.
constexpr char kMagic[8] = {'C', 'B', 'B', 'A', 'K', 'E', '3', '\n'};
constexpr size_t kMagicName = 6;

struct Header {
  char magic[8];
  char kind[24];
  char key[64];
  double made_seconds;
  uint64_t payload_bytes;
  uint64_t checksum;  // over what stands from kind on, and the payload
};
static_assert(sizeof(Header) == 120);

Header make_header(std::string_view kind, std::string_view key, std::span<const uint8_t> payload, double made_seconds) {
  Header header{};
  std::memcpy(header.magic, kMagic, sizeof kMagic);
  std::memcpy(header.kind, kind.data(), std::min(kind.size(), sizeof header.kind));
  std::memcpy(header.key, key.data(), std::min(key.size(), sizeof header.key));
  header.made_seconds = made_seconds;
  header.payload_bytes = payload.size();
  const auto* start = reinterpret_cast<const uint8_t*>(header.kind);
  const uint64_t named = xxh3_64({start, offsetof(Header, checksum) - offsetof(Header, kind)});
  header.checksum = xxh3_64(payload, named);
  return header;
}

void warn(const std::string& text) { fmt::print(stderr, "crowdbench: warning: {}\n", text); }

}  // namespace

BakeCache::BakeCache(fs::path folder, bool enabled) : folder_(std::move(folder)), enabled_(enabled) {}

fs::path BakeCache::path(std::string_view kind, std::string_view key) const {
  return folder_ / fmt::format("{}-{}.bake", kind, key);
}

std::optional<StoredBake> BakeCache::load(std::string_view kind, std::string_view key) const {
  if (!enabled_) return std::nullopt;
  const fs::path file = path(kind, key);
  std::error_code error;
  const uintmax_t size = fs::file_size(file, error);
  if (error) return std::nullopt;
  std::ifstream stream(file, std::ios::binary);
  if (!stream) return std::nullopt;
  Header header{};
  stream.read(reinterpret_cast<char*>(&header), sizeof header);
  const bool other_version = stream.good() && std::memcmp(header.magic, kMagic, kMagicName) == 0 &&
                             std::memcmp(header.magic, kMagic, sizeof kMagic) != 0;
  std::vector<uint8_t> payload;
  bool sound = stream.good() && std::memcmp(header.magic, kMagic, sizeof kMagic) == 0 &&
               header.payload_bytes == size - sizeof header;
  if (sound) {
    payload.resize(header.payload_bytes);
    stream.read(reinterpret_cast<char*>(payload.data()), static_cast<std::streamsize>(payload.size()));
    const Header expected = make_header(kind, key, payload, header.made_seconds);
    sound = !stream.fail() && header.checksum == expected.checksum && std::ranges::equal(header.kind, expected.kind) &&
            std::ranges::equal(header.key, expected.key);
  }
  if (sound) {
    mark_used(file);
    return StoredBake{std::move(payload), header.made_seconds};
  }
  if (!other_version) warn(fmt::format("{}: the stored bake is damaged; it is made anew", file.string()));
  fs::remove(file, error);
  return std::nullopt;
}

void BakeCache::make_room(const fs::path& newest, uint64_t limit) const {
  trim_cache(folder_, limit, newest);
  std::error_code error;
  static std::atomic<bool> said = false;
  const uintmax_t bytes = fs::file_size(newest, error);
  if (!error && bytes > limit && !said.exchange(true))
    warn(
        fmt::format("{}: this bake alone takes {} MiB of the {} that the cache may hold; it stays until the next is "
                    "stored (CROWDBENCH_CACHE_LIMIT_MIB raises the limit)",
                    newest.string(), bytes >> 20, limit >> 20));
}

uint64_t BakeCache::store(std::string_view kind, std::string_view key, std::span<const uint8_t> payload,
                          double made_seconds) const {
  if (!enabled_) return 0;
  try {
    const uint64_t limit = cache_limit_bytes();
    std::error_code error;
    fs::create_directories(folder_, error);
    if (error)
      throw Error(folder_.string(), "cannot create the folder: " + error.message(),
                  "set CROWDBENCH_CACHE_DIR to a place that can be written");
    PendingFile pending(path(kind, key));
    {
      const Header header = make_header(kind, key, payload, made_seconds);
      std::ofstream stream(pending.path(), std::ios::binary | std::ios::trunc);
      stream.write(reinterpret_cast<const char*>(&header), sizeof header);
      stream.write(reinterpret_cast<const char*>(payload.data()), static_cast<std::streamsize>(payload.size()));
      stream.close();
      if (!stream)
        throw Error(folder_.string(), fmt::format("cannot write {} bytes", payload.size() + sizeof header),
                    "free some space, or set CROWDBENCH_CACHE_DIR to a place that can be written");
    }
    pending.commit();
    make_room(path(kind, key), limit);
    return payload.size() + sizeof(Header);
  } catch (const Error& fault) {
    static std::atomic<bool> said = false;
    if (!said.exchange(true)) warn(fmt::format("bakes are not kept: {}", fault.what()));
    return 0;
  }
}

uint64_t BakeCache::disk_bytes(std::string_view kind, std::string_view key) const {
  std::error_code error;
  const uintmax_t size = fs::file_size(path(kind, key), error);
  return error ? 0 : size;
}

}  // namespace crowdbench::renderers
