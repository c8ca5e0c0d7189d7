#include "core/png.h"

#include <png.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cassert>
#include <csetjmp>
#include <cstring>
#include <fstream>
#include <vector>

#include "core/error.h"
#include "core/files.h"
#include "core/image_io.h"

// libpng reports errors by longjmp, which runs no destructors. So every libpng call is made inside guarded(), by a
// lambda whose locals are plain data; what needs a destructor lives in the caller.

namespace crowdbench {
namespace {

constexpr size_t kSignatureSize = 8;
// One row of text metadata or one colour profile may take this much; pictures need none of it.
constexpr png_alloc_size_t kChunkMemory = png_alloc_size_t{8} << 20;
// DEFLATE codes at best 258 bytes in 2 bits: a stream never grows to more than this many times its length.
constexpr uint64_t kBestCompression = 1032;
constexpr int kCompressionLevel = 6;

struct Failure {
  std::array<char, 160> text{};
};

[[noreturn]] void on_error(png_structp png, png_const_charp message) {
  auto* failure = static_cast<Failure*>(png_get_error_ptr(png));
  std::strncpy(failure->text.data(), message, failure->text.size() - 1);
  png_longjmp(png, 1);
}

void on_warning(png_structp /*png*/, png_const_charp /*message*/) {}

// False when libpng gave up in `step`; the reason is then in the Failure.
template <typename Step>
bool guarded(png_structp png, const Step& step) {
  if (setjmp(png_jmpbuf(png)) != 0) return false;
  step();
  return true;
}

struct Reader {
  Failure failure;
  png_structp png = nullptr;
  png_infop info = nullptr;
  std::span<const uint8_t> bytes;
  size_t position = 0;

  explicit Reader(std::span<const uint8_t> bytes_) : bytes(bytes_) {
    png = png_create_read_struct(PNG_LIBPNG_VER_STRING, &failure, on_error, on_warning);
    if (png) info = png_create_info_struct(png);
    if (!info) {
      png_destroy_read_struct(&png, nullptr, nullptr);
      throw std::bad_alloc();
    }
  }
  ~Reader() { png_destroy_read_struct(&png, &info, nullptr); }
  Reader(const Reader&) = delete;
  Reader& operator=(const Reader&) = delete;

  static void read(png_structp png, png_bytep out, size_t count) {
    auto* self = static_cast<Reader*>(png_get_io_ptr(png));
    if (count > self->bytes.size() - self->position) png_error(png, "the file ends too early");
    std::memcpy(out, self->bytes.data() + self->position, count);
    self->position += count;
  }
};

struct Writer {
  Failure failure;
  png_structp png = nullptr;
  png_infop info = nullptr;
  std::vector<uint8_t> bytes;

  Writer() {
    png = png_create_write_struct(PNG_LIBPNG_VER_STRING, &failure, on_error, on_warning);
    if (png) info = png_create_info_struct(png);
    if (!info) {
      png_destroy_write_struct(&png, nullptr);
      throw std::bad_alloc();
    }
  }
  ~Writer() { png_destroy_write_struct(&png, &info); }
  Writer(const Writer&) = delete;
  Writer& operator=(const Writer&) = delete;

