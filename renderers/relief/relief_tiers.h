// One character's relief in all its tiers: nearby boxes with detail, far away fewer boxes that joints share. What the
// options ask for, baked on the CPU, and as bytes on disk.
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "renderers/bake/bake_progress.h"
#include "renderers/relief/relief_bake.h"
#include "renderers/relief/relief_pieces.h"
#include "scene/character/character.h"
#include "scene/pose/pose_bank.h"

namespace crowdbench::renderers {

// Tall: what ReliefTierOptions::bend counts its pixels in.
inline constexpr double kBendPixels = 240;

struct ReliefTierOptions {
  ReliefBakeOptions maps;  // map_size, rule, threshold, cube and by_area; the rest is found here
  std::string capture;     // "best", "bind" or "CLIP@PHASE"
  std::string resolution;  // "none" or "JOINT@TEXELS+..."
  int depth_bits = 16;
  bool cones = false;
  double merge = 0;        // pixels that joints sharing a box may deviate; 0: one tier
  double bend = 0;         // pixels, of a character 240 tall, that skin may deviate before it is cut; 0: rigid boxes
  int cells = 256;         // boxes that cut skin may take
  double part = 0;         // longest box, of the character's height; 0: no limit
  bool part_auto = false;  // longer boxes where the maps need it to fit
  uint64_t budget = 0;     // bytes of the nearest tier's maps, met by coarser texels; 0: none
};

// What a bake may take, in bytes of maps.
struct ReliefAllowance {
  uint64_t share = 0;  // one character's part, a power of two: part_auto keeps to it
  uint64_t left = 0;   // of the bake budget: more is an error
};

struct ReliefTiers {
  CaptureScore capture;
  double deviation = 0;             // metres: of the skin from the nearest tier's boxes at most; 0 where they are rigid
  double loose = 0;                 // of the skin's area, what Cells::loose says of the nearest tier
  std::vector<double> tier_pixels;  // of each model after the first: drawn below this height
  std::vector<ReliefModel> models;
  std::vector<std::vector<uint8_t>> cones;  // of each model; none unless asked for
};

// A number in [low, high) within an option's text. Throws Error.
double number_of(const char* begin, const char* end, const std::string& where, const std::string& text, double low,
                 double high, const char* advice);
// What can be said of a value of the options `capture` and `resolution` without a character. Throw Error.
void check_capture(const std::string& value, const std::string& where);
void check_resolution(const std::string& value, const std::string& where);

// Metres at scale 1; 1.75 where the character says nothing.
double relief_height(const scene::Character& character);

// What tells one bake from another in the cache.
std::string relief_key(const scene::Character& character, const scene::PoseBank& bank, const ReliefTierOptions& options,
                       const ReliefAllowance& allowance);
// Throws Error when an option names what the character lacks or the maps need more than is left of the bake budget.
ReliefTiers bake_tiers(const scene::Character& character, const scene::PoseBank& bank, const ReliefTierOptions& options,
                       const ReliefAllowance& allowance, const BakeProgress& progress = {});
// Throws Error when the nearest tier's maps, of so many texels (ReliefModel::texels()), need more than is left.
void require_room(const scene::Character& character, size_t texels, const ReliefTierOptions& options,
                  const ReliefAllowance& allowance);
std::vector<uint8_t> serialise(const ReliefTiers& tiers);
// std::nullopt when the bytes are not a bake of this version.
std::optional<ReliefTiers> deserialise_tiers(const std::vector<uint8_t>& bytes, size_t joints, bool cones);

// Bytes of a depth texel: two depths, of a cube on either side, and four cones when they are searched.
uint64_t depth_texel_bytes(const ReliefTierOptions& options);
// Colours, normals and, of a character that glows, emission, of two faces to a depth texel.
uint64_t colour_texel_bytes(float emission_peak);

}  // namespace crowdbench::renderers
