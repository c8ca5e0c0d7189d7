// The part of a file that a request's Range field asks for (RFC 9110, section 14).
#pragma once
#include <charconv>
#include <cstdint>
#include <optional>
#include <string_view>
#include <system_error>

namespace crowdbench::studies::http {

struct ByteRange {
  uint64_t offset = 0;
  uint64_t length = 0;  // above 0; offset + length is at most the file's
};

// text: "bytes=5-9", "bytes=5-" or "bytes=-3", the last three; an end behind the file's is the file's. Nothing where
// the file has none of it (status 416), where more than one part is asked for (no browser does, and many are many times
// the file), or where it is no such text.
inline std::optional<ByteRange> byte_range(std::string_view text, uint64_t file_bytes) {
  constexpr std::string_view kUnit = "bytes=";
  if (!text.starts_with(kUnit)) return std::nullopt;
  text.remove_prefix(kUnit.size());
  const size_t dash = text.find('-');
  if (dash == std::string_view::npos) return std::nullopt;
  // Of digits alone; UINT64_MAX where there are too many of them for a number.
  const auto number = [](std::string_view digits) -> std::optional<uint64_t> {
    if (digits.empty() || digits.find_first_not_of("0123456789") != std::string_view::npos) return std::nullopt;
    uint64_t value = 0;
    return std::from_chars(digits.data(), digits.data() + digits.size(), value).ec == std::errc() ? value : UINT64_MAX;
  };
  const std::string_view first = text.substr(0, dash);
  const std::string_view last = text.substr(dash + 1);
  if (first.empty()) {
    const std::optional<uint64_t> tail = number(last);
    if (!tail || *tail == 0 || file_bytes == 0) return std::nullopt;
    const uint64_t length = *tail < file_bytes ? *tail : file_bytes;
    return ByteRange{file_bytes - length, length};
  }
  const std::optional<uint64_t> from = number(first);
  const std::optional<uint64_t> to = last.empty() ? std::optional(UINT64_MAX) : number(last);
  if (!from || !to || *to < *from || *from >= file_bytes) return std::nullopt;
  const uint64_t end = *to < file_bytes - 1 ? *to : file_bytes - 1;
  return ByteRange{*from, end - *from + 1};
}

}  // namespace crowdbench::studies::http
