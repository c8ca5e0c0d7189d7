#include "studies/stimuli/clip.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <limits>

#include "core/error.h"
#include "core/hash.h"
#include "core/json.h"
#include "core/module.h"
#include "core/progress.h"
#include "studies/stimuli/module/video_api.h"

namespace crowdbench::studies {
namespace fs = std::filesystem;
namespace {

constexpr int kThreads = 2;  // part of the format: x264 with four threads decodes to another video than with two

const video::Api& api() {
  static const video::Api& loaded = [&]() -> const video::Api& {
    const auto function =
        reinterpret_cast<video::ApiFunction>(module_symbol("video", video::kApiSymbol, "writing or reading a clip"));
    const video::Api* found = function();
    if (found->version != video::kApiVersion) {
      throw Error("crowdbench_video.so", "is of another version than the program", "rebuild with ./run build");
    }
    return *found;
  }();
  return loaded;
}

class Encoder {
 public:
  // name: the file's final name, for messages.
  Encoder(const fs::path& path, std::string name, const video::Settings& settings) : name_(std::move(name)) {
    encoder_ = api().open_encoder(path.c_str(), &settings, message_);
    if (!encoder_) fail();
  }
  ~Encoder() {
    if (encoder_) api().free_encoder(encoder_);
  }
  Encoder(const Encoder&) = delete;
  Encoder& operator=(const Encoder&) = delete;
  void encode(const uint8_t* rgb) {
    if (!api().encode(encoder_, rgb, message_)) fail();
  }
  void finish() {
    if (!api().finish(encoder_, message_)) fail();
  }

 private:
  [[noreturn]] void fail() const {
    throw Error(name_, message_, "check the place, the free space and that FFmpeg has libx264");
  }
  std::string name_;
  char message_[video::kMessageBytes] = {};
  video::Encoder* encoder_ = nullptr;
};

std::string frame_sha256(const std::vector<uint8_t>& rgb) { return Sha256().bytes(rgb.data(), rgb.size()).hex(); }

double decibels(double squared_error, double values) {
  if (squared_error <= 0) return std::numeric_limits<double>::infinity();
  return 10.0 * std::log10(255.0 * 255.0 * values / squared_error);
}

// Adds up what separates two videos, exactly.
class ErrorSum {
 public:
  void add(const std::vector<uint8_t>& raw, const std::vector<uint8_t>& decoded) {
    uint64_t squared = 0;
    int largest = 0;
    for (size_t i = 0; i < raw.size(); ++i) {
      const int difference = std::abs(int{raw[i]} - int{decoded[i]});
      squared += static_cast<uint64_t>(difference * difference);
      largest = std::max(largest, difference);
    }
    if (frames_ == 0 || squared > worst_) {
      worst_ = squared;
      worst_frame_ = frames_;
    }
    largest_ = std::max(largest_, largest);
    total_ += squared;
    values_ = raw.size();
    ++frames_;
  }
  ClipError result() const {
    const auto values = static_cast<double>(values_);
    return {decibels(static_cast<double>(worst_), values), worst_frame_,
            decibels(static_cast<double>(total_), values * static_cast<double>(frames_)), largest_};
  }

