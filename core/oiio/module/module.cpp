// The module crowdbench_oiio: everything that touches OpenImageIO. It takes a fifth of a second to load, and a bundle
// may lack it.
#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>
#include <dlfcn.h>

#include <algorithm>
#include <exception>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "core/oiio/oiio.h"

namespace crowdbench::oiio {
namespace {

struct Refusal {
  std::string wrong;
  std::string advice;
};

template <size_t N>
void copy_text(char (&out)[N], const std::string& text) {
  out[text.copy(out, N - 1)] = '\0';
}

// OpenImageIO's messages can have several lines; the first says it.
std::string first_line(const std::string& text) { return text.substr(0, text.find('\n')); }

template <typename Work>
int reported(Fault* fault, const Work& work) {
  Refusal refusal;
  try {
    work();
    return 0;
  } catch (const Refusal& r) {
    refusal = r;
  } catch (const std::bad_alloc&) {
    refusal = {"does not fit into memory", "use a smaller picture"};
  } catch (const std::exception& e) {
    refusal = {std::string("cannot be handled by OpenImageIO (") + first_line(e.what()) + ")", ""};
  } catch (...) {
    refusal = {"cannot be handled by OpenImageIO", ""};
  }
  copy_text(fault->wrong, refusal.wrong);
  copy_text(fault->advice, refusal.advice);
  return 1;
}

void set_up_library() {
  static const bool once = [] {
    // The order in which threads finish must not reach a file, and pictures here are small.
    OIIO::attribute("threads", 1);
    OIIO::attribute("exr_threads", -1);
    OIIO::attribute("debug", 0);  // else it tells stderr about attributes that a format cannot hold
    return true;
  }();
  static_cast<void>(once);
}

Sample sample_of(const OIIO::ImageSpec& spec) {
  const OIIO::TypeDesc first = spec.channelformat(0);  // of colour, where others are stored otherwise
  switch (first.basetype) {
    case OIIO::TypeDesc::UINT8: return Sample::kU8;
    case OIIO::TypeDesc::UINT16: return Sample::kU16;
    case OIIO::TypeDesc::HALF:
    case OIIO::TypeDesc::FLOAT:
    case OIIO::TypeDesc::DOUBLE: return Sample::kFloat;
    case OIIO::TypeDesc::UINT32: return Sample::kU32;
    default:
      throw Refusal{std::string("has samples of type ") + first.c_str(),
                    "save it with 8 or 16 bits, float or 32-bit unsigned"};
  }
}

OIIO::TypeDesc type_of(Sample sample) {
  switch (sample) {
    case Sample::kU8: return OIIO::TypeDesc::UINT8;
    case Sample::kU16: return OIIO::TypeDesc::UINT16;
    case Sample::kFloat: return OIIO::TypeDesc::FLOAT;
    default: return OIIO::TypeDesc::UINT32;
  }
}

std::string names_of(const OIIO::ImageSpec& spec) {
  constexpr size_t kMost = 6;
  std::string names;
  for (size_t i = 0; i < std::min(kMost, spec.channelnames.size()); ++i)
    names += (names.empty() ? "" : ", ") + spec.channelnames[i];
  return names + (spec.channelnames.size() > kMost ? ", ..." : "");
}

// How many of the file's channels are the picture: those of colour and alpha, which the library puts first. An EXR may
// hold depths, normals and other layers beside them.
int channels_of(const OIIO::ImageSpec& spec) {
  const auto named = [&](size_t i, std::string_view name) {
    return i < spec.channelnames.size() && spec.channelnames[i] == name;
  };
  if (spec.nchannels > 3 && named(0, "R") && named(1, "G") && named(2, "B")) return named(3, "A") ? 4 : 3;
  if (spec.nchannels < 1 || spec.nchannels > 4 || (spec.nchannels == 2 && spec.alpha_channel != 1))
    throw Refusal{"has " + std::to_string(spec.nchannels) + " channels: " + names_of(spec),
                  "save 1 (grey), grey with alpha (A), 3 (RGB) or 4 (RGBA); layers beside R, G, B are left out"};
  return spec.nchannels;
}

void check(const OIIO::ImageSpec& spec, const Limits& limits) {
  if (spec.deep) throw Refusal{"is a deep picture", "flatten it first"};
  if (spec.depth > 1) throw Refusal{"is a volume", "name a picture of one layer"};
  if (spec.width < 1 || spec.height < 1) throw Refusal{"has no pixels", "write the file again"};
  if (spec.width > limits.side || spec.height > limits.side ||
      static_cast<int64_t>(spec.width) * spec.height > limits.pixels)
    throw Refusal{"is " + std::to_string(spec.width) + " x " + std::to_string(spec.height) +
                      " pixels, more than the limit of " + std::to_string(limits.side) + " a side and " +
                      std::to_string(limits.pixels) + " in all",
                  "use a smaller picture"};
  if (spec.x != spec.full_x || spec.y != spec.full_y || spec.width != spec.full_width ||
      spec.height != spec.full_height)
    throw Refusal{"has a data window that differs from its display window", "save it cropped or padded to the display"};
}

// OpenImageIO's WebP reader multiplies colours by alpha whatever it is asked for, so that those of clear texels are
// lost, and with them what filters take from the texels beside an outline. The library that it reads with gives them as
// they are (https://developers.google.com/speed/webp/docs/api). False where that is not loaded or takes the file for no
// still picture of this size: then nothing is written. out: RGBA, 8 bits.
bool read_straight_webp(OIIO::Filesystem::IOProxy& bytes, const OIIO::ImageSpec& spec, unsigned char* out) {
  using Decode = uint8_t* (*)(const uint8_t*, size_t, uint8_t*, size_t, int);
  using Info = int (*)(const uint8_t*, size_t, int*, int*);
  void* library = dlopen("libwebp.so.7", RTLD_NOW | RTLD_NOLOAD);
  if (!library) return false;
  const auto decode = reinterpret_cast<Decode>(dlsym(library, "WebPDecodeRGBAInto"));
  const auto info = reinterpret_cast<Info>(dlsym(library, "WebPGetInfo"));
  dlclose(library);  // OpenImageIO holds it
  if (!decode || !info) return false;
  std::vector<uint8_t> data(bytes.size());
  if (bytes.pread(data.data(), data.size(), 0) != data.size()) return false;
  int width = 0;
  int height = 0;
  if (!info(data.data(), data.size(), &width, &height) || width != spec.width || height != spec.height) return false;
  constexpr size_t kPixel = 4;
  const size_t row = kPixel * static_cast<size_t>(width);
  return decode(data.data(), data.size(), out, row * static_cast<size_t>(height), static_cast<int>(row)) != nullptr;
}

// memory: where the bytes are; null: in the file.
void read(const char* path, OIIO::Filesystem::IOProxy* memory, const Limits& limits, Allocate allocate, void* context) {
  set_up_library();
  OIIO::ImageSpec wish;
  // Straight alpha, as the file has it: multiplying and dividing 8-bit values would lose some of them.
  wish.attribute("oiio:UnassociatedAlpha", 1);
  // The WebP reader looks for it here alone.
  if (memory) wish.attribute("oiio:ioproxy", OIIO::TypeDesc::PTR, &memory);
  const auto input = OIIO::ImageInput::open(path, &wish, memory);
  if (!input) {
    const std::string why = first_line(OIIO::geterror());
    throw Refusal{"cannot be read as a picture" + (why.empty() ? "" : " (" + why + ")"),
                  "name a PNG, EXR, TIFF, JPEG or other picture"};
  }
  const OIIO::ImageSpec& spec = input->spec();
  check(spec, limits);
  const int channels = channels_of(spec);
  const bool widen = channels == 2;
  const Header header{spec.width, spec.height, widen ? 4 : channels, sample_of(spec)};
  auto* samples = static_cast<unsigned char*>(allocate(context, header));
  if (!samples) throw std::bad_alloc();
  const size_t size = sample_size(header.sample);
  const auto pixel_stride = static_cast<OIIO::stride_t>(size * static_cast<size_t>(header.channels));
  constexpr int kWithAlpha = 4;
  if (std::string_view(input->format_name()) == "webp" && channels == kWithAlpha && header.sample == Sample::kU8) {
    OIIO::Filesystem::IOProxy* bytes = memory;
    std::unique_ptr<OIIO::Filesystem::IOFile> opened;
    if (!bytes)
      bytes = (opened = std::make_unique<OIIO::Filesystem::IOFile>(path, OIIO::Filesystem::IOProxy::Read)).get();
    if (read_straight_webp(*bytes, spec, samples)) return;
  }
  if (!input->read_image(0, 0, 0, channels, type_of(header.sample), samples, pixel_stride))
    throw Refusal{"is damaged (" + first_line(input->geterror()) + ")", "write the file again"};
  if (!widen) return;
  const size_t pixels = static_cast<size_t>(spec.width) * static_cast<size_t>(spec.height);
  for (size_t i = 0; i < pixels; ++i) {  // grey, alpha, -, -  ->  grey, grey, grey, alpha
    unsigned char* pixel = samples + i * 4 * size;
    std::copy_n(pixel + size, size, pixel + 3 * size);
    std::copy_n(pixel, size, pixel + size);
    std::copy_n(pixel, size, pixel + 2 * size);
  }
}

void write_exr(const char* path, const Header& header, const void* samples, const char* channel_name,
               const char* const* keys, const char* const* values, size_t count) {
  set_up_library();
  const auto output = OIIO::ImageOutput::create("openexr");
  if (!output)
    throw Refusal{"cannot be written: this OpenImageIO has no OpenEXR (" + first_line(OIIO::geterror()) + ")", ""};
  OIIO::ImageSpec spec(header.width, header.height, header.channels, type_of(header.sample));
  if (header.channels == 1) spec.channelnames = {channel_name};
  spec.attribute("compression", "zip");
  for (size_t i = 0; i < count; ++i) spec.attribute(keys[i], values[i]);
  // Without a DateTime the EXR writer stores the hour of writing. One that is no text is kept and then left out.
  spec.attribute("DateTime", 0);
  if (!output->open(path, spec) || !output->write_image(type_of(header.sample), samples) || !output->close())
    throw Refusal{"cannot be written (" + first_line(output->geterror()) + ")", "check the disk"};
}

}  // namespace
}  // namespace crowdbench::oiio

using namespace crowdbench::oiio;

extern "C" __attribute__((visibility("default"))) int crowdbench_oiio_read(const char* path, const Limits* limits,
                                                                           Allocate allocate, void* context,
                                                                           Fault* fault) {
  return reported(fault, [&] { read(path, nullptr, *limits, allocate, context); });
}

extern "C" __attribute__((visibility("default"))) int crowdbench_oiio_read_memory(const void* bytes, size_t size,
                                                                                  const char* name,
                                                                                  const Limits* limits,
                                                                                  Allocate allocate, void* context,
                                                                                  Fault* fault) {
  return reported(fault, [&] {
    OIIO::Filesystem::IOMemReader memory(const_cast<void*>(bytes), size);
    read(name, &memory, *limits, allocate, context);
  });
}

extern "C" __attribute__((visibility("default"))) int crowdbench_oiio_write_exr(
    const char* path, const Header* header, const void* samples, const char* channel_name, const char* const* keys,
    const char* const* values, size_t count, Fault* fault) {
  return reported(fault, [&] { write_exr(path, *header, samples, channel_name, keys, values, count); });
}
