#include "core/colour_tags.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <map>
#include <string_view>
#include <vector>

#include "core/error.h"
#include "core/files.h"
#include "core/hash.h"
#include "core/png.h"

namespace crowdbench {
namespace {

using Bytes = std::span<const uint8_t>;

uint32_t big_endian(Bytes bytes, size_t at) {
  return uint32_t{bytes[at]} << 24U | uint32_t{bytes[at + 1]} << 16U | uint32_t{bytes[at + 2]} << 8U | bytes[at + 3];
}

// The chunks that stand before the pixels: the colours of what follows must be said before it.
std::map<std::string_view, Bytes> chunks_before_pixels(Bytes bytes) {
  std::map<std::string_view, Bytes> chunks;
  constexpr size_t kSignature = 8;
  constexpr size_t kAround = 12;  // length, type and checksum
  size_t at = kSignature;
  while (at + kAround <= bytes.size()) {
    const size_t length = big_endian(bytes, at);
    const std::string_view type(reinterpret_cast<const char*>(bytes.data()) + at + 4, 4);
    if (type == "IDAT" || length > bytes.size() - at - kAround) break;
    chunks.emplace(type, bytes.subspan(at + 8, length));
    at += kAround + length;
  }
  return chunks;
}

std::string profile_text(Bytes chunk) {
  const auto end = std::find(chunk.begin(), chunk.end(), uint8_t{0});
  const std::string hash = sha256_hex(std::string_view(reinterpret_cast<const char*>(chunk.data()), chunk.size()));
  return fmt::format("iCCP profile '{}' {}", printable(std::string(chunk.begin(), end), 79), hash.substr(0, 8));
}

// In hundred-thousandths, as gAMA and cHRM store them: sRGB's gamma and primaries.
constexpr uint32_t kGamma = 45455;
constexpr std::array<uint32_t, 8> kPrimaries = {31270, 32900, 64000, 33000, 30000, 60000, 15000, 6000};

std::string gamma_and_primaries(const std::map<std::string_view, Bytes>& chunks) {
  std::vector<std::string> said;
  if (const auto gamma = chunks.find("gAMA"); gamma != chunks.end() && gamma->second.size() == 4) {
    const uint32_t value = big_endian(gamma->second, 0);
    if (value != kGamma) said.push_back(fmt::format("gAMA {:g}", value / 1e5));
  }
  if (const auto primaries = chunks.find("cHRM"); primaries != chunks.end() && primaries->second.size() == 32) {
    std::array<double, 8> values{};
    bool same = true;
    for (size_t i = 0; i < values.size(); ++i) {
      const uint32_t value = big_endian(primaries->second, 4 * i);
      same = same && value == kPrimaries[i];
      values[i] = value / 1e5;
    }
    if (!same) said.push_back(fmt::format("cHRM {:g}", fmt::join(values, " ")));
  }
  return fmt::format("{}", fmt::join(said, ", "));
}

}  // namespace

std::string colour_tags(std::span<const uint8_t> bytes) {
  if (!is_png(bytes)) return {};
  const auto chunks = chunks_before_pixels(bytes);
  if (const auto c = chunks.find("cICP"); c != chunks.end() && c->second.size() == 4) {
    constexpr std::array<uint8_t, 4> kSrgb = {1, 13, 0, 1};
    if (std::equal(kSrgb.begin(), kSrgb.end(), c->second.begin())) return {};
    return fmt::format("cICP {}/{}/{}/{}", c->second[0], c->second[1], c->second[2], c->second[3]);
  }
  if (const auto profile = chunks.find("iCCP"); profile != chunks.end()) return profile_text(profile->second);
  if (chunks.count("sRGB") != 0) return {};
  return gamma_and_primaries(chunks);
}

std::string colour_tags(const std::filesystem::path& path) {
  // Only a PNG is read whole: pictures of floats are large, and say nothing that is understood here.
  return is_png_file(path) ? colour_tags(read_file(path)) : std::string();
}

}  // namespace crowdbench
