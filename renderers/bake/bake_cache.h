// Bakes on disk: what a representation precomputed, keyed by the content it was computed from.
#pragma once
#include <array>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "renderers/bake/cache_entries.h"

namespace crowdbench::renderers {

// What `ByteWriter::value` takes: numbers and arrays of them. A structure may have padding, whose bytes are anything;
// the same bake would not be the same bytes.
template <typename T>
inline constexpr bool kIsPlain = std::is_arithmetic_v<T>;
template <typename T, size_t N>
inline constexpr bool kIsPlain<std::array<T, N>> = std::is_arithmetic_v<T>;

// Appends plain values and arrays, little-endian as they lie in memory (x86-64).
class ByteWriter {
 public:
  template <typename T>
  void value(const T& v) {
    static_assert(kIsPlain<T>);
    const auto* p = reinterpret_cast<const uint8_t*>(&v);
    bytes_.insert(bytes_.end(), p, p + sizeof v);
  }
  // Structures in v must be without padding.
  template <typename T>
  void values(const std::vector<T>& v) {
    static_assert(std::is_trivially_copyable_v<T>);
    value(static_cast<uint64_t>(v.size()));
    const auto* p = reinterpret_cast<const uint8_t*>(v.data());
    bytes_.insert(bytes_.end(), p, p + v.size() * sizeof(T));
  }
  const std::vector<uint8_t>& bytes() const { return bytes_; }
  void reserve(size_t n) { bytes_.reserve(n); }

 private:
  std::vector<uint8_t> bytes_;
};

// Reads them back. Reading past the end makes ok() false and gives zeros and empty arrays: the caller checks once, at
// the end.
class ByteReader {
 public:
  explicit ByteReader(std::span<const uint8_t> bytes) : bytes_(bytes) {}
  template <typename T>
  T value() {
    static_assert(std::is_trivially_copyable_v<T>);
    T v{};
    if (take(sizeof v)) std::memcpy(&v, bytes_.data() + at_ - sizeof v, sizeof v);
    return v;
  }
  template <typename T>
  std::vector<T> values() {
    const auto n = value<uint64_t>();
    if (!ok_ || n > (bytes_.size() - at_) / sizeof(T)) {
      ok_ = false;
      return {};
    }
    std::vector<T> v(n);
    if (n > 0) std::memcpy(v.data(), bytes_.data() + at_, n * sizeof(T));
    at_ += n * sizeof(T);
    return v;
  }
  bool ok() const { return ok_; }
  bool at_end() const { return at_ == bytes_.size(); }

 private:
  bool take(size_t n) {
    if (!ok_ || n > bytes_.size() - at_) return ok_ = false;
    at_ += n;
    return true;
  }
  std::span<const uint8_t> bytes_;
  size_t at_ = 0;
  bool ok_ = true;
};

// What an entry gives back.
struct StoredBake {
  std::vector<uint8_t> payload;
  double made_seconds = 0;  // what making it took, when it was stored
};

// One folder of entries, "<kind>-<key>.bake". An entry holds its kind, its key, what making it took and a checksum over
// everything; one that
// does not agree with them (flipped bits, cut short) is reported on stderr, removed and counts as absent; one that
// another version wrote is removed and counts as absent without a word. Nothing here ever fails a run: a folder that
// cannot be written is one warning a process. What makes the folder larger than cache_limit_bytes() (cache_entries.h)
// pushes out what was unused for longest.
class BakeCache {
 public:
  explicit BakeCache(std::filesystem::path folder = bake_folder(), bool enabled = true);

  // What is stored under (kind, key), if it is sound. kind: letters, digits and '-'. key: hexadecimal.
  std::optional<StoredBake> load(std::string_view kind, std::string_view key) const;
  // Writes beside and renames. made_seconds: what making the payload took. Returns the bytes on disk, 0 when it could
  // not be written (a warning says why).
  uint64_t store(std::string_view kind, std::string_view key, std::span<const uint8_t> payload,
                 double made_seconds) const;
  // Bytes on disk of an entry, 0 when there is none.
  uint64_t disk_bytes(std::string_view kind, std::string_view key) const;
  std::filesystem::path path(std::string_view kind, std::string_view key) const;
  bool enabled() const { return enabled_; }

 private:
  void make_room(const std::filesystem::path& newest, uint64_t limit) const;

  std::filesystem::path folder_;
  bool enabled_;
};

}  // namespace crowdbench::renderers
