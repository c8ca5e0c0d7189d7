#include "renderers/impostor/tiles/block_compression.h"

#include <gtest/gtest.h>

#include <array>

namespace crowdbench::renderers {
namespace {

TEST(BlockCompression, CodesOfASingleChannelBlockByHand) {
  // Texel i has code i % 8; three bits each, the first texel lowest: 0xfac688 twice.
  const std::array<uint8_t, 8> falling = {210, 0, 0x88, 0xc6, 0xfa, 0x88, 0xc6, 0xfa};
  const std::array<uint8_t, 8> of_falling = {210, 0, 180, 150, 120, 90, 60, 30};
  const std::array<uint8_t, 8> rising = {0, 250, 0x88, 0xc6, 0xfa, 0x88, 0xc6, 0xfa};
  const std::array<uint8_t, 8> of_rising = {0, 250, 50, 100, 150, 200, 0, 255};
  for (size_t i = 0; i < 16; ++i) {
    EXPECT_EQ(decode_bc4(falling)[i], of_falling[i % 8]) << i;
    EXPECT_EQ(decode_bc4(rising)[i], of_rising[i % 8]) << i;
  }
}

TEST(BlockCompression, FourBitsHoldSevenIdsAndWhatIsNotLit) {
  EXPECT_EQ(slot_bits(0), 4);
  EXPECT_EQ(slot_bits(7), 4);
  EXPECT_EQ(slot_bits(8), 8);
  for (int left = 0; left < 8; ++left)
    for (int right = 0; right < 8; ++right)
      for (const int unlit : {0, int{kUnlitSlot}}) {
        const uint8_t packed = pack_slots(static_cast<uint8_t>(left), static_cast<uint8_t>(right | unlit));
        EXPECT_EQ(unpack_part(packed, false), left);
        EXPECT_EQ(unpack_part(packed, true), right | unlit);
      }
}

// A tile of 5 x 5 with its gutters has 7 x 7 texels and 2 x 2 blocks.
Tile tile_of(const std::array<uint8_t, 4>& albedo, const std::array<uint8_t, 4>& surface) {
  Tile tile;
  tile.rect = {-2, -2, 5, 5};
  tile.empty_alpha = 20;
  for (int i = 0; i < 49; ++i) {
    const int x = i % 7;
    const int y = i / 7;
    const bool covered = x > 1 && x < 4 && y > 1 && y < 4;
    tile.albedo.insert(tile.albedo.end(), albedo.begin(), albedo.begin() + 3);
    tile.albedo.push_back(covered ? albedo[3] : tile.empty_alpha);
    tile.surface.insert(tile.surface.end(), surface.begin(), surface.end());
  }
  return tile;
}

TEST(BlockCompression, ConstantMapsComeBack) {
  // 8 and 16 in five and six bits (1 of 31, 4 of 63) are what those decode to.
  const Tile tile = tile_of({8, 16, 255, 230}, {100, 200, 3, 77});
  const CompressedTile blocks = compress(tile);
  EXPECT_EQ(blocks.blocks_x, 2);
  EXPECT_EQ(blocks.blocks_y, 2);
  EXPECT_EQ(blocks.albedo.size(), 4U * 16);
  EXPECT_EQ(blocks.normal.size(), 4U * 16);
  EXPECT_EQ(blocks.depth.size(), 4U * 8);
  EXPECT_EQ(blocks.slots.size(), 64U);
  const Tile back = decompress(blocks, tile);
  const std::vector<bool> visible = visible_texels(tile);
  for (size_t i = 0; i < 49; ++i) {
    const size_t x = i % 7;
    const size_t y = i / 7;
    EXPECT_EQ(visible[i], x > 0 && x < 5 && y > 0 && y < 5);
    EXPECT_EQ(back.albedo[4 * i + 3], tile.albedo[4 * i + 3]);
    EXPECT_EQ(back.surface[4 * i + 2], 3);
    if (!visible[i]) continue;
    for (size_t c = 0; c < 3; ++c) EXPECT_NEAR(back.albedo[4 * i + c], tile.albedo[4 * i + c], 1);
    for (const size_t c : {0, 1, 3}) EXPECT_EQ(back.surface[4 * i + c], tile.surface[4 * i + c]);
  }
}

TEST(BlockCompression, IdsAreNeverMixedAndUnseenTexelsDoNotCount) {
  Tile tile = tile_of({200, 100, 50, 230}, {128, 128, 0, 128});
  for (size_t i = 0; i < 49; ++i) tile.surface[4 * i + 2] = static_cast<uint8_t>(i % 5 | (i % 2 ? kUnlitSlot : 0));
  const Tile before = decompress(compress(tile), tile);
  for (size_t i = 0; i < 49; ++i) EXPECT_EQ(before.surface[4 * i + 2], tile.surface[4 * i + 2]);
  // What nobody sees may be any colour.
  const std::vector<bool> visible = visible_texels(tile);
  for (size_t i = 0; i < 49; ++i)
    if (!visible[i]) tile.albedo[4 * i] = tile.surface[4 * i] = tile.surface[4 * i + 3] = 255;
  const Tile after = decompress(compress(tile), tile);
  for (size_t i = 0; i < 49; ++i) {
    if (!visible[i]) continue;
    for (size_t c = 0; c < 4; ++c) {
      EXPECT_EQ(after.albedo[4 * i + c], before.albedo[4 * i + c]);
      EXPECT_EQ(after.surface[4 * i + c], before.surface[4 * i + c]);
    }
  }
}

TEST(BlockCompression, EmissionIsABlockOfItsOwnWhereThereIsAny) {
  Tile tile = tile_of({8, 16, 255, 230}, {100, 200, 3, 77});
  EXPECT_TRUE(compress(tile).emission.empty());
  EXPECT_TRUE(decompress(compress(tile), tile).emission.empty());
  // 255, 130 and 0 are codes of five and six bits.
  for (int i = 0; i < 49; ++i) tile.emission.insert(tile.emission.end(), {255, 130, 0, 255});
  const CompressedTile blocks = compress(tile);
  EXPECT_EQ(blocks.emission.size(), 4U * 8);
  const Tile back = decompress(blocks, tile);
  const std::vector<bool> visible = visible_texels(tile);
  for (size_t i = 0; i < 49; ++i) {
    if (!visible[i]) continue;
    for (size_t c = 0; c < 4; ++c) EXPECT_EQ(back.emission[4 * i + c], tile.emission[4 * i + c]) << i;
  }
}

TEST(BlockCompression, AnEmptyTileHasNoBlocks) {
  const CompressedTile blocks = compress(Tile{});
  EXPECT_EQ(blocks.blocks_x, 0);
  EXPECT_TRUE(blocks.albedo.empty());
}

}  // namespace
}  // namespace crowdbench::renderers
