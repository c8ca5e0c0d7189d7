// Block compression of tiles: S3TC and RGTC blocks of 4 x 4 texels, made offline.
//
// Blocks are counted from the tile's lower left texel, gutters included, so that a tile that lies on a page at
// multiples of four shares no block with another: its bytes depend on itself alone.
#pragma once
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "renderers/impostor/tiles/tile.h"

namespace crowdbench::renderers {

inline constexpr int kBlock = 4;               // texels, along a side
inline constexpr int kColourBlockBytes = 16;   // BC3: colour and coverage
inline constexpr int kNormalBlockBytes = 16;   // BC5: x and y
inline constexpr int kDepthBlockBytes = 8;     // BC4
inline constexpr int kEmissionBlockBytes = 8;  // BC1

inline int blocks(int texels) { return (texels + kBlock - 1) / kBlock; }

// Tile::albedo as BC3 (GL_COMPRESSED_RGBA_S3TC_DXT5_EXT), Tile::surface as BC5 normals (GL_COMPRESSED_RG_RGTC2), BC4
// depth (GL_COMPRESSED_RED_RGTC1), BC1 emission where the tile has any (GL_COMPRESSED_SRGB_S3TC_DXT1_EXT) and, exactly
// as they were, one byte of material id a texel. Blocks row by row from the bottom; texels beyond the tile are
// anything, their ids 0.
struct CompressedTile {
  int blocks_x = 0;
  int blocks_y = 0;
  std::vector<uint8_t> albedo;
  std::vector<uint8_t> normal;
  std::vector<uint8_t> depth;
  std::vector<uint8_t> emission;
  std::vector<uint8_t> slots;  // (4 blocks_x) x (4 blocks_y)
};

// Colours, normals and depths are fitted to the texels that can be seen, those that are covered and their neighbours;
// coverage to all. Deterministic.
CompressedTile compress(const Tile& tile);

// What the GPU reads from the blocks, in the form of the tile they were made of.
Tile decompress(const CompressedTile& compressed, const Tile& shape);

// Texels of a tile (columns, then rows, gutters included) that can be seen: covered ones and their eight neighbours.
std::vector<bool> visible_texels(const Tile& tile);

// Eight codes of a BC4 block (half of a BC5 block, the first half of a BC3 one) for 16 texels, row by row.
std::array<uint8_t, 16> decode_bc4(std::span<const uint8_t> block);

// Material ids of four bits, two texels a byte, the left one in the low bits: ids 0 to 7, the top bit kUnlitSlot.
// Which of 4 and 8 bits hold the ids 0 to `largest`.
int slot_bits(int largest);
uint8_t pack_slots(uint8_t left, uint8_t right);
uint8_t unpack_part(uint8_t packed, bool right);

}  // namespace crowdbench::renderers
