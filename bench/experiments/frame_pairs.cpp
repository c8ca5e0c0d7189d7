#include "bench/experiments/frame_pairs.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <limits>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <system_error>
#include <utility>
#include <variant>

#include "core/error.h"
#include "core/files.h"
#include "studies/stimuli/clip.h"

namespace crowdbench::bench {
namespace {

namespace fs = std::filesystem;

std::string ending_of(const fs::path& path) {
  std::string ending = path.extension().string();
  for (char& c : ending) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return ending;
}

bool is_digit(char c) { return c >= '0' && c <= '9'; }

class ClipSide : public FrameSequence {
 public:
  explicit ClipSide(const fs::path& path) : reader_(path) {
    const studies::ClipReader::Tags& tags = reader_.tags();
    if (tags.fps_numerator > 0 && tags.fps_denominator > 0)
      fps = static_cast<double>(tags.fps_numerator) / tags.fps_denominator;
    frames = static_cast<size_t>(std::max<int64_t>(tags.frames, 0));
  }
  bool next(AnyImage& image) override {
    // The picture's memory is used again where it can be.
    if (auto* codes = std::get_if<Image8>(&image)) frame_.rgb = std::move(*codes);
    const bool got = reader_.next(frame_);
    if (got) image = std::move(frame_.rgb);
    return got;
  }

 private:
  studies::ClipReader reader_;
  studies::ClipReader::Frame frame_;
};

class FolderSide : public FrameSequence {
 public:
  explicit FolderSide(const fs::path& folder) : files_(frames_in(folder)) {
    frames = files_.size();
    warning = missing_numbers(files_);
  }
  bool next(AnyImage& image) override {
    if (at_ == files_.size()) return false;
    image = read_image(files_[at_++]);
    return true;
  }

 private:
  std::vector<fs::path> files_;
  size_t at_ = 0;
};

std::pair<int, int> size_of(const AnyImage& image) {
  return std::visit([](const auto& i) { return std::pair{i.width, i.height}; }, image);
}

class TwoSides : public FramePairs {
 public:
  TwoSides(const fs::path& reference_path, const fs::path& test_path, double fps_given)
      : reference_side_(open_sequence(reference_path)), test_side_(open_sequence(test_path)) {
    reference = reference_path.string();
    test = test_path.string();
    const double a = reference_side_->fps;
    const double b = test_side_->fps;
    if (fps_given == 0 && a > 0 && b > 0 && std::abs(a - b) > 1e-3)
      throw Error(test, fmt::format("has {:g} frames a second, {} {:g}", b, reference, a),
                  "compare clips of one frame rate, or say with --fps at which they are seen");
    fps = fps_given > 0 ? fps_given : std::max(a, b);
    for (const auto& [side, name] : {std::pair{&*reference_side_, &reference}, std::pair{&*test_side_, &test}})
      if (!side->warning.empty()) warnings.push_back(*name + ": " + side->warning);
    frames = std::max(reference_side_->frames, test_side_->frames);
  }

  bool next(FramePair& pair) override {
    const bool a = reference_side_->next(pair.reference);
    const bool b = test_side_->next(pair.test);
    if (a != b)
      throw Error(a ? test : reference, fmt::format("ends after {} frames, {} goes on", done_, a ? reference : test),
                  "compare sequences of one length");
    if (!a) return false;
    for (const auto& [image, name] : {std::pair{&pair.reference, &reference}, std::pair{&pair.test, &test}}) {
      const auto [width, height] = size_of(*image);
      if (done_ == 0 && image == &pair.reference) size_ = {width, height};
      if (std::pair{width, height} != size_)
        throw Error(
            *name,
            fmt::format("frame {} is {} x {} pixels, not {} x {}", done_, width, height, size_.first, size_.second),
            "compare frames of one size");
    }
    ++done_;
    return true;
  }