 private:
  uint64_t worst_ = 0;
  uint64_t total_ = 0;
  size_t worst_frame_ = 0;
  size_t values_ = 0;
  size_t frames_ = 0;
  int largest_ = 0;
};

fs::path beside(const fs::path& target, const char* what) {
  return target.parent_path() / (target.stem().string() + what + target.extension().string());
}

// Packed RGB of a frame of 3 or 4 channels.
void pack(const Image8& frame, std::vector<uint8_t>& packed) {
  const auto channels = static_cast<size_t>(frame.channels);
  packed.resize(frame.pixels() * 3);
  for (size_t i = 0; i < frame.pixels(); ++i) std::copy_n(&frame.data[i * channels], 3, &packed[i * 3]);
}

void check_size(const std::string& name, int width, int height, int fps) {
  if (width < 16 || height < 16 || width > 8192 || height > 8192 || width % 2 || height % 2) {
    throw Error(name, fmt::format("a clip cannot be {}x{}", width, height), "use even sides of 16 to 8192 pixels");
  }
  if (fps < 1 || fps > 240) throw Error("fps", fmt::format("{} is not 1 to 240", fps));
}

}  // namespace

std::string file_sha256(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  std::vector<char> block(size_t{1} << 20);
  Sha256 hash;
  while (file) {
    file.read(block.data(), static_cast<std::streamsize>(block.size()));
    hash.bytes(block.data(), static_cast<size_t>(file.gcount()));
  }
  if (!file.eof()) throw Error(path.string(), "cannot be read back");
  return hash.hex();
}

struct ClipReader::State {
  std::string name;
  Tags tags;
  video::Info info;
  video::Decoder* decoder = nullptr;
  char message[video::kMessageBytes] = {};
  ~State() {
    if (decoder) api().free_decoder(decoder);
  }
};

ClipReader::ClipReader(const fs::path& path) : state_(std::make_unique<State>()) {
  state_->name = path.string();
  state_->decoder = api().open_decoder(path.c_str(), &state_->info, state_->message);
  if (!state_->decoder) throw Error(state_->name, state_->message, "name a video file that FFmpeg reads");
  const video::Info& info = state_->info;
  state_->tags = {info.codec, info.pixel_format,  info.primaries,       info.transfer, info.matrix,     info.range,
                  info.title, info.fps_numerator, info.fps_denominator, info.frames,   info.duration_us};
}

ClipReader::~ClipReader() = default;
int ClipReader::width() const { return state_->info.width; }
int ClipReader::height() const { return state_->info.height; }
const ClipReader::Tags& ClipReader::tags() const { return state_->tags; }

bool ClipReader::next(Frame& frame) {
  if (frame.rgb.width != width() || frame.rgb.height != height() || frame.rgb.channels != 3) {
    frame.rgb = Image8(width(), height(), 3);
  }
  video::FrameInfo info;
  const int32_t got = api().decode(state_->decoder, frame.rgb.data.data(), &info, state_->message);
  if (got < 0) throw Error(state_->name, state_->message, "the file is damaged");
  frame.pts = info.pts;
  frame.time_base_numerator = info.time_base_numerator;
  frame.time_base_denominator = info.time_base_denominator;
  frame.key = info.key != 0;
  return got > 0;
}

struct ClipComparison::State {
  ClipReader reader;
  std::string name;
  int fps;
  ClipCheck check;
  ClipReader::Frame decoded;
  ErrorSum sum;
  int64_t count = 0;

  // Exactly n / fps where the container's time base can say that, else the nearest that it can (WebM: milliseconds).
  bool is_on_time() const {
    const int64_t shown = decoded.pts * decoded.time_base_numerator * fps;
    const int64_t meant = count * decoded.time_base_denominator;
    const int64_t unit = int64_t{decoded.time_base_numerator} * fps;
    return decoded.time_base_denominator % unit == 0 ? shown == meant : 2 * std::abs(shown - meant) <= unit;
  }
};

ClipComparison::ClipComparison(const fs::path& file, std::string name, int fps, const ClipCheck& check)
    : state_(new State{.reader = ClipReader(file), .name = std::move(name), .fps = fps, .check = check}) {}

ClipComparison::~ClipComparison() = default;

void ClipComparison::next(const std::vector<uint8_t>& raw) {
  State& s = *state_;
  if (!s.reader.next(s.decoded)) throw Error(s.name, fmt::format("ends after {} frames", s.count));
  if (!s.is_on_time()) throw Error(s.name, fmt::format("frame {} has a wrong time stamp", s.count));
  assert(raw.size() == s.decoded.rgb.data.size());
  s.sum.add(raw, s.decoded.rgb.data);
  if (s.check.frame) s.check.frame(static_cast<size_t>(s.count), raw, s.decoded.rgb.data);
  ++s.count;
}

ClipError ClipComparison::finish() {
  State& s = *state_;
  if (s.reader.next(s.decoded)) throw Error(s.name, "has more frames than were written");
  const double said = static_cast<double>(s.reader.tags().duration_us) / 1e6;
  const double meant = static_cast<double>(s.count) / s.fps;
  if (2 * std::fabs(said - meant) * s.fps >= 1)
    throw Error(s.name, fmt::format("says that it lasts {:.3f} s; {} frames last {:.3f} s", said, s.count, meant));
  return s.sum.result();
}

struct ClipWriter::State {
  fs::path target;
  ClipSettings settings;
  Clip clip;
  // The raw frames wait on disk, losslessly: the encodings, the comparison and the master all come from them.
  PendingFile lossless;
  std::string lossless_preset;
  std::unique_ptr<Encoder> raw;
  std::vector<uint8_t> packed;

