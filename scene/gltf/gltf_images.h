// Pictures inside a glTF asset, decoded within limits. Internal to the loader.
#pragma once
#include <cstdint>
#include <span>
#include <string>

#include "core/image.h"

namespace crowdbench::scene {

enum class PictureFormat : uint8_t { png, jpeg, webp };

struct PictureHeader {
  PictureFormat format = PictureFormat::png;
  int width = 0;
  int height = 0;
  size_t pixels() const { return static_cast<size_t>(width) * static_cast<size_t>(height); }
};

// The size that the encoded bytes claim, read without decoding. where: for the message. Throws Error when the bytes are
// neither PNG, JPEG nor WebP, or do not say the size.
PictureHeader picture_header(std::span<const uint8_t> bytes, const std::string& where);

// RGBA, sRGB-encoded, of exactly the size that the header claims. 16-bit channels are cut to 8, palettes and grey
// expanded; a picture without alpha is opaque. Throws Error on broken data.
Image8 decode_picture(std::span<const uint8_t> bytes, const PictureHeader& header, const std::string& where);

}  // namespace crowdbench::scene
