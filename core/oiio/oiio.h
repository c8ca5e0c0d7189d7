// The C interface of the module crowdbench_oiio: plain memory and text cross it, never an exception or a C++ object.
#pragma once
#include <cstddef>
#include <cstdint>

namespace crowdbench::oiio {

enum class Sample : int32_t { kU8, kU16, kFloat, kU32 };

constexpr size_t sample_size(Sample sample) { return sample == Sample::kU8 ? 1 : sample == Sample::kU16 ? 2 : 4; }

// What went wrong and what to do, as in Error; both end in 0.
struct Fault {
  char wrong[512];
  char advice[128];
};

struct Limits {
  int32_t side;
  int64_t pixels;
};

struct Header {
  int32_t width;
  int32_t height;
  int32_t channels;  // 1, 3 or 4
  Sample sample;
};

// Called once between header and pixels: returns memory for width * height * channels samples, which stays the
// caller's, or null to stop.
using Allocate = void* (*)(void* context, const Header& header);

// All return 0, or 1 with *fault filled.
using ReadPicture = int (*)(const char* path, const Limits* limits, Allocate allocate, void* context, Fault* fault);
inline constexpr const char* kReadPicture = "crowdbench_oiio_read";

// The same of bytes in memory; name: its extension says the format.
using ReadMemory = int (*)(const void* bytes, size_t size, const char* name, const Limits* limits, Allocate allocate,
                           void* context, Fault* fault);
inline constexpr const char* kReadMemory = "crowdbench_oiio_read_memory";

// channel_name: of a one-channel picture; others are R, G, B, A. keys and values: `count` pairs of text attributes.
using WriteExr = int (*)(const char* path, const Header* header, const void* samples, const char* channel_name,
                         const char* const* keys, const char* const* values, size_t count, Fault* fault);
inline constexpr const char* kWriteExr = "crowdbench_oiio_write_exr";

}  // namespace crowdbench::oiio
