// Sequences of frames, read one frame at a time, alone or two side by side: clips, folders of pictures, the two halves
// of one stacked clip.
#pragma once
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "core/image_io.h"

namespace crowdbench::bench {

// One sequence of frames, read one at a time.
class FrameSequence {
 public:
  virtual ~FrameSequence() = default;
  // The next frame into `image`; false at the end. Throws Error: a damaged frame.
  virtual bool next(AnyImage& image) = 0;
  double fps = 0;       // 0: it does not say
  size_t frames = 0;    // as many as to expect; 0: unknown
  std::string warning;  // what its files' numbers say against it; empty: nothing
};
// A clip or a folder of pictures. Throws Error.
std::unique_ptr<FrameSequence> open_sequence(const std::filesystem::path& path);

struct FramePair {
  AnyImage reference, test;
};

class FramePairs {
 public:
  virtual ~FramePairs() = default;
  // The next pair into `pair`; false at the end of both. Throws Error: a damaged frame, one of another size than the
  // first, or one sequence that ends before the other.
  virtual bool next(FramePair& pair) = 0;

  std::string reference, test;        // what the sides are called
  double fps = 0;                     // 0: they do not say
  size_t frames = 0;                  // as many as to expect; 0: unknown
  std::vector<std::string> warnings;  // of the sides, each with its name
  // What drew them, as TOML, and the file that says so; empty: nobody says.
  std::string scenario, scenario_in;
};

// Whether the path names a sequence and not one picture: a folder, or a file whose name ends as a video's does.
bool is_sequence(const std::filesystem::path& path);

// Two sequences, each a clip or a folder. fps: at which they are seen; 0: as they say, and then rates that differ are
// an Error. Throws Error.
std::unique_ptr<FramePairs> open_frame_pairs(const std::filesystem::path& reference, const std::filesystem::path& test,
                                             double fps = 0);

// A clip that `pair` wrote: half `a` of its manifest (the same name with .json) is the reference, half `b` the test.
// Throws Error.
std::unique_ptr<FramePairs> open_stacked(const std::filesystem::path& clip);

// The pictures of a folder in the order in which people count: frame2.png before frame10.png. Hidden files and those
// that are no pictures by their ending are left out. Throws Error where there is none.
std::vector<std::filesystem::path> frames_in(const std::filesystem::path& folder);
// "frames 3 to 6 are missing (files are numbered 0 to 8); ..." where the names, in their order, differ by their last
// number alone and that does not rise by the same everywhere; else empty.
std::string missing_numbers(const std::vector<std::filesystem::path>& files);
// Whether a name stands before another there: runs of digits by their number, all else by its bytes.
bool in_natural_order(std::string_view a, std::string_view b);

}  // namespace crowdbench::bench