  State(fs::path target_, int width, int height, const ClipSettings& settings_)
      : target(std::move(target_)), settings(settings_), lossless(beside(target, ".master")) {
    clip.width = width;
    clip.height = height;
    clip.fps = settings.fps;
    lossless_preset = settings.master ? "veryfast" : "ultrafast";
    packed.resize(static_cast<size_t>(width) * static_cast<size_t>(height) * 3);
  }

  video::Settings encoding(video::Codec codec, int crf, const char* preset, const std::string& title) const {
    video::Settings s;
    s.width = clip.width;
    s.height = clip.height;
    s.fps = clip.fps;
    s.codec = codec;
    s.crf = crf;
    s.preset = preset;
    s.threads = kThreads;
    s.title = title.empty() ? nullptr : title.c_str();
    return s;
  }

  // Calls `each` with every raw frame, having checked that it is the one that was added.
  template <typename Each>
  void for_each_raw_frame(const std::string& label, const Each& each) const {
    Progress progress(label, clip.frame_sha256.size());
    ClipReader reader(lossless.path());
    ClipReader::Frame frame;
    size_t count = 0;
    while (reader.next(frame)) {
      if (count >= clip.frame_sha256.size() || frame_sha256(frame.rgb.data) != clip.frame_sha256[count]) {
        throw Error(target.string(), fmt::format("frame {} changed on its way through the disk", count),
                    "check the disk, or report this build of FFmpeg");
      }
      each(frame.rgb.data);
      ++count;
      progress.advance();
    }
    if (count != clip.frame_sha256.size()) {
      throw Error(target.string(), fmt::format("{} of {} frames came back", count, clip.frame_sha256.size()),
                  "check the free disk space");
    }
  }

  void encode(const fs::path& path, const fs::path& final_name, const video::Settings& s) const {
    Encoder encoder(path, final_name.string(), s);
    for_each_raw_frame(fmt::format("encoding {} (crf {})", final_name.filename().string(), s.crf),
                       [&](const std::vector<uint8_t>& rgb) { encoder.encode(rgb.data()); });
    encoder.finish();
  }

  ClipError compare(const fs::path& path, const fs::path& final_name, const ClipCheck& check = {}) const {
    ClipComparison comparison(path, final_name.string(), clip.fps, check);
    for_each_raw_frame(fmt::format("checking {}", final_name.filename().string()),
                       [&](const std::vector<uint8_t>& rgb) { comparison.next(rgb); });
    return comparison.finish();
  }

  // A study file: finer and finer until it is accurate.
  ClipError encode_accurately(const fs::path& path, const fs::path& final_name, video::Codec codec, int& crf,
                              const char* preset) {
    const char* const name = codec == video::Codec::vp9_444 ? "vp9" : "h264";
    while (true) {
      encode(path, final_name, encoding(codec, crf, preset, settings.title));
      const ClipError error = compare(path, final_name, settings.check);
      double missing = settings.least_psnr - error.psnr_worst_frame;
      if (settings.check.missing_db) missing = std::max(missing, settings.check.missing_db());
      clip.attempts.push_back({name, crf, error.psnr_worst_frame});
      clip.accurate = missing <= 0;
      if (clip.accurate || crf == 0) return error;
      // One step of the rate factor is worth about one decibel; one of VP9's half of it.
      const double steps = codec == video::Codec::vp9_444 ? 2 * missing : missing;
      crf = std::max(0, crf - std::max(1, static_cast<int>(std::ceil(std::min(steps, 64.0)))));
    }
  }

