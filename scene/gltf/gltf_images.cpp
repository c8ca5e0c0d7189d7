// PNG through libpng row by row (no second copy of a large picture), JPEG through tinygltf's decoder, WebP through
// OpenImageIO. Based on: ISO/IEC 15948 (PNG, the IHDR chunk); ITU-T T.81 (JPEG, markers and the frame header); RFC 9649
// (WebP, its three headers).
#include "scene/gltf/gltf_images.h"

#include <png.h>
#include <tiny_gltf.h>

#include <algorithm>
#include <array>
#include <cstring>

#include "core/error.h"
#include "core/image_io.h"

namespace crowdbench::scene {
namespace {

constexpr std::array<uint8_t, 8> kPngMagic = {0x89, 'P', 'N', 'G', '\r', '\n', 0x1A, '\n'};

uint32_t big_endian(std::span<const uint8_t> bytes, size_t at, size_t size) {
  uint32_t value = 0;
  for (size_t i = 0; i < size; ++i) value = value << 8 | bytes[at + i];
  return value;
}

bool starts_with(std::span<const uint8_t> bytes, std::string_view magic, size_t at = 0) {
  return bytes.size() >= at + magic.size() && std::memcmp(bytes.data() + at, magic.data(), magic.size()) == 0;
}

PictureHeader sized(PictureFormat format, uint32_t width, uint32_t height, const std::string& where) {
  if (width == 0 || height == 0 || width > 65535 || height > 65535)
    throw Error(where, fmt::format("picture claims to be {} x {}", width, height),
                "the picture is damaged; save it anew");
  return {format, static_cast<int>(width), static_cast<int>(height)};
}

PictureHeader jpeg_header(std::span<const uint8_t> bytes, const std::string& where) {
  size_t at = 2;
  while (at + 4 <= bytes.size()) {
    if (bytes[at] != 0xFF) break;
    const uint8_t marker = bytes[at + 1];
    if (marker == 0xFF) {  // fill byte
      ++at;
      continue;
    }
    if (marker == 0x01 || (marker >= 0xD0 && marker <= 0xD8)) {  // markers without a length
      at += 2;
      continue;
    }
    const bool frame = marker >= 0xC0 && marker <= 0xCF && marker != 0xC4 && marker != 0xC8 && marker != 0xCC;
    if (frame && at + 9 <= bytes.size())
      return sized(PictureFormat::jpeg, big_endian(bytes, at + 7, 2), big_endian(bytes, at + 5, 2), where);
    const uint32_t length = big_endian(bytes, at + 2, 2);
    if (length < 2 || marker == 0xD9 || marker == 0xDA) break;
    at += 2 + length;
  }
  throw Error(where, "JPEG has no frame header", "the picture is truncated or damaged");
}

uint32_t little_endian(std::span<const uint8_t> bytes, size_t at, size_t size) {
  uint32_t value = 0;
  for (size_t i = size; i-- > 0;) value = value << 8 | bytes[at + i];
  return value;
}

PictureHeader webp_header(std::span<const uint8_t> bytes, const std::string& where) {
  if (bytes.size() >= 30 && starts_with(bytes, "VP8X", 12))
    return sized(PictureFormat::webp, little_endian(bytes, 24, 3) + 1, little_endian(bytes, 27, 3) + 1, where);
  if (bytes.size() >= 25 && starts_with(bytes, "VP8L", 12)) {
    const uint32_t sides = little_endian(bytes, 21, 4);
    return sized(PictureFormat::webp, (sides & 0x3FFF) + 1, (sides >> 14 & 0x3FFF) + 1, where);
  }
  if (bytes.size() >= 30 && starts_with(bytes, "VP8 ", 12))
    return sized(PictureFormat::webp, little_endian(bytes, 26, 2) & 0x3FFF, little_endian(bytes, 28, 2) & 0x3FFF,
                 where);
  throw Error(where, "WebP has no header", "the picture is truncated or damaged");
}

Image8 decode_webp_rgba(std::span<const uint8_t> bytes, const PictureHeader& header, const std::string& where) {
  AnyImage any = read_image(bytes, "webp", where, static_cast<int64_t>(header.pixels()));
  auto* decoded = std::get_if<Image8>(&any);
  if (!decoded || decoded->width != header.width || decoded->height != header.height || decoded->channels < 3)
    throw Error(where, "WebP does not decode", "the picture is damaged; save it as PNG");
  if (decoded->channels == 4) return std::move(*decoded);
  Image8 image(header.width, header.height, 4);
  for (size_t i = 0; i < image.pixels(); ++i) {
    std::copy_n(&decoded->data[3 * i], 3, &image.data[4 * i]);
    image.data[4 * i + 3] = 255;
  }
  return image;
}

struct PngInput {
  std::span<const uint8_t> bytes;
  size_t at = 0;
};

void read_png_bytes(png_structp png, png_bytep out, size_t size) {
  auto* input = static_cast<PngInput*>(png_get_io_ptr(png));
  if (size > input->bytes.size() - input->at) png_error(png, "ends too early");
  std::memcpy(out, input->bytes.data() + input->at, size);
  input->at += size;
}

struct PngMessage {
  std::array<char, 128> text{};
};

[[noreturn]] void png_failed(png_structp png, png_const_charp text) {
  auto* message = static_cast<PngMessage*>(png_get_error_ptr(png));
  std::strncpy(message->text.data(), text, message->text.size() - 1);
  png_longjmp(png, 1);
}

void png_warned(png_structp /*png*/, png_const_charp /*text*/) {}

// Everything with a destructor lives in the caller: libpng leaves by longjmp.
bool read_png(png_structp png, png_infop info, PngInput& input, Image8& image, std::vector<png_bytep>& rows) {
  if (setjmp(png_jmpbuf(png))) return false;  // NOLINT(cert-err52-cpp): this is how libpng reports errors
  png_set_read_fn(png, &input, read_png_bytes);
  png_set_chunk_malloc_max(png, 8U << 20);  // ancillary chunks are of no use here
  png_set_chunk_cache_max(png, 16);
  png_read_info(png, info);
  if (png_get_image_width(png, info) != static_cast<png_uint_32>(image.width) ||
      png_get_image_height(png, info) != static_cast<png_uint_32>(image.height))
    png_error(png, "two sizes");
  png_set_scale_16(png);
  png_set_expand(png);
  png_set_gray_to_rgb(png);
  png_set_add_alpha(png, 0xFF, PNG_FILLER_AFTER);
  png_set_interlace_handling(png);
  png_read_update_info(png, info);
  if (png_get_rowbytes(png, info) != static_cast<size_t>(image.width) * 4) png_error(png, "unexpected row size");
  png_read_image(png, rows.data());
  return true;
}

Image8 decode_png_rgba(std::span<const uint8_t> bytes, const PictureHeader& header, const std::string& where) {
  Image8 image(header.width, header.height, 4);
  std::vector<png_bytep> rows(static_cast<size_t>(header.height));
  for (int y = 0; y < header.height; ++y) rows[static_cast<size_t>(y)] = image.at(0, y);
  PngMessage message;
  PngInput input{bytes};
  png_structp png = png_create_read_struct(PNG_LIBPNG_VER_STRING, &message, png_failed, png_warned);
  png_infop info = png ? png_create_info_struct(png) : nullptr;
  const bool fine = info && read_png(png, info, input, image, rows);
  png_destroy_read_struct(&png, &info, nullptr);
  if (!fine)
    throw Error(where, "PNG does not decode: " + printable(message.text.data(), 100),
                "the picture is truncated or damaged");
  return image;
}

Image8 decode_jpeg_rgba(std::span<const uint8_t> bytes, const PictureHeader& header, const std::string& where) {
  tinygltf::Image decoded;
  std::string error;
  std::string warning;
  const bool fine = tinygltf::LoadImageData(&decoded, 0, &error, &warning, header.width, header.height, bytes.data(),
                                            static_cast<int>(bytes.size()), nullptr);
  Image8 image;
  image.width = header.width;
  image.height = header.height;
  image.channels = 4;
  if (!fine || decoded.width != header.width || decoded.height != header.height || decoded.component != 4 ||
      decoded.bits != 8 || decoded.image.size() != header.pixels() * 4)
    throw Error(where, "JPEG does not decode", "the picture is truncated, damaged or of a rare kind; save it as PNG");
  image.data = std::move(decoded.image);
  return image;
}

}  // namespace

PictureHeader picture_header(std::span<const uint8_t> bytes, const std::string& where) {
  if (bytes.size() >= kPngMagic.size() && std::equal(kPngMagic.begin(), kPngMagic.end(), bytes.begin())) {
    if (bytes.size() < 24 || !starts_with(bytes, "IHDR", 12))
      throw Error(where, "PNG has no header", "export the texture again: the file is damaged");
    return sized(PictureFormat::png, big_endian(bytes, 16, 4), big_endian(bytes, 20, 4), where);
  }
  if (starts_with(bytes, "\xFF\xD8\xFF")) return jpeg_header(bytes, where);
  if (starts_with(bytes, "RIFF") && starts_with(bytes, "WEBP", 8)) return webp_header(bytes, where);
  std::string kind = "neither PNG nor JPEG nor WebP";
  if (starts_with(bytes, "KTX 20", 1)) kind = "KTX2, which is not supported";
  if (starts_with(bytes, "GIF8")) kind = "GIF, which glTF does not allow";
  throw Error(where, "picture is " + kind, "save the textures as PNG, JPEG or WebP");
}

Image8 decode_picture(std::span<const uint8_t> bytes, const PictureHeader& header, const std::string& where) {
  switch (header.format) {
    case PictureFormat::jpeg: return decode_jpeg_rgba(bytes, header, where);
    case PictureFormat::webp: return decode_webp_rgba(bytes, header, where);
    case PictureFormat::png: break;
  }
  return decode_png_rgba(bytes, header, where);
}

}  // namespace crowdbench::scene
