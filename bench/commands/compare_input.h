// What `compare` is asked, and what it makes of pictures before they are scored: alike for two pictures and for frames.
#pragma once
#include <array>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "bench/commands/compare_region.h"
#include "bench/commands/score_bounds.h"
#include "core/image_io.h"
#include "metrics/not_finite.h"
#include "metrics/registry.h"

namespace crowdbench::bench {

class Command;

struct CompareOptions {
  std::string reference;
  std::string test;  // empty: `reference` is a stacked clip
  std::string scores = "all";
  std::string display;
  std::string maps;
  std::string padding = "replicate";
  std::string colours = "own";
  std::string chart;
  std::string over;
  std::string over_rounding = "down";
  std::string ids_reference;
  std::string ids_test;
  std::string depth_reference, depth_test;  // for the error by cause, with ids
  std::string pose_reference, pose_ids;     //
  RegionOptions region;
  std::vector<std::string> fail_above, fail_below;
  double fps = 0;
  bool json = false;
};

// `options` must outlive the command.
void add_compare_options(Command& command, CompareOptions& options);

// The options, read: whatever is wrong in them is said before a picture is opened.
struct CompareSetup {
  std::vector<const metrics::Score*> table;  // of --scores
  metrics::Needs also = 0;                   // scores that need these say why they are not there
  std::vector<ScoreBound> bounds;
  std::optional<std::array<uint8_t, 3>> over;
  metrics::OverRounding over_rounding = metrics::OverRounding::down;
  metrics::ChosenDisplay display;
  std::string display_from;  // the manifest whose scenario chose it; empty: --display or nobody
  metrics::Padding padding = metrics::Padding::replicate;
  metrics::MapColours colours = metrics::MapColours::own;
};
// Throws Error.
CompareSetup compare_setup(const CompareOptions& options, metrics::ScoreTable table);

// The two pictures as they were read, brought to one kind of number.
struct ComparedPictures {
  AnyImage reference, test;
  ImageU32 reference_ids, test_ids;    // empty: not asked for
  ImageF reference_depth, test_depth;  // likewise
};
bool has_codes(const AnyImage& image);

// Alpha is composited away where a colour was given, else ignored; 8 bits beside 16 become 16; where a region is asked
// for, pixels outside it become equal. Adds to `warnings` what the user may not expect; the names say which picture.
void bring_together(const CompareSetup& setup, const std::optional<CompareRegion>& region, ComparedPictures& pictures,
                    const std::string& reference, const std::string& test, std::vector<std::string>& warnings);

// Borrows all three.
metrics::ScoreInput score_input(const CompareSetup& setup, const std::optional<CompareRegion>& region,
                                const ComparedPictures& pictures);

// Float pictures' pixels that are not a number or infinite; nothing where the pictures have code values.
struct NotFinitePair {
  metrics::NotFinite reference, test;
};
std::optional<NotFinitePair> not_finite_of(const ComparedPictures& pictures);

// The pictures of one score's map under the folder, as "NAME.png" or "NAME_frame0008.png" by `suffix`; returns the
// files that were written.
std::vector<std::string> write_map(const std::filesystem::path& folder, const std::string& suffix,
                                   const metrics::Score& score, const metrics::ScoreResult& result,
                                   metrics::MapColours colours);

// What it is looked at on and who chose that, for people.
std::string display_line(const CompareSetup& setup);
// That line, where one of the scores needs a display.
void print_display(const CompareSetup& setup, std::span<const metrics::Scored> scores);

}  // namespace crowdbench::bench
