#include "core/hash.h"

#include <sha2.h>
#include <xxhash.h>

#include <array>
#include <cstring>

#include "core/sha256_blocks.h"

namespace crowdbench {

namespace {

constexpr size_t kBlock = SHA256_BLOCK_LENGTH;

void take(SHA2_CTX& context, const uint8_t* at, size_t size) {
  if (size >= 2 * kBlock && has_sha256_instructions()) {
    // What libmd holds back fills a block first; whole blocks need not go through it.
    if (const size_t held = context.bitcount[0] / 8 % kBlock; held > 0) {
      SHA256Update(&context, at, kBlock - held);
      at += kBlock - held;
      size -= kBlock - held;
    }
    const size_t blocks = size / kBlock;
    compress_sha256(context.state.st32, at, blocks);
    context.bitcount[0] += blocks * kBlock * 8;
    at += blocks * kBlock;
    size -= blocks * kBlock;
  }
  SHA256Update(&context, at, size);
}

}  // namespace

// Numbers come one by one: they are gathered, and taken many at a time.
struct Sha256::State {
  SHA2_CTX context;
  size_t gathered = 0;
  std::array<uint8_t, 32 * kBlock> buffer;

  void flush() {
    take(context, buffer.data(), gathered);
    gathered = 0;
  }
};

Sha256::Sha256() : state_(std::make_unique<State>()) { SHA256Init(&state_->context); }
Sha256::~Sha256() = default;

Sha256& Sha256::bytes(const void* data, size_t size) {
  State& state = *state_;
  if (size > state.buffer.size() - state.gathered) {
    state.flush();
    if (size >= state.buffer.size()) {
      take(state.context, static_cast<const uint8_t*>(data), size);
      return *this;
    }
  }
  if (size > 0) std::memcpy(state.buffer.data() + state.gathered, data, size);
  state.gathered += size;
  return *this;
}

Sha256& Sha256::text(std::string_view s) { return value(s.size()).bytes(s.data(), s.size()); }

std::string Sha256::hex() {
  uint8_t digest[SHA256_DIGEST_LENGTH];
  state_->flush();
  SHA256Final(digest, &state_->context);
  static const char digits[] = "0123456789abcdef";
  std::string out;
  for (const uint8_t byte : digest) {
    out += digits[byte >> 4];
    out += digits[byte & 15];
  }
  return out;
}

std::string sha256_hex(std::string_view bytes) { return Sha256().bytes(bytes.data(), bytes.size()).hex(); }

uint64_t xxh3_64(std::span<const uint8_t> bytes, uint64_t seed) {
  return XXH3_64bits_withSeed(bytes.data(), bytes.size(), seed);
}

}  // namespace crowdbench
