#include "core/image_io.h"

#include <algorithm>
#include <cassert>
#include <vector>

#include "core/error.h"
#include "core/files.h"
#include "core/module.h"
#include "core/oiio/oiio.h"
#include "core/png.h"

namespace crowdbench {
namespace {

template <typename T>
constexpr oiio::Sample kSampleOf = std::is_same_v<T, float> ? oiio::Sample::kFloat : oiio::Sample::kU32;

// Runs between C functions of the module: nothing may be thrown, so memory that cannot be had is a null.
void* allocate(void* context, const oiio::Header& header) noexcept try {
  auto& image = *static_cast<AnyImage*>(context);
  const auto made = [&]<typename T>(Image<T>&& empty) -> void* {
    image = std::move(empty);
    return std::get<Image<T>>(image).data.data();
  };
  switch (header.sample) {
    case oiio::Sample::kU8: return made(Image8(header.width, header.height, header.channels));
    case oiio::Sample::kU16: return made(Image16(header.width, header.height, header.channels));
    case oiio::Sample::kFloat: return made(ImageF(header.width, header.height, header.channels));
    case oiio::Sample::kU32: return made(ImageU32(header.width, header.height, header.channels));
  }
  return nullptr;
} catch (const std::bad_alloc&) {
  return nullptr;
}

template <typename T>
void write_exr_of(const std::filesystem::path& path, const Image<T>& image, const ImageMetadata& metadata,
                  const std::string& channel_name) {
  assert(image.width > 0 && image.height > 0);
  assert(image.channels == 1 || image.channels == 3 || image.channels == 4);
  assert(image.data.size() == image.pixels() * static_cast<size_t>(image.channels));
  const auto write = reinterpret_cast<oiio::WriteExr>(module_symbol("oiio", oiio::kWriteExr, "writing OpenEXR"));
  std::vector<const char*> keys;
  std::vector<const char*> values;
  for (const auto& [key, value] : metadata) {
    keys.push_back(key.c_str());
    values.push_back(value.c_str());
  }
  const oiio::Header header{image.width, image.height, image.channels, kSampleOf<T>};
  oiio::Fault fault{};
  PendingFile file(path);
  if (write(file.path().c_str(), &header, image.data.data(), channel_name.c_str(), keys.data(), values.data(),
            keys.size(), &fault) != 0)
    throw Error(path.string(), fault.wrong, fault.advice);
  file.commit();
}

}  // namespace

void write_exr(const std::filesystem::path& path, const ImageF& image, const ImageMetadata& metadata,
               const std::string& channel_name) {
  write_exr_of(path, image, metadata, channel_name);
}

void write_exr(const std::filesystem::path& path, const ImageU32& image, const ImageMetadata& metadata,
               const std::string& channel_name) {
  write_exr_of(path, image, metadata, channel_name);
}

AnyImage read_image(const std::filesystem::path& path) {
  // A pipe would block in open(); a folder opens and then fails with an odd reason.
  if (std::error_code error; !std::filesystem::is_regular_file(path, error))
    throw Error(path.string(), std::filesystem::exists(path, error) ? "is not a regular file" : "no such file",
                "name a picture");
  if (is_png_file(path)) {
    const std::vector<uint8_t> bytes = read_file(path);
    return std::visit([](auto&& image) -> AnyImage { return std::forward<decltype(image)>(image); },
                      decode_any_png(bytes, path.string()));
  }
  const auto read =
      reinterpret_cast<oiio::ReadPicture>(module_symbol("oiio", oiio::kReadPicture, "reading pictures other than PNG"));
  const oiio::Limits limits{kMaxImageSide, kMaxImagePixels};
  oiio::Fault fault{};
  AnyImage image;
  if (read(path.c_str(), &limits, allocate, &image, &fault) != 0) throw Error(path.string(), fault.wrong, fault.advice);
  return image;
}

AnyImage read_image(std::span<const uint8_t> bytes, const std::string& extension, const std::string& where,
                    int64_t pixels) {
  const auto read =
      reinterpret_cast<oiio::ReadMemory>(module_symbol("oiio", oiio::kReadMemory, "reading pictures other than PNG"));
  const oiio::Limits limits{kMaxImageSide, std::min(pixels, kMaxImagePixels)};
  oiio::Fault fault{};
  AnyImage image;
  if (read(bytes.data(), bytes.size(), ("picture." + extension).c_str(), &limits, allocate, &image, &fault) != 0)
    throw Error(where, fault.wrong, fault.advice);
  return image;
}

}  // namespace crowdbench
