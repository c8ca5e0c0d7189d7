// What a picture file says of the colours of its values.
#pragma once
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>

namespace crowdbench {

// Of a PNG, by the precedence of its specification (third edition, 4.3): "cICP 9/16/0/1", "iCCP profile 'Display P3'
// 1f2e..", "gAMA 1, cHRM ...", with the first bytes of a hash that tells profiles of one name apart. Empty where the
// file says sRGB, says nothing, or is no PNG. Safe on hostile bytes: a chunk that is cut ends the search.
std::string colour_tags(std::span<const uint8_t> bytes);
// Throws Error when a PNG cannot be read; empty where there is no file.
std::string colour_tags(const std::filesystem::path& path);

}  // namespace crowdbench
