// The interface of crowdbench_video.so, which brings FFmpeg's libraries: plain functions and structs, so that nothing
// of FFmpeg reaches a header of this project and nothing of C++ crosses the border. studies/stimuli/clip.h is what to
// use.
#pragma once
#include <cstdint>

namespace crowdbench::studies::video {

inline constexpr uint32_t kApiVersion = 4;
inline constexpr int kMessageBytes = 512;

enum class Codec : int32_t {
  h264_444 = 0,       // libx264, yuv444p, BT.709 limited range, constant rate factor
  h264_420 = 1,       // libx264, yuv420p, BT.709 limited range, constant rate factor
  h264_lossless = 2,  // libx264rgb, rgb24, qp 0: the decoded bytes are the bytes put in
  vp9_444 = 3,        // libvpx-vp9, yuv444p, BT.709 limited range, constant quality, in WebM
};

struct Settings {
  int32_t width = 0;   // pixels
  int32_t height = 0;  // pixels
  int32_t fps = 30;    // frames a second, constant
  Codec codec = Codec::h264_444;
  int32_t crf = 12;               // 0 (finest) .. 51 (VP9: 63); not used by h264_lossless
  const char* preset = "medium";  // x264's; VP9: its cpu-used
  int32_t threads = 2;            // fixed: the decoded video depends on it
  const char* title = nullptr;    // container metadata; may be null
};

// What a file says about itself. Names are FFmpeg's ("yuv444p", "bt709", "tv"); empty when the file does not say.
struct Info {
  int32_t width = 0;
  int32_t height = 0;
  int32_t fps_numerator = 0;
  int32_t fps_denominator = 1;
  int64_t frames = 0;       // as the container says or its duration lets expect; 0: unknown
  int64_t duration_us = 0;  // microseconds, as the container says of the video, else of all; 0: unknown
  char codec[32] = {};
  char pixel_format[32] = {};
  char primaries[32] = {};
  char transfer[32] = {};
  char matrix[32] = {};
  char range[32] = {};
  char title[256] = {};
};

// One decoded frame's place in time: pts * time_base seconds.
struct FrameInfo {
  int64_t pts = 0;
  int32_t time_base_numerator = 0;
  int32_t time_base_denominator = 1;
  int32_t key = 0;
};

struct Encoder;
struct Decoder;

// Every failure leaves a one-line reason in `message` (kMessageBytes long). Frames are packed RGB24, rows top to
// bottom.
struct Api {
  uint32_t version;
  // Creates `path` (mp4, index in front; WebM for VP9). Null on failure.
  Encoder* (*open_encoder)(const char* path, const Settings* settings, char* message);
  bool (*encode)(Encoder* encoder, const uint8_t* rgb, char* message);
  bool (*finish)(Encoder* encoder, char* message);  // flushes and closes the file; the encoder must still be freed
  void (*free_encoder)(Encoder* encoder);
  // Null on failure.
  Decoder* (*open_decoder)(const char* path, Info* info, char* message);
  // Writes width * height * 3 bytes. 1: a frame; 0: the end; -1: failed.
  int32_t (*decode)(Decoder* decoder, uint8_t* rgb, FrameInfo* info, char* message);
  void (*free_decoder)(Decoder* decoder);
};

inline constexpr char kApiSymbol[] = "crowdbench_video_api";
using ApiFunction = const Api* (*)();

}  // namespace crowdbench::studies::video
