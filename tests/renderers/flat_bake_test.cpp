#include "renderers/flat/flat_bake.h"

#include <epoxy/gl.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <span>

#include "core/error.h"
#include "core/files.h"
#include "renderers/bake/bake_cache.h"
#include "renderers/flat/flat.h"
#include "renderers/gl/objects.h"
#include "tests/renderers/gl_test_support.h"
#include "tests/support/cache_folder.h"

namespace crowdbench::renderers {
namespace {

namespace fs = std::filesystem;
using testing::context;
using testing::frame_from;
using testing::make;
using testing::walker;
using FlatGl = testing::GlTest;

TEST(FlatBake, BytesSurviveARoundTripAndDamageDoesNot) {
  FlatBake bake;
  bake.frames = 2;
  bake.views = 1;
  bake.clips = {{0, 2}};
  FlatLevel level;
  level.width = 4;
  level.height = 4;
  level.layers = 1;
  level.tiles.resize(2);
  level.tiles[1].slope_x = 0.25F;
  level.outlines.resize(8);
  level.albedo.assign(64, 7);
  level.surface.assign(64, 9);
  bake.levels = {level};
  const auto bytes = serialise(bake);
  const auto back = deserialise_flat(bytes);
  ASSERT_TRUE(back);
  EXPECT_EQ(serialise(*back), bytes);
  EXPECT_EQ(back->levels[0].tiles[1].slope_x, 0.25F);
  for (size_t n = 0; n < bytes.size(); ++n) EXPECT_FALSE(deserialise_flat(std::span(bytes).first(n))) << n;
  bake.clips = {{1, 2}};  // a clip past the frames
  EXPECT_FALSE(deserialise_flat(serialise(bake)));
  bake.clips = {{0, 2}};
  ASSERT_TRUE(deserialise_flat(serialise(bake)));
  bake.slot_bits = 4;  // blocks that are not there
  EXPECT_FALSE(deserialise_flat(serialise(bake)));
  FlatLevel& compressed = bake.levels[0];
  compressed.albedo.resize(16);
  compressed.surface.clear();
  compressed.normal.resize(16);
  compressed.slots.resize(8);
  EXPECT_TRUE(deserialise_flat(serialise(bake)));
  compressed.depth.resize(8);
  EXPECT_TRUE(deserialise_flat(serialise(bake)));
  bake.slot_bits = 8;
  EXPECT_FALSE(deserialise_flat(serialise(bake))) << "ids of four bits";
  bake.slot_bits = 4;
  bake.emission_peak = 2.5F;  // a map that is not there
  EXPECT_FALSE(deserialise_flat(serialise(bake)));
  compressed.emission.resize(8);
  const auto glowing = serialise(bake);
  ASSERT_TRUE(deserialise_flat(glowing));
  EXPECT_EQ(deserialise_flat(glowing)->emission_peak, 2.5F);
  EXPECT_EQ(deserialise_flat(glowing)->levels[0].emission.size(), 8U);
  for (size_t n = 0; n < glowing.size(); ++n) EXPECT_FALSE(deserialise_flat(std::span(glowing).first(n))) << n;
  bake.motion_range = 0.25F;  // the only level has a motion map
  EXPECT_FALSE(deserialise_flat(serialise(bake)));
  compressed.motion.resize(64);
  const auto moving = serialise(bake);
  ASSERT_TRUE(deserialise_flat(moving));
  EXPECT_EQ(deserialise_flat(moving)->motion_range, 0.25F);
  EXPECT_EQ(deserialise_flat(moving)->texture_bytes(), bake.texture_bytes());
  for (size_t n = 0; n < moving.size(); ++n) EXPECT_FALSE(deserialise_flat(std::span(moving).first(n))) << n;
  EXPECT_EQ(motion_level(0, 1), 0U);
  EXPECT_EQ(motion_level(0, 4), 1U);
  EXPECT_EQ(motion_level(1, 4), 1U);
  EXPECT_EQ(motion_level(3, 4), 3U);
}

TEST(FlatBake, AccountingAgreesWithTheSource) {
  // 136 views of 85 texels, twelve a row, in 1024 x 1024 RGBA plus 1024 x 1024 RGB are 7 MiB; as blocks 1.5 MiB.
  ViewGrid grid;
  grid.azimuths = 17;
  grid.elevations = 8;
  const NominalFrame frame = nominal_frame(grid, 85);
  EXPECT_EQ(frame.side, 1024);
  EXPECT_EQ(frame.bytes, uint64_t{7} << 20);
  EXPECT_EQ(frame.compressed_bytes, uint64_t{3} << 19);
  EXPECT_EQ(nominal_frame(grid, 86).side, 2048) << "eleven a row are 121";
  grid.azimuths = 12;
  grid.elevations = 12;
  EXPECT_EQ(nominal_frame(grid, 85).side, 1024) << "144 views fill it";
  // Our own page of that size holds the same maps, the RGB one with a fourth channel.
  FlatLevel page;
  page.albedo.resize(1024 * 1024 * 4);
  page.surface.resize(1024 * 1024 * 4);
  EXPECT_EQ(page.texture_bytes() - uint64_t{1024} * 1024, frame.bytes);
}

TEST_F(FlatGl, BakesDoNotDependOnTheNumberOfThreads) {
  FlatBakeOptions options;
  options.grid.azimuths = 3;
  options.grid.elevations = 2;
  options.frames.frames = 2;
  options.texels = 48;
  const auto bake = [&](unsigned threads) {
    options.threads = threads;
    return serialise(bake_flat(context(), walker().characters[0], walker().banks[0], options, uint64_t{1} << 30));
  };
  for (const auto& [compressed, motion] : {std::pair(false, false), std::pair(true, false), std::pair(false, true)}) {
    options.compressed = compressed;
    options.motion = motion;
    const auto one = bake(1);
    EXPECT_EQ(bake(0), one) << "as many as the machine has";
    EXPECT_EQ(bake(2), one);
    EXPECT_EQ(bake(7), one);
  }
}

// What any option of the bake changes must change its key, and what only the drawing depends on must not.
TEST_F(FlatGl, TheCacheKeyHoldsWhatTheBytesDependOn) {
  const auto key = [](const std::string& spec) {
    return flat_cache_key(*walker().characters[0], *walker().banks[0], flat_bake_options(parse_spec(spec)), "r", "v");
  };
  const std::string plain = key("flat");
  for (const char* option : {"views=hemi-9", "el_min=-10", "frames=9", "texels=64", "quad=square", "plane=facing",
                             "corners=6", "compress=bc", "frames_between=move"})
    EXPECT_NE(key(std::string("flat:") + option), plain) << option;
  EXPECT_EQ(key("flat:frames_between=move"), key("flat:frames_between=move_blend"));
  for (const char* option : {"depth=nailboard", "blend=3", "floor=1", "frames_between=blend"})
    EXPECT_EQ(key(std::string("flat:") + option), plain) << option;
  EXPECT_NE(key("flat:compress=bc"), key("flat:compress=bc,depth=nailboard")) << "only nailboards need the depth map";
  FlatBakeOptions part = flat_bake_options(parse_spec("flat"));
  part.needed.assign(1360, 1);
  part.needed[7] = 0;
  EXPECT_NE(flat_cache_key(*walker().characters[0], *walker().banks[0], part, "r", "v"), plain);
}

TEST_F(FlatGl, TheCacheGivesTheSamePictureAndDamageIsRepaired) {
  support::CacheFolder folder;
  const std::string spec = "flat:views=sphere-4x2,frames=2,texels=48";
  Renderer renderer(context(), walker());
  const auto frame = frame_from(walker(), {.azimuth = 90});
  const auto draw = [&](bool expect_cached) {
    const auto flat = make(walker(), spec, {.use_cache = true});
    EXPECT_EQ(flat->bake_info().cached, expect_cached);
    EXPECT_GT(flat->footprint().disk_bytes, 0U);
    return renderer.capture(frame, *flat).colour;
  };
  const Image8 first = draw(false);
  EXPECT_EQ(draw(true), first);
  for (const auto& entry : fs::directory_iterator(folder.bakes())) {
    std::vector<uint8_t> bytes = read_file(entry.path());
    bytes[bytes.size() / 2] ^= 1;
    std::ofstream(entry.path(), std::ios::binary)
        .write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  }
  EXPECT_EQ(draw(false), first);
  EXPECT_EQ(draw(true), first);
}

TEST_F(FlatGl, AStaleEntryIsMadeAnewAndAFolderThatCannotBeWrittenStopsNothing) {
  support::CacheFolder folder;
  const std::string spec = "flat:views=sphere-4x1,frames=1,texels=32";
  Renderer renderer(context(), walker());
  const auto frame = frame_from(walker(), {});
  const auto first = make(walker(), spec, {.use_cache = true});
  const Image8 picture = renderer.capture(frame, *first).colour;
  // Sound by its checksum, under the right key, but not what this version writes.
  const std::vector<uint8_t> other_format(100, 7);
  ASSERT_GT(BakeCache(folder.bakes()).store("flat", first->bake_info().cache_key, other_format, 2.5), 0U);
  const auto again = make(walker(), spec, {.use_cache = true});
  EXPECT_FALSE(again->bake_info().cached);
  EXPECT_EQ(renderer.capture(frame, *again).colour, picture);
  EXPECT_TRUE(make(walker(), spec, {.use_cache = true})->bake_info().cached) << "it was replaced";
  // A file where the folder should be: nothing can be kept, by anybody.
  const fs::path file = folder / "no_folder";
  std::ofstream(file) << "not a folder";
  folder.use(file);
  const auto unkept = make(walker(), spec, {.use_cache = true});
  EXPECT_FALSE(unkept->bake_info().cached);
  EXPECT_EQ(unkept->footprint().disk_bytes, 0U);
  EXPECT_EQ(renderer.capture(frame, *unkept).colour, picture);
}

TEST_F(FlatGl, ABakeOverTheBudgetSaysWhatToLower) {
  try {
    make(walker(), "flat", {.budget = uint64_t{8} << 20});
    FAIL() << "8 MiB cannot be enough";
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find("136 views"), std::string::npos) << error.what();
    EXPECT_NE(std::string(error.what()).find("lower texels, frames or views"), std::string::npos) << error.what();
  }
}

// Bytes of every texture that the driver holds, as the driver says; of its first level.
uint64_t texture_bytes_of_driver() {
  uint64_t sum = 0;
  for (GLuint name = 1; name < 4096; ++name) {
    if (!glIsTexture(name)) continue;
    const auto level = [&](GLenum what) {
      GLint value = 0;
      glGetTextureLevelParameteriv(name, 0, what, &value);
      return static_cast<uint64_t>(value);
    };
    if (level(GL_TEXTURE_BUFFER_SIZE) != 0) continue;  // a buffer that is read as texels
    if (level(GL_TEXTURE_COMPRESSED) != 0) {
      sum += level(GL_TEXTURE_COMPRESSED_IMAGE_SIZE);
      continue;
    }
    const uint64_t bits = level(GL_TEXTURE_RED_SIZE) + level(GL_TEXTURE_GREEN_SIZE) + level(GL_TEXTURE_BLUE_SIZE) +
                          level(GL_TEXTURE_ALPHA_SIZE);
    sum += level(GL_TEXTURE_WIDTH) * level(GL_TEXTURE_HEIGHT) * level(GL_TEXTURE_DEPTH) * bits / 8;
  }
  return sum;
}

// What the accounting takes the blocks of the source's page to be is what the driver allocates for them.
TEST_F(FlatGl, TheSourcesPageHasTheBytesOfTheDriver) {
  const uint64_t before = texture_bytes_of_driver();
  const auto rgba = gl::Texture::make_2d(context(), GL_COMPRESSED_RGBA_S3TC_DXT5_EXT, 1024, 1024);
  const auto rgb = gl::Texture::make_2d(context(), GL_COMPRESSED_RGB_S3TC_DXT1_EXT, 1024, 1024);
  EXPECT_EQ(texture_bytes_of_driver() - before, uint64_t{3} << 19);
  EXPECT_EQ(rgba.bytes() + rgb.bytes(), uint64_t{3} << 19);
}

TEST_F(FlatGl, BytesAreCountedExactly) {
  uint64_t rgba8 = 0;
  for (const char* how : {"", ",compress=bc", ",compress=bc,depth=nailboard"}) {
    const gl::Allocated before = context().allocated();
    const uint64_t driver_before = texture_bytes_of_driver();
    const auto flat = make(walker(), std::string("flat:views=sphere-4x1,frames=2,texels=64") + how);
    const Footprint bytes = flat->footprint();
    EXPECT_EQ(context().allocated().texture_bytes - before.texture_bytes, bytes.texture_bytes) << how;
    EXPECT_EQ(context().allocated().buffer_bytes - before.buffer_bytes, bytes.buffer_bytes) << how;
    EXPECT_EQ(texture_bytes_of_driver() - driver_before, bytes.texture_bytes) << how;
    EXPECT_EQ(bytes.disk_bytes, 0U);
    // 20 bits a texel for 64, 24 with depths; tiles at multiples of four take more room, the smallest most.
    if (rgba8 == 0)
      rgba8 = bytes.texture_bytes;
    else
      EXPECT_LT(bytes.texture_bytes, rgba8 / 2) << how;
  }
}

}  // namespace
}  // namespace crowdbench::renderers