  ClipFile describe(const fs::path& path, const fs::path& final_name, std::string role, std::string pixel_format,
                    const std::string& preset, std::optional<int> crf, const ClipError& error) const {
    const char* const codec = final_name.extension() == ".webm" ? "vp9" : "h264";
    return {final_name,          std::move(role),   codec, std::move(pixel_format), preset, crf, kThreads,
            fs::file_size(path), file_sha256(path), error};
  }
};

ClipWriter::ClipWriter(fs::path target, int width, int height, const ClipSettings& settings) {
  const std::string name = target.string();
  if (target.extension() != ".mp4") throw Error(name, "clips are mp4 files", "choose a name that ends in .mp4");
  check_size(name, width, height, settings.fps);
  if (settings.crf < 0 || settings.crf > 51) throw Error("crf", fmt::format("{} is not 0 to 51", settings.crf));
  state_ = std::make_unique<State>(std::move(target), width, height, settings);
  State& s = *state_;
  s.raw = std::make_unique<Encoder>(
      s.lossless.path(), name, s.encoding(video::Codec::h264_lossless, 0, s.lossless_preset.c_str(), settings.title));
}

ClipWriter::~ClipWriter() = default;

void ClipWriter::add(const Image8& frame) {
  State& s = *state_;
  assert(frame.width == s.clip.width && frame.height == s.clip.height && (frame.channels == 3 || frame.channels == 4));
  pack(frame, s.packed);
  s.raw->encode(s.packed.data());
  s.clip.frame_sha256.push_back(frame_sha256(s.packed));
}

Clip ClipWriter::finish() {
  State& s = *state_;
  assert(!s.clip.frame_sha256.empty() && s.raw);
  s.raw->finish();
  s.raw.reset();

  static constexpr char kPreset[] = "medium";
  PendingFile study(s.target);
  int crf = s.settings.crf;
  const ClipError error = s.encode_accurately(study.path(), s.target, video::Codec::h264_444, crf, kPreset);
  s.clip.files.push_back(s.describe(study.path(), s.target, "study", "yuv444p", kPreset, crf, error));
  if (!s.clip.accurate) return s.clip;

  std::optional<PendingFile> webm;
  if (s.settings.webm) {
    static constexpr char kSpeed[] = "5";
    const fs::path name = fs::path(s.target).replace_extension(".webm");
    webm.emplace(name);
    int quality = s.settings.crf + 3;  // VP9's rate factor for about the same error
    const ClipError webm_error = s.encode_accurately(webm->path(), name, video::Codec::vp9_444, quality, kSpeed);
    s.clip.files.push_back(s.describe(webm->path(), name, "study", "yuv444p", kSpeed, quality, webm_error));
    if (!s.clip.accurate) return s.clip;
  }

  std::optional<PendingFile> compat;
  if (s.settings.compat) {
    const fs::path name = beside(s.target, ".not-for-studies");
    compat.emplace(name);
    s.encode(compat->path(), name,
             s.encoding(video::Codec::h264_420, crf, kPreset,
                        "NOT FOR STUDIES: 4:2:0 compatibility copy" +
                            (s.settings.title.empty() ? std::string() : " of " + s.settings.title)));
    s.clip.files.push_back(
        s.describe(compat->path(), name, "compatibility", "yuv420p", kPreset, crf, s.compare(compat->path(), name)));
  }
  if (s.settings.master) {
    const fs::path name = beside(s.target, ".master");
    s.clip.files.push_back(s.describe(s.lossless.path(), name, "master", "rgb24", s.lossless_preset, std::nullopt,
                                      s.compare(s.lossless.path(), name)));
  }
  throw_if_interrupted();
  if (s.settings.master) s.lossless.commit();
  if (compat) compat->commit();
  if (webm) webm->commit();
  study.commit();
  return s.clip;
}

struct LosslessWriter::State {
  PendingFile file;
  Encoder encoder;
  std::vector<std::string> hashes;
  std::vector<uint8_t> packed;
  State(const fs::path& target, const video::Settings& settings)
      : file(target), encoder(file.path(), target.string(), settings) {}
};

LosslessWriter::LosslessWriter(const fs::path& target, int width, int height, int fps) {
  check_size(target.string(), width, height, fps);
  video::Settings s;
  s.width = width;
  s.height = height;
  s.fps = fps;
  s.codec = video::Codec::h264_lossless;
  s.preset = "veryfast";
  s.threads = kThreads;
  state_ = std::make_unique<State>(target, s);
}

LosslessWriter::~LosslessWriter() = default;

void LosslessWriter::add(const Image8& frame) {
  pack(frame, state_->packed);
  state_->encoder.encode(state_->packed.data());
  state_->hashes.push_back(frame_sha256(state_->packed));
}

std::vector<std::string> LosslessWriter::finish() {
  state_->encoder.finish();
  throw_if_interrupted();
  state_->file.commit();
  return std::move(state_->hashes);
}

std::string players_text(const std::string& codec) {
  if (codec == "vp9")
    return "VP9 4:4:4: Chromium and Firefox, whose decoders are their own (tried: Chromium 156, Firefox 153 on "
           "Debian); "
           "Safari was not tried";
  return "H.264 4:4:4: Chromium, and Firefox where FFmpeg decodes (tried: Chromium 156, Firefox 153 on Debian); "
         "refused "
         "by Safari, and by Firefox where the system decodes H.264";
}

Json clip_json(const Clip& clip) {
  const auto finite = [](double db) { return std::isinf(db) ? Json("inf") : Json(db); };
  Json files = Json::array();
  for (const ClipFile& file : clip.files) {
    Json entry = {{"file", file.path.filename().string()},
                  {"role", file.role},
                  {"for_studies", file.role == "study"},
                  {"browsers", file.role == "study" ? Json(players_text(file.codec)) : Json()},
                  {"sha256", file.sha256},
                  {"bytes", file.bytes}};
    entry["encoder"] = {{"codec", file.codec},
                        {"library", file.codec == "vp9" ? "libvpx-vp9"
                                    : file.crf          ? "libx264"
                                                        : "libx264rgb"},
                        {"pixel_format", file.pixel_format},
                        {"preset", file.preset},
                        {"threads", file.threads},
                        {"key_frame_every", clip.fps},
                        {"colour", file.crf ? "BT.709, limited range" : "RGB, full range"}};
    if (file.crf) {
      entry["encoder"]["crf"] = *file.crf;
    } else {
      entry["encoder"]["qp"] = 0;
    }
    entry["decoded"] = {{"psnr_worst_frame_db", finite(file.error.psnr_worst_frame)},
                        {"worst_frame", file.error.worst_frame},
                        {"psnr_mean_db", finite(file.error.psnr_mean)},
                        {"max_difference", file.error.max_difference}};
    files.push_back(std::move(entry));
  }
  Json attempts = Json::array();
  for (const ClipAttempt& attempt : clip.attempts) {
    attempts.push_back(
        {{"codec", attempt.codec}, {"crf", attempt.crf}, {"psnr_worst_frame_db", finite(attempt.psnr_worst_frame)}});
  }
  return {{"width", clip.width},
          {"height", clip.height},
          {"fps", clip.fps},
          {"frames", clip.frame_sha256.size()},
          {"seconds", static_cast<double>(clip.frame_sha256.size()) / clip.fps},
          {"files", std::move(files)},
          {"attempts", std::move(attempts)},
          {"frame_sha256", clip.frame_sha256}};
}

}  // namespace crowdbench::studies
