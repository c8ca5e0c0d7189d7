// Tiles: trimmed orthographic images of a character on a capture plane, and their mip levels.
//
// A capture plane goes through the capture centre and is spanned by a view's right and up. Texel (x, y) of level k
// covers [x, x + 1) * s * 2^k by [y, y + 1) * s * 2^k metres of it, y upwards, s being the one texel size of a bake, so
// that the texel lattices of all tiles meet at the capture centre: trimming crops, it never rescales.
#pragma once
#include <array>
#include <cstdint>
#include <vector>

namespace crowdbench::renderers {

// Whole texels of one level's lattice; empty when width or height is 0.
struct TileRect {
  int x = 0;
  int y = 0;
  int width = 0;
  int height = 0;
  bool operator==(const TileRect&) const = default;
};

// The texels of a coarser level that hold a rectangle of level 0.
TileRect level_rect(const TileRect& rect, int level);

inline constexpr int kTileGutter = 1;  // texels around a tile, filled from its border, with the alpha of "nothing here"

// Two RGBA maps, or three, of (width + 2 gutter) x (height + 2 gutter) texels, bottom row first.
//   albedo:  R, G, B = square root of the linear albedo, unlit; A = coverage, remapped so that bilinear filtering
//            crosses one half where the silhouette is.
//   surface: R, G = x and y of the normal in view space (encode_signed); B = material id, the top bit set when it is
//            not to be lit; A = height above the capture plane towards the eye, over the bake's depth range
//            (encode_signed).
//   emission: R, G, B = what the texel gives off (renderers/bake/emission.h), A = 255; empty where the tile gives off
//            nothing.
struct Tile {
  TileRect rect;
  std::vector<uint8_t> albedo;
  std::vector<uint8_t> surface;
  std::vector<uint8_t> emission;
  double coverage = 0;      // area of the silhouette in texels of this level, from the capture's own samples
  uint8_t empty_alpha = 0;  // stored alpha of "nothing here", below one half

  int stride() const { return rect.width + 2 * kTileGutter; }
  int rows() const { return rect.height + 2 * kTileGutter; }
};

inline constexpr uint8_t kUnlitSlot = 0x80;

// [-1, 1] to 8 bits with an exact zero: 128 + 127 v, and back.
uint8_t encode_signed(double v);
double decode_signed(uint8_t code);

// One texel of a capture: coverage 0..255 and the mean of the covered samples.
struct CapturedTexel {
  std::array<uint8_t, 4> albedo{};    // sqrt-encoded colour, A = fraction of the samples that are covered
  std::array<uint8_t, 4> surface{};   // as Tile::surface
  std::array<uint8_t, 3> emission{};  // square root of the fraction of the peak
};

// Level 0 and `levels` - 1 coarser ones of one tile. texels: rect.width x rect.height, bottom row first.
//   Every level keeps the silhouette's area: its alpha is mapped affinely (which commutes with bilinear filtering) so
//   that the filtered alpha is at least one half over exactly that area. Colours, normals and depths are means weighted
//   by coverage (colours and emission in linear light, normals renormalised), material ids the most covered one; texels
//   without coverage next to covered ones take their neighbours' values.
// crop: the rectangle shrinks to what is covered. A tile that covers nothing gives empty rectangles.
std::vector<Tile> build_tile_levels(const TileRect& rect, const std::vector<CapturedTexel>& texels, int levels,
                                    bool crop = true);

// Filtered alpha in [0, 1] at a point in texels of the tile's level (lattice coordinates), as the GPU's bilinear filter
// gives it.
double filtered_alpha(const Tile& tile, double x, double y);

}  // namespace crowdbench::renderers
