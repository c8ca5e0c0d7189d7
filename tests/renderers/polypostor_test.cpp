#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <functional>
#include <numbers>
#include <set>
#include <span>

#include "core/error.h"
#include "renderers/impostor/tiles/tile_capture.h"
#include "renderers/polypostor/polypostor_bake.h"
#include "scene/cast/cast.h"
#include "scene/pose/normalise.h"
#include "tests/renderers/compare_captures.h"
#include "tests/renderers/gl_test_support.h"
#include "tests/support/cache_folder.h"
#include "tests/support/sanitized.h"

namespace crowdbench::renderers {
namespace {

namespace fs = std::filesystem;
using testing::add_agent;
using testing::card;
using testing::cast_of;
using testing::context;
using testing::frame_from;
using testing::frame_of_one;
using testing::iou;
using testing::make;
using testing::mean_colour_difference;
using testing::walker;
using PolypostorGl = testing::GlTest;

PolypostorBakeOptions small_bake() {
  PolypostorBakeOptions options;
  options.grid = parse_view_grid("sphere-4x1", 0, "test");
  options.frames.frames = 4;
  options.texels = 64;
  return options;
}

TEST_F(PolypostorGl, BytesDoNotDependOnThreads) {
  CROWDBENCH_SKIP_SANITIZED("PolypostorGl.BytesSurviveARoundTripAndDamageDoesNot");
  PolypostorBakeOptions options = small_bake();
  std::vector<std::vector<uint8_t>> bytes;
  for (const unsigned threads : {1U, 3U}) {
    options.threads = threads;
    bytes.push_back(
        serialise(bake_polypostor(context(), walker().characters[0], walker().banks[0], options, uint64_t{64} << 20)));
  }
  EXPECT_EQ(bytes[0], bytes[1]);
}

TEST_F(PolypostorGl, BytesSurviveARoundTripAndDamageDoesNot) {
  PolypostorBakeOptions options = small_bake();
  options.key = KeyChoice::two_keys;
  const PolypostorBake bake =
      bake_polypostor(context(), walker().characters[0], walker().banks[0], options, uint64_t{64} << 20);
  EXPECT_EQ(bake.parts, 14);
  EXPECT_EQ(bake.ranges_by_frame, 1U);
  const auto bytes = serialise(bake);
  const auto back = deserialise_polypostor(bytes);
  ASSERT_TRUE(back);
  EXPECT_EQ(serialise(*back), bytes);
  for (size_t n = 0; n < bytes.size(); n += bytes.size() / 97 + 1)
    EXPECT_FALSE(deserialise_polypostor(std::span(bytes).first(n))) << n;
  const auto damaged = [&](const std::function<void(PolypostorBake&)>& harm) {
    PolypostorBake b = bake;
    harm(b);
    return !deserialise_polypostor(serialise(b)).has_value();
  };
  EXPECT_TRUE(damaged([](PolypostorBake& b) { b.indices[5] = 60000; })) << "a corner that is not there";
  EXPECT_TRUE(damaged([](PolypostorBake& b) { b.ranges[0].indices += 1U << 30U; }));
  EXPECT_TRUE(damaged([](PolypostorBake& b) { b.sets.back().first_word += 1; })) << "a block past the end";
  EXPECT_TRUE(damaged([](PolypostorBake& b) { b.vertices[0].turn = 65535; }));
  EXPECT_TRUE(damaged([](PolypostorBake& b) { b.clips[0].frames = 400; }));
  EXPECT_TRUE(damaged([](PolypostorBake& b) { b.width *= 2; }));
  EXPECT_TRUE(bake.emission.empty());
  EXPECT_TRUE(damaged([](PolypostorBake& b) { b.emission_peak = 1.0F; })) << "a map that is not there";
  EXPECT_FALSE(damaged([](PolypostorBake& b) {
    b.emission_peak = 1.0F;
    b.emission = b.albedo;
  }));
}

TEST_F(PolypostorGl, LooksAsTheMeshInStoredFramesAndBetween) {
  CROWDBENCH_SKIP_SANITIZED("BytesSurviveARoundTripAndDamageDoesNot");
  const std::string common = ":views=sphere-4x1,frames=10";
  const auto polypostor = make(walker(), "polypostor" + common);
  const auto one = make(walker(), "polypostor" + common + ",key=most_visible");
  const auto first = make(walker(), "polypostor" + common + ",key=first");
  const auto two = make(walker(), "polypostor" + common + ",key=two_keys");
  const auto flat = make(walker(), "flat" + common);
  const auto mesh = make(walker(), "mesh");
  Renderer renderer(context(), walker());
  struct Score {
    double overlap = 0, colour = 0;
    void add(const Capture& test, const Capture& reference) {
      overlap += iou(test, reference) / 40;
      colour += mean_colour_difference(test, reference) / 40;
    }
  };
  Score enough;
  Score visible;
  Score of_first;
  Score of_two;
  double between = 0;
  double jumps = 0;
  for (int f = 0; f < 10; ++f)
    for (int a = 0; a < 4; ++a) {
      scene::Frame frame = frame_from(walker(), {.azimuth = a * 90.0, .phase = f / 10.0});
      const Capture stored = renderer.capture(frame, *mesh);
      const Capture shown = renderer.capture(frame, *polypostor);
      EXPECT_GE(iou(shown, stored), 0.85) << "frame " << f << ", view " << a;
      enough.add(shown, stored);
      visible.add(renderer.capture(frame, *one), stored);
      of_first.add(renderer.capture(frame, *first), stored);
      of_two.add(renderer.capture(frame, *two), stored);
      frame = frame_from(walker(), {.azimuth = a * 90.0, .phase = (f + 0.5) / 10});
      const Capture reference = renderer.capture(frame, *mesh);
      between += iou(renderer.capture(frame, *polypostor), reference) / 40;
      jumps += iou(renderer.capture(frame, *flat), reference) / 40;
    }
  EXPECT_GE(visible.overlap, 0.95);
  EXPECT_GE(between, jumps + 0.05) << "half-way, moving corners beat showing a stored frame";
  EXPECT_GE(between, enough.overlap - 0.005) << "corners have places of their own there";
  // As many keys as it takes are better than any fixed number here.
  EXPECT_GE(enough.overlap, visible.overlap);
  EXPECT_LE(enough.colour, visible.colour);
  // The key that looks best in all frames is worth its search, and two are better than one.
  EXPECT_GE(visible.overlap, of_first.overlap);
  EXPECT_LE(visible.colour, of_first.colour);
  EXPECT_GE(of_two.overlap, visible.overlap);
  EXPECT_LE(of_two.colour, visible.colour);
  RecordProperty("iou", std::to_string(visible.overlap) + " " + std::to_string(of_first.overlap) + " " +
                            std::to_string(of_two.overlap));
  RecordProperty("colour", std::to_string(visible.colour) + " " + std::to_string(of_first.colour) + " " +
                               std::to_string(of_two.colour));
}

// A card of 0.8 x 0.8 metres, half a metre in front of the plane: an eye two metres away sees it 4 / 3 as large there,
// and in the same colours.
TEST_F(PolypostorGl, ImagesAreWhatAnEyeSees) {
  const ViewBasis basis = parse_view_grid("sphere-4x1", 0, "test").basis(0);
  scene::Character c = card(0.8F, 0.8F, {0.9F, 0.4F, 0.2F, 1.0F});
  for (glm::vec3& p : c.mesh.positions) p += 0.5F * glm::vec3(basis.to_eye) - glm::vec3(0, 0.4F, 0);
  const scene::Cast cast = cast_of(std::move(c));
  const auto covered = [&](double eye) {
    TileCapture capture(context(), cast.characters[0], cast.banks[0], {.texel = 0.02, .range = 1, .eye = eye});
    glm::ivec2 size(0);
    const TileRect rect{-32, -32, 64, 64};
    capture.capture(std::vector<CaptureTile>{{cast.banks[0]->sample(0, 0.0), basis, rect}},
                    [&](std::span<const size_t>, std::span<const std::vector<CapturedTexel>> texels) {
                      for (int i = 0; i < rect.width; ++i) {
                        const auto at = [&](int x, int y) {
                          return texels[0][static_cast<size_t>(y * rect.width + x)].albedo[3] > 127 ? 1 : 0;
                        };
                        size += glm::ivec2(at(i, 32), at(32, i));
                      }
                    });
    return size;
  };
  EXPECT_EQ(covered(0), glm::ivec2(40, 40));
  const glm::ivec2 nearer = covered(2);
  EXPECT_NEAR(nearer.x, 40 * 4 / 3.0, 1);
  EXPECT_NEAR(nearer.y, 40 * 4 / 3.0, 1);
}

TEST_F(PolypostorGl, ACardThatTurnsIsItsOwnPicture) {
  // A card of one joint that turns in its own plane, seen from the front.
  scene::Character c = card(0.8F, 0.8F, {0.9F, 0.4F, 0.2F, 1.0F});
  for (glm::vec3& p : c.mesh.positions) p.y -= 0.4F;
  scene::Clip clip;
  clip.name = "turn";
  clip.end = 1;
  scene::Channel turn;
  turn.target = scene::Target::rotation;
  for (int k = 0; k <= 8; ++k) {
    const double half = std::numbers::pi * k / 8;
    turn.times.push_back(k / 8.0);
    for (const double v : {0.0, 0.0, std::sin(half), std::cos(half)}) turn.values.push_back(v);
  }
  clip.channels = {turn};
  c.clips = {clip};
  scene::normalise(c, {.height = std::nullopt});
  const scene::Cast cast = cast_of(std::move(c));
  const auto polypostor = make(cast, "polypostor:views=sphere-4x1,frames=8,texels=256");
  const auto mesh = make(cast, "mesh");
  Renderer renderer(context(), cast);
  for (int f = 0; f < 8; ++f) {
    scene::Frame frame = frame_of_one(12, 0, 160, 160, 6);
    frame.camera.target = {0, 0, 0};
    frame.origin = frame.camera.eye;
    add_agent(frame, cast, {0, 0, 0}, 1, f / 8.0);
    const Capture test = renderer.capture(frame, *polypostor);
    const Capture reference = renderer.capture(frame, *mesh);
    EXPECT_GE(iou(test, reference), 0.975) << f;
    // Lit alike: the normal turns with the card.
    EXPECT_NEAR(test.colour.at(80, 80)[0], reference.colour.at(80, 80)[0], 3) << f;
  }
}

TEST_F(PolypostorGl, ADamagedCacheIsBakedAnew) {
  const support::CacheFolder folder;
  const std::string spec = "polypostor:views=sphere-4x1,frames=2,texels=32";
  const auto picture = [&](bool cached) {
    const auto one = make(walker(), spec, {.use_cache = true});
    EXPECT_EQ(one->bake_info().cached, cached);
    EXPECT_GT(one->footprint().disk_bytes, 0U);
    return Renderer(context(), walker()).capture(frame_from(walker(), {.phase = 0.3}), *one);
  };
  const Capture fresh = picture(false);
  EXPECT_EQ(picture(true), fresh) << "what was stored draws the same";
  size_t entries = 0;
  for (const auto& entry : fs::directory_iterator(folder.bakes())) {
    if (entry.path().extension() != ".bake") continue;
    ++entries;
    std::fstream file(entry.path(), std::ios::in | std::ios::out | std::ios::binary);
    file.seekp(static_cast<std::streamoff>(fs::file_size(entry.path()) / 2));
    file.put('\x5a');
    file.put('\xa5');
  }
  EXPECT_EQ(entries, 1U);
  EXPECT_EQ(picture(false), fresh) << "damage is seen, and baked over";
  EXPECT_EQ(picture(true), fresh);
}

// A change of more than 16 code values of a channel, as `stability` counts them, when a pose is passed by a millionth
// of a cycle: which image a part shows may change there. Half of the pixels had the new one already.
TEST_F(PolypostorGl, ImagesFadeWhereStepsMeet) {
  CROWDBENCH_SKIP_SANITIZED("DebugPicturesDiffer");
  const auto drawn = make(walker(), "polypostor:views=sphere-4x1,frames=4,texels=64,key=two_keys");
  Renderer renderer(context(), walker());
  const auto changed = [&](double from, double to) {
    const Capture a = renderer.capture(frame_from(walker(), {.phase = from}), *drawn);
    const Capture b = renderer.capture(frame_from(walker(), {.phase = to}), *drawn);
    size_t n = 0;
    for (size_t i = 0; i < a.ids.data.size(); ++i) {
      int most = 0;
      for (size_t k = 0; k < 3; ++k)
        most = std::max(most, std::abs(int{a.colour.data[4 * i + k]} - int{b.colour.data[4 * i + k]}));
      n += most > 16 ? 1U : 0U;
    }
    return n;
  };
  constexpr int kPoses = 8;
  size_t faded = 0;
  for (int k = 0; k < kPoses; ++k) {
    const double pose = static_cast<double>(k) / kPoses;
    const double before = k == 0 ? 1.0 : pose;
    EXPECT_LE(changed(before - 5e-7, pose + 5e-7), 3U) << "pose " << k;
    faded += changed(before - 0.24 / kPoses, pose + 0.24 / kPoses);
  }
  EXPECT_GT(faded, 8U * 20) << "over the whole window the figure moves and its images change";
}

// Levels begin within the groups of slots that one compute unit places.
TEST_F(PolypostorGl, EveryAgentOfEveryLevelIsDrawn) {
  const auto drawn = make(walker(), "polypostor:views=sphere-4x1,frames=4,texels=64,key=two_keys");
  scene::Frame frame = frame_of_one(5, 1, 320, 240, 60);
  for (uint32_t id = 1; id <= 25; ++id) {
    const double away = 5 + 3.0 * (id % 5) * (id % 5);
    add_agent(frame, walker(), {0.055 * (id - 13.0) * away, 0, 5 - away}, id, 0.07 * id);
  }
  Renderer renderer(context(), walker());
  const Capture mesh = renderer.capture(frame, *make(walker(), "mesh"));
  const Capture capture = renderer.capture(frame, *drawn);
  size_t compared = 0;
  for (uint32_t id = 1; id <= 25; ++id) {
    if (std::count(mesh.ids.data.begin(), mesh.ids.data.end(), id) < 4) continue;
    ++compared;
    EXPECT_GT(std::count(capture.ids.data.begin(), capture.ids.data.end(), id), 0) << "agent " << id;
  }
  EXPECT_GT(compared, 20U);
}

TEST_F(PolypostorGl, DebugPicturesDiffer) {
  CROWDBENCH_SKIP_SANITIZED("ShaderVariantsGl");
  Renderer renderer(context(), walker());
  const scene::Frame frame = frame_from(walker(), {.phase = 0.3});
  std::vector<Capture> pictures;
  for (const char* debug : {"none", "wire", "lines", "parts", "stretch"}) {
    const auto one = make(walker(), std::string("polypostor:views=sphere-4x1,frames=4,texels=64,debug=") + debug);
    const Capture picture = renderer.capture(frame, *one);
    for (const Capture& before : pictures) EXPECT_NE(before.colour, picture.colour) << debug;
    pictures.push_back(picture);
  }
  EXPECT_EQ(pictures[3].ids, pictures[0].ids) << "paint does not change what is covered";
  std::set<std::array<bool, 3>> hues;
  for (size_t i = 0; i < pictures[3].ids.data.size(); ++i)
    if (pictures[3].ids.data[i] != 0) {
      const uint8_t* c = &pictures[3].colour.data[4 * i];
      hues.insert({c[0] > 150, c[1] > 150, c[2] > 150});
    }
  EXPECT_GE(hues.size(), 4U) << "parts are told apart by colour";
}

TEST_F(PolypostorGl, RefusesWhatItCannotHold) {
  EXPECT_THROW((void)make(walker(), "polypostor:views=sphere-4x1,frames=2,texels=64", {.budget = 10'000}), Error);
  EXPECT_THROW((void)make(walker(), "polypostor:parts=nobody"), Error);
}

}  // namespace
}  // namespace crowdbench::renderers
