#include "renderers/bake/bake_cache.h"

#include <fmt/format.h>

#include <atomic>
#include <bit>
#include <cstdio>
#include <fstream>

#include "core/error.h"
#include "core/random.h"

namespace crowdbench::renderers {
namespace fs = std::filesystem;
namespace {

constexpr char kMagic[8] = {'C', 'B', 'B', 'A', 'K', 'E', '1', '\n'};

struct Header {
  char magic[8];
  char kind[24];
  char key[64];
  uint64_t payload_bytes;
  uint64_t checksum;  // over kind, key, payload_bytes and the payload
};
static_assert(sizeof(Header) == 112);

Header make_header(std::string_view kind, std::string_view key, std::span<const uint8_t> payload) {
  Header header{};
  std::memcpy(header.magic, kMagic, sizeof kMagic);
  std::memcpy(header.kind, kind.data(), std::min(kind.size(), sizeof header.kind));
  std::memcpy(header.key, key.data(), std::min(key.size(), sizeof header.key));
  header.payload_bytes = payload.size();
  const auto* start = reinterpret_cast<const uint8_t*>(header.kind);
  const uint64_t named = checksum64({start, sizeof header.kind + sizeof header.key + sizeof header.payload_bytes});
  header.checksum = checksum64(payload, named);
  return header;
}

void warn(const std::string& text) { fmt::print(stderr, "crowdbench: warning: {}\n", text); }

}  // namespace

uint64_t checksum64(std::span<const uint8_t> bytes, uint64_t seed) {
  uint64_t lanes[4] = {seed + 1, seed + 2, seed + 3, seed + 4};
  const auto step = [](uint64_t lane, uint64_t word) {
    return std::rotl(lane ^ (word * 0x9e3779b97f4a7c15ULL), 29) * 0xbf58476d1ce4e5b9ULL;
  };
  size_t i = 0;
  for (; i + 32 <= bytes.size(); i += 32)
    for (size_t k = 0; k < 4; ++k) {
      uint64_t word = 0;
      std::memcpy(&word, bytes.data() + i + 8 * k, 8);
      lanes[k] = step(lanes[k], word);
    }
  for (; i < bytes.size(); ++i) lanes[i % 4] = step(lanes[i % 4], bytes[i] + 1ULL);
  uint64_t sum = mix64(bytes.size());
  for (const uint64_t lane : lanes) sum = mix64(sum ^ lane);
  return sum;
}

BakeCache::BakeCache(fs::path folder, bool enabled) : folder_(std::move(folder)), enabled_(enabled) {}

fs::path BakeCache::path(std::string_view kind, std::string_view key) const {
  return folder_ / fmt::format("{}-{}.bake", kind, key);
}

std::optional<std::vector<uint8_t>> BakeCache::load(std::string_view kind, std::string_view key) const {
  if (!enabled_) return std::nullopt;
  const fs::path file = path(kind, key);
  std::error_code error;
  const uintmax_t size = fs::file_size(file, error);
  if (error) return std::nullopt;
  std::ifstream stream(file, std::ios::binary);
  if (!stream) return std::nullopt;
  Header header{};
  stream.read(reinterpret_cast<char*>(&header), sizeof header);
  std::vector<uint8_t> payload;
  bool sound = stream.good() && std::memcmp(header.magic, kMagic, sizeof kMagic) == 0 &&
               header.payload_bytes == size - sizeof header;
  if (sound) {
    payload.resize(header.payload_bytes);
    stream.read(reinterpret_cast<char*>(payload.data()), static_cast<std::streamsize>(payload.size()));
    const Header expected = make_header(kind, key, payload);
    sound = !stream.fail() && std::memcmp(&header, &expected, sizeof header) == 0;
  }
  if (sound) return payload;
  warn(fmt::format("{}: the stored bake is damaged or of another format; it is made anew", file.string()));
  fs::remove(file, error);
  return std::nullopt;
}

uint64_t BakeCache::store(std::string_view kind, std::string_view key, std::span<const uint8_t> payload) const {
  if (!enabled_) return 0;
  try {
    PendingFile pending(path(kind, key));
    {
      const Header header = make_header(kind, key, payload);
      std::ofstream stream(pending.path(), std::ios::binary | std::ios::trunc);
      stream.write(reinterpret_cast<const char*>(&header), sizeof header);
      stream.write(reinterpret_cast<const char*>(payload.data()), static_cast<std::streamsize>(payload.size()));
      stream.close();
      if (!stream)
        throw Error(folder_.string(), fmt::format("cannot write {} bytes", payload.size() + sizeof header),
                    "free some space, or set CROWDBENCH_CACHE_DIR to a place that can be written");
    }
    pending.commit();
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
