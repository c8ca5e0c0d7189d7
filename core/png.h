// PNG through libpng, for core/image_io.cpp: nothing else reads or writes the bytes of a PNG.
#pragma once
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <variant>

#include "core/image.h"

namespace crowdbench {

// The largest side and the largest number of pixels of any picture that is read.
constexpr int kMaxImageSide = 16384;
constexpr int64_t kMaxImagePixels = int64_t{1} << 27;

bool is_png(std::span<const uint8_t> bytes);
// By its first bytes alone; false where there is no such file.
bool is_png_file(const std::filesystem::path& path);

// 1 to 8 bits a sample as Image8, 16 as Image16, as read_image() describes them. The sample values are those in the
// file: no gamma, no colour profile, no premultiplication is applied. Safe on hostile bytes: side, pixel count and
// memory are bounded, and a file that is too small to hold the pixels it claims is refused before they are allocated.
// Throws Error.
std::variant<Image8, Image16> decode_any_png(std::span<const uint8_t> bytes, const std::string& where);

}  // namespace crowdbench
