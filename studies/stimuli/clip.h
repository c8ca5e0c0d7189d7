// Clips: RGB frames in, a video file out that plays in a browser at a constant rate, proven against the raw frames.
//
// The file to show is H.264 4:4:4 (yuv444p, BT.709, limited range) in mp4, key frame every second, index in front;
// beside it, where asked, VP9 4:4:4 in WebM, for browsers that refuse it (Safari, and Firefox on some systems). With
// chroma at half size (4:2:0) the error at the outline of a small saturated figure reaches 142 of 255, more than what a
// study of crowd representations looks for; such a copy exists only for players that need it, and says so in its name
// and its title. FFmpeg's libraries come as a module, loaded at first use: every function here throws Error when it is
// absent.
#pragma once
#include <array>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/files.h"
#include "core/image.h"
#include "core/json.h"

namespace crowdbench::studies {

// What else the decoded frames of a study file must hold to, beside their decibels. Both are called for each encoding
// that is tried: `frame` with every frame in order, then `missing_db`.
struct ClipCheck {
  std::function<void(size_t frame, const std::vector<uint8_t>& raw, const std::vector<uint8_t>& decoded)> frame;
  // By how many decibels the encoding is too coarse; 0 or less: fine. The next one begins from nothing.
  std::function<double()> missing_db;
};

struct ClipSettings {
  int fps = 30;            // constant
  int crf = 12;            // x264's constant rate factor where the search starts, 0 (finest) .. 51
  double least_psnr = 40;  // dB that the worst frame must reach after decoding
  bool compat = false;     // also NAME.not-for-studies.mp4, 4:2:0
  bool master = false;     // also NAME.master.mp4, lossless RGB: its decoded bytes are the raw frames
  bool webm = false;       // also NAME.webm, VP9 4:4:4, for browsers that refuse H.264 4:4:4; as accurate
  std::string title;       // container metadata
  ClipCheck check;         // of every study file; may be empty
};

// How far decoded frames lie from the raw ones: RGB 8-bit code values, all three channels of all pixels.
struct ClipError {
  double psnr_worst_frame = 0;  // dB, +inf when equal
  size_t worst_frame = 0;       // index from 0
  double psnr_mean = 0;         // dB of the mean squared error over the whole clip
  int max_difference = 0;       // largest difference of one channel, 0..255
};

struct ClipFile {
  std::filesystem::path path;
  std::string role;          // "study" (H.264 or VP9), "compatibility" or "master"
  std::string codec;         // "h264", "vp9"
  std::string pixel_format;  // "yuv444p", "yuv420p", "rgb24"
  std::string preset;        // x264's; VP9's cpu-used
  std::optional<int> crf;    // as used; std::nullopt: lossless
  int threads = 0;
  uint64_t bytes = 0;
  std::string sha256;  // of the file
  ClipError error;
};

// One encoding that was tried on the way to `least_psnr`.
struct ClipAttempt {
  std::string codec;
  int crf = 0;
  double psnr_worst_frame = 0;
};

struct Clip {
  int width = 0;
  int height = 0;
  int fps = 30;
  // For each frame: SHA-256 of the raw frame's width x height x 3 bytes, RGB, rows top to bottom.
  std::vector<std::string> frame_sha256;
  std::vector<ClipFile> files;        // the study file first
  std::vector<ClipAttempt> attempts;  // the last one of its codec is the study file's
  // False: even the finest encoding missed `least_psnr` or the check; no file was left behind, but files.back().error
  // says how accurate it was.
  bool accurate = false;
};

// Which browsers play a study file of that codec ("h264" or "vp9", both 4:4:4), in words.
std::string players_text(const std::string& codec);

// What a manifest says of a clip: "frames", "fps", "width", "height", "files": [...], "attempts", "frame_sha256".
// Decibels that are infinite are the text "inf".
Json clip_json(const Clip& clip);

// Writes one clip. Nothing appears under its final name before finish() has checked it; a writer destroyed earlier
// leaves nothing behind. Needs disk space for a lossless copy beside the target while it works. The same frames and
// settings give the same bytes on one machine and build of FFmpeg.
class ClipWriter {
 public:
  // target: the study file, *.mp4. width, height: even, 16..8192. Throws Error.
  ClipWriter(std::filesystem::path target, int width, int height, const ClipSettings& settings = {});
  ~ClipWriter();
  ClipWriter(const ClipWriter&) = delete;
  ClipWriter& operator=(const ClipWriter&) = delete;
  // 3 or 4 channels (alpha is left out), sRGB-encoded, of exactly the clip's size (asserted). Throws Error (disk full).
  void add(const Image8& frame);
  // Encodes, decodes, compares. While the worst frame lies below `least_psnr` the rate factor is lowered by the missing
  // decibels, rounded up, and the clip encoded again. Needs at least one frame. Call once. Throws Error, and
  // Interrupted after Ctrl-C.
  Clip finish();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

// Writes frames so that they come back as they are: H.264 of RGB in mp4. Nothing appears under the final name before
// finish(). The same frames give the same bytes.
class LosslessWriter {
 public:
  LosslessWriter(const std::filesystem::path& target, int width, int height, int fps);  // as ClipWriter
  ~LosslessWriter();
  LosslessWriter(const LosslessWriter&) = delete;
  LosslessWriter& operator=(const LosslessWriter&) = delete;
  void add(const Image8& frame);  // as ClipWriter::add
  // SHA-256 of each raw frame, as Clip::frame_sha256. Throws Error.
  std::vector<std::string> finish();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

// SHA-256 of a file's bytes. Throws Error.
std::string file_sha256(const std::filesystem::path& path);

// Decodes a video file frame by frame.
class ClipReader {
 public:
  explicit ClipReader(const std::filesystem::path& path);  // throws Error
  ~ClipReader();
  ClipReader(const ClipReader&) = delete;
  ClipReader& operator=(const ClipReader&) = delete;

  int width() const;
  int height() const;
  // What the file says of itself, FFmpeg's names, empty where it does not say.
  struct Tags {
    std::string codec, pixel_format, primaries, transfer, matrix, range, title;
    int fps_numerator = 0, fps_denominator = 1;
    int64_t frames = 0;       // as many as to expect, for a progress; 0: unknown
    int64_t duration_us = 0;  // microseconds; 0: unknown
  };
  const Tags& tags() const;

  struct Frame {
    Image8 rgb;
    int64_t pts = 0;  // shown at pts * numerator / denominator seconds
    int time_base_numerator = 0, time_base_denominator = 1;
    bool key = false;
  };
  // Reads the next frame into `frame`, whose memory is used again; false at the end. Throws Error.
  bool next(Frame& frame);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

// Holds a video file to the raw frames that it should show, by decoding it: as many, the n-th at n / fps seconds, all
// together as long as that is. What ClipWriter does with every file before it gets its name.
class ClipComparison {
 public:
  // name: of the file, in errors. fps: constant. check: of every frame; missing_db is the caller's to ask.
  ClipComparison(const std::filesystem::path& file, std::string name, int fps, const ClipCheck& check = {});
  ~ClipComparison();
  ClipComparison(const ClipComparison&) = delete;
  ClipComparison& operator=(const ClipComparison&) = delete;
  // The next raw frame, width x height x 3 bytes. Throws Error: the file ends before, or shows it at another time.
  void next(const std::vector<uint8_t>& raw);
  // After the last one. Throws Error: the file has more frames, or says that it lasts longer or shorter than they do.
  ClipError finish();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace crowdbench::studies
