// The blocks' colours are fitted by libsquish (cluster fit: Brown 2006). Differs from calling it on a whole image:
// tiles share no block, and only texels that can be seen count.
#include "renderers/impostor/tiles/block_compression.h"

#include <squish.h>

#include <algorithm>
#include <cassert>

namespace crowdbench::renderers {
namespace {

// 16 RGBA texels; bit i of a mask is texel i.
using Texels = std::array<uint8_t, 64>;

struct BlockMasks {
  int inside = 0;   // texels of the tile
  int visible = 0;  // of those, the ones that can be seen
};

}  // namespace

std::vector<bool> visible_texels(const Tile& tile) {
  const int width = tile.stride();
  const int height = tile.rows();
  const auto at = [&](int x, int y) {
    return static_cast<size_t>(y) * static_cast<size_t>(width) + static_cast<size_t>(x);
  };
  std::vector<bool> visible(at(0, height));
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      if (tile.albedo[4 * at(x, y) + 3] <= tile.empty_alpha) continue;
      for (int j = std::max(y - 1, 0); j <= std::min(y + 1, height - 1); ++j)
        for (int i = std::max(x - 1, 0); i <= std::min(x + 1, width - 1); ++i) visible[at(i, j)] = true;
    }
  return visible;
}

CompressedTile compress(const Tile& tile) {
  CompressedTile out;
  if (tile.rect.width == 0) return out;
  const int width = tile.stride();
  const int height = tile.rows();
  out.blocks_x = blocks(width);
  out.blocks_y = blocks(height);
  const auto count = static_cast<size_t>(out.blocks_x) * static_cast<size_t>(out.blocks_y);
  out.albedo.resize(count * kColourBlockBytes);
  out.normal.resize(count * kNormalBlockBytes);
  out.depth.resize(count * kDepthBlockBytes);
  out.slots.resize(count * kBlock * kBlock);
  if (!tile.emission.empty()) out.emission.resize(count * kEmissionBlockBytes);
  const std::vector<bool> visible = visible_texels(tile);
  size_t block = 0;
  for (int by = 0; by < out.blocks_y; ++by)
    for (int bx = 0; bx < out.blocks_x; ++bx, ++block) {
      Texels albedo{};
      Texels surface{};
      Texels depth{};
      Texels emission{};
      BlockMasks masks;
      for (int i = 0; i < kBlock * kBlock; ++i) {
        const int x = bx * kBlock + i % kBlock;
        const int y = by * kBlock + i / kBlock;
        if (x >= width || y >= height) continue;
        const auto texel = static_cast<size_t>(y) * static_cast<size_t>(width) + static_cast<size_t>(x);
        const auto o = static_cast<size_t>(4 * i);
        masks.inside |= 1 << i;
        if (visible[texel]) masks.visible |= 1 << i;
        std::copy_n(&tile.albedo[4 * texel], 4, &albedo[o]);
        std::copy_n(&tile.surface[4 * texel], 4, &surface[o]);
        depth[o] = surface[o + 3];
        if (!tile.emission.empty()) std::copy_n(&tile.emission[4 * texel], 4, &emission[o]);
        out.slots[static_cast<size_t>(y) * static_cast<size_t>(out.blocks_x * kBlock) + static_cast<size_t>(x)] =
            surface[o + 2];
      }
      // A BC3 block is its coverage and then its colours; each is fitted to texels of its own.
      std::array<uint8_t, kColourBlockBytes> fitted{};
      uint8_t* to = &out.albedo[block * kColourBlockBytes];
      squish::CompressMasked(albedo.data(), masks.inside, fitted.data(), squish::kDxt5 | squish::kColourRangeFit);
      std::copy_n(fitted.begin(), 8, to);
      if (masks.visible == 0) continue;
      squish::CompressMasked(albedo.data(), masks.visible, fitted.data(), squish::kDxt5 | squish::kColourClusterFit);
      std::copy_n(fitted.begin() + 8, 8, to + 8);
      squish::CompressMasked(surface.data(), masks.visible, &out.normal[block * kNormalBlockBytes], squish::kBc5);
      squish::CompressMasked(depth.data(), masks.visible, &out.depth[block * kDepthBlockBytes], squish::kBc4);
      if (!tile.emission.empty())
        squish::CompressMasked(emission.data(), masks.visible, &out.emission[block * kEmissionBlockBytes],
                               squish::kDxt1 | squish::kColourClusterFit);
    }
  return out;
}

