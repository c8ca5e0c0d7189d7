// SHA-256 digests: cache keys, scenario hashes and the frame lists of clips. XXH3: damage of files.
#pragma once
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

namespace crowdbench {

// Accumulates bytes; numbers are hashed as their own bytes (little-endian, x86-64).
class Sha256 {
 public:
  Sha256();
  ~Sha256();
  Sha256(const Sha256&) = delete;
  Sha256& operator=(const Sha256&) = delete;

  Sha256& bytes(const void* data, size_t size);
  // Text is prefixed by its length, so that ("ab", "c") and ("a", "bc") differ.
  Sha256& text(std::string_view s);
  template <typename T>
  Sha256& value(const T& v) {
    static_assert(std::is_arithmetic_v<T> || std::is_enum_v<T>);
    return bytes(&v, sizeof v);
  }
  template <typename T>
  Sha256& values(std::span<const T> v) {
    static_assert(std::is_trivially_copyable_v<T>);
    value(v.size());
    return bytes(v.data(), v.size_bytes());
  }
  template <typename T>
  Sha256& values(const std::vector<T>& v) {
    return values(std::span<const T>(v));
  }
  // 64 lower-case hexadecimal digits. Ends the accumulation.
  std::string hex();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

std::string sha256_hex(std::string_view bytes);

// XXH3_64bits_withSeed of xxHash: for telling bytes apart fast, not for security.
uint64_t xxh3_64(std::span<const uint8_t> bytes, uint64_t seed = 0);

}  // namespace crowdbench