 private:
  std::unique_ptr<FrameSequence> reference_side_, test_side_;
  std::pair<int, int> size_;
  size_t done_ = 0;
};

// Rows first .. first + rows - 1, columns 0 .. width - 1.
Image8 cut(const Image8& image, int first, int rows, int width) {
  Image8 out(width, rows, image.channels);
  const auto bytes = static_cast<size_t>(width) * static_cast<size_t>(image.channels);
  for (int y = 0; y < rows; ++y) std::copy_n(image.at(0, first + y), bytes, out.at(0, y));
  return out;
}

class Halves : public FramePairs {
 public:
  Halves(const fs::path& clip, const nlohmann::json& manifest, const std::string& where) : stacked_(clip) {
    try {
      if (manifest.at("format") != "crowdbench-pair-1")
        throw Error(where, "is not a manifest of a stacked clip", "name a clip that `crowdbench pair` wrote");
      width_ = manifest.at("half").at("width").get<int>();
      height_ = manifest.at("half").at("height").get<int>();
      bar_ = manifest.at("bar").at("height").get<int>();
      a_on_top_ = manifest.at("top").at("configuration") == "a";
      const auto name = [&](bool a) {
        return manifest.at(a == a_on_top_ ? "top" : "bottom").at("representation").get<std::string>();
      };
      reference = name(true);
      test = name(false);
      if (manifest.contains("scenario")) scenario = manifest.at("scenario").at("toml").get<std::string>();
      scenario_in = where;
    } catch (const nlohmann::json::exception&) {
      throw Error(where, "is not a manifest of a stacked clip", "name a clip that `crowdbench pair` wrote");
    }
    fps = stacked_.fps;
    frames = stacked_.frames;
    where_ = clip.string();
  }

  bool next(FramePair& pair) override {
    if (!stacked_.next(whole_)) return false;
    const Image8& whole = std::get<Image8>(whole_);
    if (width_ < 1 || height_ < 1 || bar_ < 0 || bar_ > whole.height || height_ > (whole.height - bar_) / 2 ||
        width_ > whole.width)
      throw Error(where_,
                  fmt::format("is {} x {} pixels, too few for the halves of its manifest", whole.width, whole.height),
                  "name the clip with the manifest that was written beside it");
    pair.reference = cut(whole, a_on_top_ ? 0 : height_ + bar_, height_, width_);
    pair.test = cut(whole, a_on_top_ ? height_ + bar_ : 0, height_, width_);
    return true;
  }