std::array<uint8_t, 16> decode_bc4(std::span<const uint8_t> block) {
  assert(block.size() >= 8);
  const int low = block[0];
  const int high = block[1];
  std::array<int, 8> codes = {low, high, 0, 0, 0, 0, 0, 255};
  const int steps = low > high ? 7 : 5;
  for (int i = 1; i < steps; ++i)
    codes[static_cast<size_t>(i + 1)] = ((steps - i) * low + i * high + steps / 2) / steps;
  uint64_t bits = 0;
  for (size_t i = 0; i < 6; ++i) bits |= uint64_t{block[2 + i]} << (8 * i);
  std::array<uint8_t, 16> out{};
  for (size_t i = 0; i < 16; ++i) out[i] = static_cast<uint8_t>(codes[bits >> (3 * i) & 7]);
  return out;
}

Tile decompress(const CompressedTile& compressed, const Tile& shape) {
  Tile out = shape;
  if (shape.rect.width == 0) return out;
  const int width = shape.stride();
  const int height = shape.rows();
  size_t block = 0;
  for (int by = 0; by < compressed.blocks_y; ++by)
    for (int bx = 0; bx < compressed.blocks_x; ++bx, ++block) {
      const std::span normals(&compressed.normal[block * kNormalBlockBytes], kNormalBlockBytes);
      Texels albedo{};
      Texels emission{};
      if (!compressed.emission.empty())
        squish::Decompress(emission.data(), &compressed.emission[block * kEmissionBlockBytes], squish::kDxt1);
      squish::Decompress(albedo.data(), &compressed.albedo[block * kColourBlockBytes], squish::kDxt5);
      const auto alpha = decode_bc4(std::span(&compressed.albedo[block * kColourBlockBytes], 8));
      const auto x_codes = decode_bc4(normals.first(8));
      const auto y_codes = decode_bc4(normals.subspan(8));
      const auto depths = decode_bc4(std::span(&compressed.depth[block * kDepthBlockBytes], kDepthBlockBytes));
      for (size_t i = 0; i < kBlock * kBlock; ++i) {
        const int x = bx * kBlock + static_cast<int>(i) % kBlock;
        const int y = by * kBlock + static_cast<int>(i) / kBlock;
        if (x >= width || y >= height) continue;
        const size_t o = 4 * (static_cast<size_t>(y) * static_cast<size_t>(width) + static_cast<size_t>(x));
        std::copy_n(&albedo[4 * i], 3, &out.albedo[o]);
        out.albedo[o + 3] = alpha[i];
        out.surface[o] = x_codes[i];
        out.surface[o + 1] = y_codes[i];
        out.surface[o + 2] =
            compressed.slots[static_cast<size_t>(y) * static_cast<size_t>(compressed.blocks_x * kBlock) +
                             static_cast<size_t>(x)];
        out.surface[o + 3] = depths[i];
        if (!compressed.emission.empty()) std::copy_n(&emission[4 * i], 4, &out.emission[o]);
      }
    }
  return out;
}

int slot_bits(int largest) { return largest < 8 ? 4 : 8; }

uint8_t pack_slots(uint8_t left, uint8_t right) {
  const auto code = [](uint8_t slot) {
    assert((slot & 0x78) == 0);
    return (slot & 7) | (slot & kUnlitSlot) >> 4;
  };
  return static_cast<uint8_t>(code(left) | code(right) << 4);
}

uint8_t unpack_part(uint8_t packed, bool right) {
  const int code = right ? packed >> 4 : packed & 15;
  return static_cast<uint8_t>((code & 7) | (code & 8) << 4);
}

}  // namespace crowdbench::renderers
