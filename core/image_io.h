// Pictures on disk. PNG goes through libpng, here; every other format goes through OpenImageIO, loaded at first use.
#pragma once
#include <filesystem>
#include <map>
#include <span>
#include <string>
#include <variant>

#include "core/image.h"

namespace crowdbench {

// Key and value text stored in the file (PNG tEXt, EXR attributes): scenario, seed, backend, version. Nothing of time,
// machine, driver or thread count belongs here: the same scenario must give the same bytes.
using ImageMetadata = std::map<std::string, std::string>;

// 1 (grey), 3 (RGB) or 4 (RGBA, straight alpha) channels, sRGB-encoded. Fixed filter and compression level: same pixels
// and metadata, same bytes. Throws Error.
void write_png(const std::filesystem::path& path, const Image8& image, const ImageMetadata& metadata = {});
// The same, into memory (for data URIs).
std::vector<uint8_t> encode_png(const Image8& image, const ImageMetadata& metadata = {});
// 8-bit PNG from memory, sample values as stored: no gamma or profile is applied. A palette becomes RGB, fewer bits
// become 8, grey stays 1 channel, grey with transparency becomes RGBA; 16-bit is refused. `where` names the source in
// errors. Safe on hostile bytes. Throws Error.
Image8 decode_png(const std::vector<uint8_t>& bytes, const std::string& where);

// OpenEXR through OpenImageIO: float channels as 32-bit float, ids as 32-bit unsigned, ZIP. 3 and 4 channels are named
// R, G, B, A; the only channel of a picture of one is named `channel_name` (other programs know depth by "Z"). Same
// pixels and metadata, same bytes. Throws Error.
void write_exr(const std::filesystem::path& path, const ImageF& image, const ImageMetadata& metadata = {},
               const std::string& channel_name = "Z");
void write_exr(const std::filesystem::path& path, const ImageU32& image, const ImageMetadata& metadata = {},
               const std::string& channel_name = "id");

// Any picture file: 8-bit as Image8, 16-bit as Image16 (0..65535), float and half as ImageF, 32-bit unsigned as
// ImageU32; 1, 3 or 4 channels (grey with alpha is widened to RGBA), alpha straight in integer formats and as stored
// (associated) in float ones. Sample values as stored. Limits: 16384 a side, 2^27 pixels, 4 channels. Throws Error.
using AnyImage = std::variant<Image8, Image16, ImageF, ImageU32>;
AnyImage read_image(const std::filesystem::path& path);
// The same from memory. extension: of the format ("webp"); where: the source, for errors; pixels: the most.
AnyImage read_image(std::span<const uint8_t> bytes, const std::string& extension, const std::string& where,
                    int64_t pixels);

}  // namespace crowdbench
