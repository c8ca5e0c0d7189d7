// The bake of flat impostors: tiles of one character, by clip frame and view, at every level, packed into pages.
#pragma once
#include <algorithm>
#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "renderers/impostor/tiles/plane.h"
#include "renderers/impostor/tiles/stored_frames.h"
#include "renderers/impostor/tiles/tile.h"
#include "renderers/impostor/views/view_grid.h"
#include "renderers/impostor/views/view_sampling.h"
#include "renderers/representation.h"

namespace crowdbench::renderers {

struct FlatBakeOptions {
  std::string drawn_by = "flat";  // the representation, as errors and progress name it; no part of the bake
  ViewGrid grid;
  FrameCount frames;
  int texels = 128;         // across the enclosing sphere: the texel size is its diameter over this
  bool fitted = true;       // planes fitted to the posed body; false: through the capture centre, facing the view
  bool trimmed = true;      // false: every tile is the whole square, as the source has it
  int corners = 8;          // of the outlines of the finer levels, 4..8; coarser ones are triangles
  bool compressed = false;  // blocks (renderers/impostor/tiles/block_compression.h) instead of RGBA8 texels; tiles lie
                            // at multiples of four, so that none shares a block
  bool depth = true;        // of a compressed bake: with the depth map, which only nailboards read
  bool motion = false;  // with motion maps between frames (flat_motion.h), and outlines around what is shown half-way
                        // to the frames before and after, too
  // Frames x views, frame-major: the tiles to bake; empty: all of them. Those that are baked are the same texels at the
  // same place of a layer whatever else is, so that pictures do not change by a bit; layers without any are left out.
  std::vector<uint8_t> needed;
  unsigned threads =
      0;  // that build tiles; 0: as many as the machine has, eight at most. The bytes do not depend on it
};

// Where a tile lies in its level's pages, and in space.
struct FlatTile {
  float offset_x = 0;  // add to lattice coordinates of the level to get texels on the page
  float offset_y = 0;
  float layer = 0;
  float covered = 0;  // area of the silhouette, texels of the level
  // Height of the polygon's plane over the capture plane towards the eye: slope_x * x + slope_y * y + height, x and y
  // and height in metres. Zero for planes that face the view.
  float slope_x = 0;
  float slope_y = 0;
  float height = 0;
  float spread = 0;  // metres that what is stored lies before or behind the plane, at most; reckoned where it is needed
  float low_x = 0, low_y = 0, high_x = 0, high_y = 0;  // what holds the tile without its gutter, lattice coordinates
};

// One level: layers of width x height texels, row 0 lowest. An albedo and a surface map
// (renderers/impostor/tiles/tile.h) of RGBA8 texels; of a compressed bake albedo as BC3 blocks, and in place of the
// surface map BC5 normals, BC4 depths where they are wanted, and material ids of FlatBake::slot_bits, rows of width *
// slot_bits / 8 bytes. Where the character glows there is an emission map besides (renderers/bake/emission.h): RGBA8
// texels or BC1 blocks. Motion maps are RGBA8 texels at the place of the earlier frame's tile, of every level but the
// finest (motion is smooth: level 0 is drawn by level 1's), which has one where it is the only level.
struct FlatLevel {
  int width = 0, height = 0, layers = 0;
  int corners = 4;                             // 3: triangles that reach beyond the tiles (tile_triangle)
  std::vector<FlatTile> tiles;                 // frames x views, frame-major
  std::vector<std::array<float, 2>> outlines;  // `corners` a tile, lattice coordinates, in strip order
  std::vector<uint8_t> albedo, surface;
  std::vector<uint8_t> normal, depth, slots;
  std::vector<uint8_t> emission;
  std::vector<uint8_t> motion;
  uint64_t texture_bytes() const {
    return albedo.size() + surface.size() + normal.size() + depth.size() + slots.size() + emission.size() +
           motion.size();
  }
};

struct FlatBake {
  std::array<float, 3> centre{};  // of the enclosing sphere, model space, metres: what the planes go through
  float radius = 0;               // metres; also what the ends of the stored depth stand for
  float texel = 0;                // metres, of level 0
  uint32_t frames = 0;
  uint32_t views = 0;
  int slot_bits = 0;              // of a compressed bake: 4 or 8 bits a material id; 0: RGBA8
  float emission_peak = 0;        // linear light, of all materials; 0: no emission maps
  float motion_range = 0;         // metres that the ends of the motion maps' codes stand for; 0: no motion maps
  std::vector<StoredClip> clips;  // one a clip of the bank
  std::vector<FlatLevel> levels;
  uint64_t texture_bytes() const;
};

// Of `levels`, the one whose motion maps a level is drawn by.
inline size_t motion_level(size_t level, size_t levels) { return std::min(std::max<size_t>(level, 1), levels - 1); }

// Everything that a bake's bytes depend on.
std::string flat_cache_key(const scene::Character& character, const scene::PoseBank& bank,
                           const FlatBakeOptions& options, const std::string& gl_renderer,
                           const std::string& gl_version);

// Bakes every clip of the bank; clips of a single sample are baked as that one pose, exactly. Throws Error when the
// textures would need more than `budget` bytes (before anything is drawn), naming what to lower.
FlatBake bake_flat(gl::Context& context, const std::shared_ptr<const scene::Character>& character,
                   const std::shared_ptr<const scene::PoseBank>& bank, const FlatBakeOptions& options, uint64_t budget,
                   const std::function<void(size_t tiles_done, size_t tiles)>& progress = {});

// What a bake will be made of, without making it.
struct FlatForecast {
  ViewSampling sampling;
  uint64_t tiles = 0;
};
FlatForecast forecast_flat(const scene::Character& character, const std::shared_ptr<const scene::PoseBank>& bank,
                           const FlatBakeOptions& options);

// One frame as Tecchia, Loscos and Chrysanthou 2002 count theirs: every view a square of `texels`, row by row on the
// smallest square page whose side is a power of two; an RGBA and an RGB map, and the same as blocks of 4:1 and 6:1.
struct NominalFrame {
  int side = 0;  // texels
  uint64_t bytes = 0;
  uint64_t compressed_bytes = 0;
};
NominalFrame nominal_frame(const ViewGrid& grid, int texels);

// Which tiles a sample shows.
struct ShownTiles {
  bool blend = false;        // the views of ViewGrid::blend; else the nearest
  bool both_frames = false;  // the frames before and after the moment; else the nearest
};

// FlatBakeOptions::needed for view samples: `visit` shows them one after the other. What lies within rounding of
// another view or frame counts for both.
std::vector<uint8_t> needed_tiles(const scene::Character& character, const std::shared_ptr<const scene::PoseBank>& bank,
                                  const FlatBakeOptions& options, const ShownTiles& shown,
                                  const std::function<void(const std::function<void(const ViewSample&)>&)>& visit);

std::vector<uint8_t> serialise(const FlatBake& bake);
// std::nullopt when the bytes are not a bake (a stale format that a checksum cannot see).
std::optional<FlatBake> deserialise_flat(std::span<const uint8_t> bytes);

}  // namespace crowdbench::renderers