 private:
  ClipSide stacked_;
  AnyImage whole_;
  std::string where_;
  int width_ = 0, height_ = 0, bar_ = 0;
  bool a_on_top_ = true;
};

}  // namespace

std::unique_ptr<FrameSequence> open_sequence(const fs::path& path) {
  if (fs::is_directory(path)) return std::make_unique<FolderSide>(path);
  return std::make_unique<ClipSide>(path);
}

bool in_natural_order(std::string_view a, std::string_view b) {
  size_t i = 0;
  size_t j = 0;
  while (i < a.size() && j < b.size()) {
    if (!is_digit(a[i]) || !is_digit(b[j])) {
      if (a[i] != b[j]) return a[i] < b[j];
      ++i;
      ++j;
      continue;
    }
    const auto number = [](std::string_view text, size_t& at) {
      while (at < text.size() && text[at] == '0') ++at;
      const size_t begin = at;
      while (at < text.size() && is_digit(text[at])) ++at;
      return text.substr(begin, at - begin);
    };
    const std::string_view p = number(a, i);
    const std::string_view q = number(b, j);
    if (p.size() != q.size()) return p.size() < q.size();
    if (p != q) return p < q;
  }
  if (a.size() - i != b.size() - j) return a.size() - i < b.size() - j;
  return a < b;  // equal but for leading zeros
}

std::vector<fs::path> frames_in(const fs::path& folder) {
  static const std::set<std::string> endings = {".png", ".exr", ".jpg", ".jpeg", ".tif", ".tiff", ".webp",
                                                ".bmp", ".tga", ".hdr", ".ppm",  ".pgm", ".pnm"};
  std::vector<fs::path> files;
  std::error_code fault;
  const fs::directory_iterator entries(folder, fault);
  if (fault) throw Error(folder.string(), fmt::format("cannot be read: {}", fault.message()), "name a readable folder");
  for (const auto& entry : entries)
    if (entry.is_regular_file() && endings.contains(ending_of(entry.path())) &&
        !entry.path().filename().string().starts_with('.'))
      files.push_back(entry.path());
  if (files.empty()) throw Error(folder.string(), "has no pictures", "name a folder of frames (PNG, EXR, ...)");
  std::sort(files.begin(), files.end(), [](const fs::path& a, const fs::path& b) {
    return in_natural_order(a.filename().string(), b.filename().string());
  });
  return files;
}

std::string missing_numbers(const std::vector<fs::path>& files) {
  std::vector<uint64_t> numbers;
  std::optional<std::pair<std::string, std::string>> around;  // what is before the number, and behind it
  for (const fs::path& file : files) {
    const std::string stem = file.stem().string();
    const size_t last = stem.find_last_of("0123456789");
    if (last == std::string::npos) return {};
    const size_t before = stem.find_last_not_of("0123456789", last);
    const size_t first = before == std::string::npos ? 0 : before + 1;
    const std::pair here{stem.substr(0, first), stem.substr(last + 1) + ending_of(file)};
    uint64_t number = 0;
    const auto read = std::from_chars(stem.data() + first, stem.data() + last + 1, number);
    if (read.ec != std::errc{} || here != around.value_or(here) || (!numbers.empty() && number <= numbers.back()))
      return {};
    around = here;
    numbers.push_back(number);
  }
  uint64_t step = std::numeric_limits<uint64_t>::max();
  for (size_t i = 1; i < numbers.size(); ++i) step = std::min(step, numbers[i] - numbers[i - 1]);
  for (size_t i = 1; i < numbers.size(); ++i) {
    const uint64_t from = numbers[i - 1] + step;
    const uint64_t to = numbers[i] - step;
    if (from > to) continue;
    return fmt::format("{} missing (files are numbered {} to {}); the others are taken one after the other",
                       from == to ? fmt::format("frame {} is", from) : fmt::format("frames {} to {} are", from, to),
                       numbers.front(), numbers.back());
  }
  return {};
}

bool is_sequence(const fs::path& path) {
  static const std::set<std::string> endings = {".mp4", ".mkv", ".webm", ".mov", ".avi",
                                                ".m4v", ".mpg", ".mpeg", ".ogv", ".y4m"};
  return fs::is_directory(path) || endings.contains(ending_of(path));
}

std::unique_ptr<FramePairs> open_frame_pairs(const fs::path& reference, const fs::path& test, double fps) {
  for (const fs::path& path : {reference, test})
    if (!fs::exists(path)) throw Error(path.string(), "no such file or folder", "name a clip or a folder of frames");
  for (const auto& [path, other] : {std::pair{reference, test}, std::pair{test, reference}})
    if (!is_sequence(path))
      throw Error(path.string(), fmt::format("is one picture, {} is not", other.string()),
                  "compare two pictures, or two clips or folders of frames");
  return std::make_unique<TwoSides>(reference, test, fps);
}

std::unique_ptr<FramePairs> open_stacked(const fs::path& clip) {
  const fs::path manifest = fs::path(clip).replace_extension(".json");
  if (!is_sequence(clip) || fs::is_directory(clip) || !fs::exists(manifest))
    throw Error(
        clip.string(), "has nothing to be compared with",
        fmt::format("name a second picture or clip; a clip alone is one that `crowdbench pair` stacked, with its "
                    "manifest {} beside it",
                    manifest.filename().string()));
  const nlohmann::json parsed = nlohmann::json::parse(read_text(manifest), nullptr, false);
  return std::make_unique<Halves>(clip, parsed, manifest.string());
}

}  // namespace crowdbench::bench