  static void write(png_structp png, png_bytep data, size_t count) {
    auto* self = static_cast<Writer*>(png_get_io_ptr(png));
    bool full = false;
    try {
      self->bytes.insert(self->bytes.end(), data, data + count);
    } catch (const std::bad_alloc&) {
      full = true;
    }
    if (full) png_error(png, "out of memory");
  }
  static void flush(png_structp /*png*/) {}
};

uint32_t big_endian(std::span<const uint8_t> bytes, size_t at) {
  return uint32_t{bytes[at]} << 24 | uint32_t{bytes[at + 1]} << 16 | uint32_t{bytes[at + 2]} << 8 |
         uint32_t{bytes[at + 3]};
}

// libpng allocates what a chunk claims before it reads it; here every claim is held against the file first.
bool chunks_fit(std::span<const uint8_t> bytes) {
  constexpr size_t kChunkFrame = 12;  // length, type and checksum
  size_t at = kSignatureSize;
  while (bytes.size() - at >= kChunkFrame) {
    const size_t length = big_endian(bytes, at);
    if (length > bytes.size() - at - kChunkFrame) return false;
    if (std::memcmp(bytes.data() + at + 4, "IEND", 4) == 0) return true;
    at += kChunkFrame + length;
  }
  return false;
}

template <typename T>
void read_rows(Reader& reader, const std::string& where, Image<T>& image) {
  std::vector<png_bytep> rows(static_cast<size_t>(image.height));
  for (int y = 0; y < image.height; ++y) rows[static_cast<size_t>(y)] = reinterpret_cast<png_bytep>(image.at(0, y));
  if (!guarded(reader.png, [&] {
        png_read_image(reader.png, rows.data());
        png_read_end(reader.png, nullptr);
      }))
    throw Error(where, fmt::format("damaged PNG ({})", reader.failure.text.data()), "write the file again");
}

int colour_type(int channels) {
  switch (channels) {
    case 1: return PNG_COLOR_TYPE_GRAY;
    case 3: return PNG_COLOR_TYPE_RGB;
    default: return PNG_COLOR_TYPE_RGB_ALPHA;
  }
}

}  // namespace

bool is_png_file(const std::filesystem::path& path) {
  std::array<uint8_t, kSignatureSize> first{};
  std::ifstream file(path, std::ios::binary);
  return file.read(reinterpret_cast<char*>(first.data()), first.size()) && is_png(first);
}

bool is_png(std::span<const uint8_t> bytes) {
  return bytes.size() >= kSignatureSize && png_sig_cmp(bytes.data(), 0, kSignatureSize) == 0;
}

std::variant<Image8, Image16> decode_any_png(std::span<const uint8_t> bytes, const std::string& where) {
  if (!is_png(bytes)) throw Error(where, "is not a PNG picture", "name a PNG file");
  if (!chunks_fit(bytes)) throw Error(where, "damaged PNG (the file ends too early)", "write the file again");
  Reader reader(bytes);
  png_structp png = reader.png;
  png_infop info = reader.info;
  if (!guarded(png, [&] {
        png_set_read_fn(png, &reader, Reader::read);
        // Sides are bounded again below, with a message of our own.
        png_set_user_limits(png, 1 << 24, 1 << 24);
        png_set_chunk_malloc_max(png, kChunkMemory);
        png_set_chunk_cache_max(png, 64);
        png_set_keep_unknown_chunks(png, PNG_HANDLE_CHUNK_NEVER, nullptr, 0);
        png_read_info(png, info);
      }))
    throw Error(where, fmt::format("damaged PNG ({})", reader.failure.text.data()), "write the file again");

  const auto width = static_cast<int64_t>(png_get_image_width(png, info));
  const auto height = static_cast<int64_t>(png_get_image_height(png, info));
  const int depth = png_get_bit_depth(png, info);
  const int type = png_get_color_type(png, info);
  if (width > kMaxImageSide || height > kMaxImageSide || width * height > kMaxImagePixels)
    throw Error(where,
                fmt::format("is {} x {} pixels, more than the limit of {} a side and {} in all", width, height,
                            kMaxImageSide, kMaxImagePixels),
                "use a smaller picture");
  const uint64_t row_bytes = png_get_rowbytes(png, info);
  if (row_bytes * static_cast<uint64_t>(height) / kBestCompression > bytes.size())
    throw Error(where, fmt::format("damaged PNG ({} bytes cannot hold {} x {} pixels)", bytes.size(), width, height),
                "write the file again");

  if (!guarded(png, [&] {
        const bool transparent = png_get_valid(png, info, PNG_INFO_tRNS) != 0;
        const bool grey = (type & PNG_COLOR_MASK_COLOR) == 0;
        if (type == PNG_COLOR_TYPE_PALETTE) png_set_palette_to_rgb(png);
        if (grey && depth < 8) png_set_expand_gray_1_2_4_to_8(png);
        if (transparent) png_set_tRNS_to_alpha(png);
        if (grey && (transparent || (type & PNG_COLOR_MASK_ALPHA) != 0)) png_set_gray_to_rgb(png);
        if (depth == 16 && std::endian::native == std::endian::little) png_set_swap(png);
        png_set_interlace_handling(png);
        png_read_update_info(png, info);
      }))
    throw Error(where, fmt::format("damaged PNG ({})", reader.failure.text.data()), "write the file again");
  const int channels = png_get_channels(png, info);

  if (depth == 16) {
    Image16 image(static_cast<int>(width), static_cast<int>(height), channels);
    assert(png_get_rowbytes(png, info) == image.data.size() * 2 / static_cast<size_t>(height));
    read_rows(reader, where, image);
    return image;
  }
  Image8 image(static_cast<int>(width), static_cast<int>(height), channels);
  assert(png_get_rowbytes(png, info) == image.data.size() / static_cast<size_t>(height));
  read_rows(reader, where, image);
  return image;
}

Image8 decode_png(const std::vector<uint8_t>& bytes, const std::string& where) {
  auto image = decode_any_png(bytes, where);
  if (auto* eight = std::get_if<Image8>(&image)) return std::move(*eight);
  throw Error(where, "is a PNG of 16 bits a sample", "save it with 8 bits");
}

std::vector<uint8_t> encode_png(const Image8& image, const ImageMetadata& metadata) {
  assert(image.width > 0 && image.height > 0);
  assert(image.channels == 1 || image.channels == 3 || image.channels == 4);
  assert(image.data.size() == image.pixels() * static_cast<size_t>(image.channels));
  std::vector<png_text> texts;
  for (const auto& [key, value] : metadata) {
    assert(!key.empty() && key.size() < 80);
    png_text text{};
    // tEXt is Latin-1; text with other letters goes as UTF-8, which is iTXt.
    const bool ascii = std::all_of(value.begin(), value.end(), [](unsigned char c) { return c < 128; });
    text.compression = ascii ? PNG_TEXT_COMPRESSION_NONE : PNG_ITXT_COMPRESSION_NONE;
    text.key = const_cast<char*>(key.c_str());
    text.text = const_cast<char*>(value.c_str());
    if (ascii)
      text.text_length = value.size();
    else
      text.itxt_length = value.size();
    texts.push_back(text);
  }
  std::vector<png_bytep> rows(static_cast<size_t>(image.height));
  for (int y = 0; y < image.height; ++y) rows[static_cast<size_t>(y)] = const_cast<png_bytep>(image.at(0, y));

  Writer writer;
  png_structp png = writer.png;
  if (!guarded(png, [&] {
        png_set_write_fn(png, &writer, Writer::write, Writer::flush);
        png_set_user_limits(png, kMaxImageSide, kMaxImageSide);
        png_set_compression_level(png, kCompressionLevel);
        png_set_filter(png, PNG_FILTER_TYPE_BASE, PNG_FILTER_PAETH);
        png_set_IHDR(png, writer.info, static_cast<png_uint_32>(image.width), static_cast<png_uint_32>(image.height), 8,
                     colour_type(image.channels), PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT,
                     PNG_FILTER_TYPE_DEFAULT);
        png_set_sRGB(png, writer.info, PNG_sRGB_INTENT_PERCEPTUAL);
        png_set_text(png, writer.info, texts.data(), static_cast<int>(texts.size()));
        png_write_info(png, writer.info);
        png_write_image(png, rows.data());
        png_write_end(png, nullptr);
      }))
    throw Error(
        {},
        fmt::format("cannot write a PNG of {} x {} pixels ({})", image.width, image.height, writer.failure.text.data()),
        fmt::format("use at most {} pixels a side", kMaxImageSide));
  return std::move(writer.bytes);
}

void write_png(const std::filesystem::path& path, const Image8& image, const ImageMetadata& metadata) {
  const std::vector<uint8_t> bytes = encode_png(image, metadata);
  write_file(path, bytes.data(), bytes.size());
}

}  // namespace crowdbench
