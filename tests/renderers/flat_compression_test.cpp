// Flat impostors stored as blocks.
#include <epoxy/gl.h>
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "renderers/flat/flat.h"
#include "renderers/flat/flat_bake.h"
#include "renderers/gl/objects.h"
#include "renderers/impostor/tiles/block_compression.h"
#include "scene/cast/cast.h"
#include "scene/mannequin/mannequin.h"
#include "tests/renderers/compare_captures.h"
#include "tests/renderers/gl_test_support.h"

namespace crowdbench::renderers {
namespace {

using testing::add_agent;
using testing::cast_of;
using testing::context;
using testing::frame_from;
using testing::frame_of_one;
using testing::iou;
using testing::make;
using testing::walker;
using testing::worst_colour_difference;
using FlatGl = testing::GlTest;

constexpr double kDegrees = std::numbers::pi / 180;

// The same bake as texels and as blocks, both read back from the driver, which decodes the blocks itself: what
// compression costs every map, over the texels that pass the alpha test.
TEST_F(FlatGl, CompressionKeepsEveryMapWithinItsTolerance) {
  const scene::Cast cast = cast_of(scene::make_mannequin({.triangles = 2200}));
  FlatBakeOptions options = flat_bake_options(parse_spec("flat:views=sphere-5x2,frames=2,texels=128"));
  const auto bake = [&](bool compressed) {
    options.compressed = compressed;
    options.depth = true;
    return bake_flat(context(), cast.characters[0], cast.banks[0], options, uint64_t{1} << 30);
  };
  const FlatBake plain = bake(false);
  const FlatBake blocks = bake(true);
  ASSERT_EQ(blocks.slot_bits, 4) << "five materials";
  ASSERT_EQ(blocks.levels.size(), plain.levels.size());
  for (size_t l = 0; l < plain.levels.size(); ++l) {
    const FlatLevel& a = plain.levels[l];
    const FlatLevel& b = blocks.levels[l];
    const auto decode = [&](unsigned internal, unsigned format, size_t channels, const std::vector<uint8_t>& data) {
      gl::Texture texture = gl::Texture::make_array(context(), internal, b.width, b.height, b.layers, 1);
      const size_t layer = data.size() / static_cast<size_t>(b.layers);
      for (int i = 0; i < b.layers; ++i) texture.write(0, i, 0, 0, data.data() + static_cast<size_t>(i) * layer);
      GLint size = 0;
      glGetTextureLevelParameteriv(texture.name(), 0, GL_TEXTURE_COMPRESSED_IMAGE_SIZE, &size);
      EXPECT_EQ(static_cast<size_t>(size), data.size());
      EXPECT_EQ(texture.bytes(), data.size());
      std::vector<uint8_t> out(channels * static_cast<size_t>(b.width * b.height * b.layers));
      texture.read(0, format, GL_UNSIGNED_BYTE, out.data(), out.size());
      return out;
    };
    const auto albedo = decode(GL_COMPRESSED_RGBA_S3TC_DXT5_EXT, GL_RGBA, 4, b.albedo);
    const auto normal = decode(GL_COMPRESSED_RG_RGTC2, GL_RG, 2, b.normal);
    const auto depth = decode(GL_COMPRESSED_RED_RGTC1, GL_RED, 1, b.depth);
    const auto texel = [](const FlatLevel& level, const FlatTile& tile, int x, int y) {
      return (static_cast<size_t>(tile.layer) * static_cast<size_t>(level.height) +
              static_cast<size_t>(y + static_cast<int>(tile.offset_y))) *
                 static_cast<size_t>(level.width) +
             static_cast<size_t>(x + static_cast<int>(tile.offset_x));
    };
    double colour_error = 0;
    double angle = 0;
    double depth_error = 0;
    double area_plain = 0;
    double area_blocks = 0;
    double worst_tile = 0;
    size_t n = 0;
    size_t other_ids = 0;
    size_t tested_ids = 0;
    for (size_t t = 0; t < a.tiles.size(); ++t) {
      if (a.tiles[t].covered == 0) continue;
      const auto alpha_plain = [&](int x, int y) { return double{1.0} * a.albedo[4 * texel(a, a.tiles[t], x, y) + 3]; };
      const auto alpha_blocks = [&](int x, int y) { return double{1.0} * albedo[4 * texel(b, b.tiles[t], x, y) + 3]; };
      double here_plain = 0;
      double here_blocks = 0;
      const FlatTile& tile = a.tiles[t];
      for (int y = static_cast<int>(tile.low_y) - 1; y < static_cast<int>(tile.high_y); ++y)
        for (int x = static_cast<int>(tile.low_x) - 1; x < static_cast<int>(tile.high_x); ++x) {
          const size_t i = texel(a, a.tiles[t], x, y);
          const size_t j = texel(b, b.tiles[t], x, y);
          const uint8_t packed = b.slots[j / 2];
          other_ids += unpack_part(packed, j % 2 == 1) != a.surface[4 * i + 2];
          ++tested_ids;
          // The filtered alpha between four texels, at 4 x 4 points.
          const auto area = [&](const auto& alpha) {
            double in = 0;
            const double p = alpha(x, y), q = alpha(x + 1, y), r = alpha(x, y + 1), s = alpha(x + 1, y + 1);
            for (int k = 0; k < 16; ++k) {
              const double u = (k % 4 + 0.5) / 4;
              const int row = k / 4;
              const double v = (row + 0.5) / 4;
              in += (p * (1 - u) + q * u) * (1 - v) + (r * (1 - u) + s * u) * v >= 127.5 ? 1.0 / 16 : 0.0;
            }
            return in;
          };
          here_plain += area(alpha_plain);
          here_blocks += area(alpha_blocks);
          if (a.albedo[4 * i + 3] < 128) continue;
          ++n;
          for (size_t c = 0; c < 3; ++c) {
            const double d = double{1.0} * a.albedo[4 * i + c] - albedo[4 * j + c];
            colour_error += d * d / 3;
          }
          const auto unit = [](uint8_t cx, uint8_t cy) {
            const double nx = decode_signed(cx);
            const double ny = decode_signed(cy);
            return glm::normalize(glm::dvec3(nx, ny, std::sqrt(std::max(0.0, 1 - nx * nx - ny * ny))));
          };
          angle += std::acos(std::min(
              1.0, glm::dot(unit(a.surface[4 * i], a.surface[4 * i + 1]), unit(normal[2 * j], normal[2 * j + 1]))));
          depth_error += std::abs(int{a.surface[4 * i + 3]} - int{depth[j]}) / 127.0 * plain.radius;
        }
      area_plain += here_plain;
      area_blocks += here_blocks;
      if (here_plain > 0) worst_tile = std::max(worst_tile, std::abs(here_blocks / here_plain - 1));
    }
    ASSERT_GT(n, 0U);
    const double psnr = 10 * std::log10(255.0 * 255.0 * static_cast<double>(n) / colour_error);
    const double degrees = angle / static_cast<double>(n) / kDegrees;
    const double texels = depth_error / static_cast<double>(n) / (plain.texel * std::exp2(static_cast<double>(l)));
    fmt::print(
        "level {}: albedo {:.1f} dB, normals {:.2f} degrees, depths {:.2f} texels, area {:+.2f} %, {:.2f} % at worst\n",
        l, psnr, degrees, texels, 100 * (area_blocks / area_plain - 1), 100 * worst_tile);
    EXPECT_EQ(other_ids, 0U) << "of " << tested_ids << " at level " << l;
    // A block is four texels across a figure that has 128, 64, 32 or 16: the coarser, the more limbs and colours on
    // the one line of eight (normals) or four (colours) values that it can hold.
    constexpr double kLeastPsnr[] = {35, 32, 31, 26};
    constexpr double kMostDegrees[] = {2.5, 3.5, 4, 4};
    ASSERT_LT(l, std::size(kLeastPsnr));
    EXPECT_GT(psnr, kLeastPsnr[l]);
    EXPECT_LT(degrees, kMostDegrees[l]);
    EXPECT_LT(texels, 0.5);
    EXPECT_NEAR(area_blocks / area_plain, 1, 0.002);
    EXPECT_LT(worst_tile, 0.05);
  }
}

// Whichever way the tiles are stored: the same pixels but for a few on the border, the same outfit by the same ids.
TEST_F(FlatGl, CompressedTilesAreDrawnAsTheOthers) {
  const std::string common = "flat:views=sphere-5x2,frames=2,texels=96";
  Renderer renderer(context(), walker());
  for (const char* how : {"", ",depth=nailboard", ",blend=3", ",blend=3,depth=nailboard", ",floor=1"}) {
    const auto plain = make(walker(), common + how);
    const auto blocks = make(walker(), common + ",compress=bc" + how);
    EXPECT_LT(blocks->footprint().texture_bytes, 0.5 * static_cast<double>(plain->footprint().texture_bytes));
    for (const double azimuth : {0.0, 50.0, 200.0}) {
      const auto frame = frame_from(walker(), {.azimuth = azimuth, .elevation = 12, .phase = 0.5});
      const Capture a = renderer.capture(frame, *plain);
      const Capture b = renderer.capture(frame, *blocks);
      EXPECT_GT(iou(a, b), 0.98) << how;
      double off = 0;
      double depth_off = 0;
      size_t n = 0;
      for (size_t i = 0; i < a.ids.data.size(); ++i) {
        if (a.ids.data[i] == 0 || b.ids.data[i] == 0) continue;
        ++n;
        for (size_t k = 0; k < 3; ++k)
          off += std::abs(int{a.colour.data[4 * i + k]} - int{b.colour.data[4 * i + k]}) / 3.0;
        depth_off += std::abs(a.depth.data[i] - b.depth.data[i]);
      }
      EXPECT_LT(off / static_cast<double>(n), 5) << how << ": code values";
      EXPECT_LT(depth_off / static_cast<double>(n), plain->texel_metres(0)) << how;
    }
  }
}

// Ids beyond seven take a byte each, and the bit of what is not lit travels with both kinds.
TEST_F(FlatGl, CompressedIdsSelectTheOutfitAndTheLighting) {
  for (const bool unlit : {false, true})
    for (const uint8_t slot : {uint8_t{5}, uint8_t{9}}) {
      scene::Character character = testing::card(1, 1, glm::vec4(1.0F));
      for (scene::Material& material : character.materials) {
        material.slot = slot;
        material.unlit = unlit;
      }
      const scene::Cast cast = cast_of(std::move(character));
      const auto mesh = make(cast, "mesh");
      const auto flat = make(cast, "flat:views=sphere-1x1,texels=64,compress=bc");
      Renderer renderer(context(), cast);
      scene::Frame frame = frame_of_one(3, 0.5, 96, 96);
      scene::Outfit outfit;
      for (size_t i = 0; i < outfit.colours.size(); ++i)
        outfit.colours[i] = i == slot ? glm::vec4(0.1F, 1.0F, 0.3F, 1) : glm::vec4(1, 0, 0, 1);
      frame.outfits.push_back(outfit);
      add_agent(frame, cast, {0, 0, 0}, 1);
      frame.agents[0][0].outfit = 1;
      const Capture a = renderer.capture(frame, *mesh);
      const Capture b = renderer.capture(frame, *flat);
      EXPECT_GT(iou(a, b), 0.95);
      EXPECT_LE(worst_colour_difference(a, b), 1)
          << "slot " << int{slot} << ", unlit " << unlit << ": white survives compression";
    }
}

}  // namespace
}  // namespace crowdbench::renderers
