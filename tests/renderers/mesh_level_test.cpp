// Levels of detail of the mesh, drawn: by triangles, share, error, and the file's own; kept on disk.
#include "renderers/mesh/mesh_level.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <set>

#include "core/error.h"
#include "scene/mannequin/mannequin.h"
#include "scene/pose/lod_mesh.h"
#include "tests/renderers/gl_test_support.h"
#include "tests/support/cache_folder.h"

namespace crowdbench::renderers {
namespace {

using testing::cast_of;
using testing::context;
using testing::fact;
using testing::make;

class MeshLevelGl : public testing::GlTest {
 protected:
  static Capture draw(const scene::Cast& cast, Representation& representation, double azimuth, double phase) {
    Renderer renderer(context(), cast);
    return renderer.capture(testing::frame_from(cast, {.azimuth = azimuth, .phase = phase}), representation);
  }
  // Pixels that both cover over those that either does, the worst of some views and phases.
  static double overlap(const scene::Cast& cast, const std::string& spec) {
    const auto whole = make(cast, "mesh");
    const auto level = make(cast, spec);
    double worst = 1;
    for (const double azimuth : {0.0, 70.0, 200.0})
      for (const double phase : {0.1, 0.6}) {
        const Capture a = draw(cast, *whole, azimuth, phase);
        const Capture b = draw(cast, *level, azimuth, phase);
        double both = 0;
        double either = 0;
        for (size_t i = 0; i < a.ids.data.size(); ++i) {
          both += a.ids.data[i] != 0 && b.ids.data[i] != 0 ? 1 : 0;
          either += a.ids.data[i] != 0 || b.ids.data[i] != 0 ? 1 : 0;
        }
        worst = std::min(worst, both / either);
      }
    return worst;
  }
};

// Figures of 120 pixels. The bounds are just outside of what is reached.
TEST_F(MeshLevelGl, CoversWhatTheMeshCovers) {
  const scene::Cast cast = cast_of(scene::make_mannequin());
  EXPECT_GE(overlap(cast, "mesh:triangles=2000"), 0.97);
  EXPECT_GE(overlap(cast, "mesh:triangles=500"), 0.90);
  EXPECT_GE(overlap(cast, "mesh:triangles=200"), 0.79);
}

TEST_F(MeshLevelGl, DrawsFewerTrianglesAndSaysItsError) {
  const scene::Cast cast = cast_of(scene::make_mannequin({.triangles = 2200}));
  const auto level = make(cast, "mesh:ratio=0.25");
  const auto all = static_cast<double>(cast.characters[0]->triangles());
  EXPECT_NEAR(static_cast<double>(level->triangles(0)), all / 4, 2);
  EXPECT_LT(level->footprint().buffer_bytes, make(cast, "mesh")->footprint().buffer_bytes / 2);
  const BakeInfo info = level->bake_info();
  EXPECT_EQ(fact(info.facts, "triangles"), static_cast<double>(level->triangles(0)));
  EXPECT_EQ(fact(info.facts, "of_triangles"), all);
  const double error = fact(info.facts, "error_max_mm");
  EXPECT_GT(error, fact(info.facts, "error_rms_mm"));
  EXPECT_NEAR(fact(info.facts, "error_max_px_at_100_px"), error / (10 * cast.characters[0]->placement.height), 1e-9);
  EXPECT_GT(fact(info.facts, "meshoptimizer_max_mm"), 0);
  EXPECT_TRUE(info.notes.empty());
  EXPECT_TRUE(make(cast, "mesh")->bake_info().facts.empty());
  EXPECT_EQ(make(cast, "mesh:triangles=1")->bake_info().notes.size(), 1U) << "why it has more";
  const auto near = make(cast, "mesh:error=0.03");
  EXPECT_LE(fact(near->bake_info().facts, "error_max_mm"), 30);
  EXPECT_LT(near->triangles(0), cast.characters[0]->triangles());
}

TEST_F(MeshLevelGl, WhatAsksForNothingIsTheMesh) {
  const scene::Cast cast = cast_of(scene::make_mannequin({.triangles = 500}));
  const auto mesh = make(cast, "mesh");
  const Capture whole = draw(cast, *mesh, 30, 0.3);
  for (const char* spec : {"mesh:triangles=0", "mesh:ratio=0", "mesh:lod=0", "mesh:triangles=4000", "mesh:ratio=1"}) {
    const auto level = make(cast, spec);
    EXPECT_EQ(level->triangles(0), mesh->triangles(0)) << spec;
    EXPECT_EQ(draw(cast, *level, 30, 0.3), whole) << spec;
  }
}

TEST_F(MeshLevelGl, DrawsTheLevelsOfTheFile) {
  scene::Character character = scene::make_mannequin({.triangles = 2200});
  const scene::PoseBank bank(character, {character.placement.default_clip});
  character.levels = {scene::make_lod_mesh(character, bank, {.triangles = 800}).mesh,
                      scene::make_lod_mesh(character, bank, {.triangles = 300}).mesh};
  const scene::Cast cast = cast_of(std::move(character));
  EXPECT_EQ(make(cast, "mesh:lod=1")->triangles(0), 800U);
  const auto second = make(cast, "mesh:lod=2");
  EXPECT_EQ(second->triangles(0), 300U);
  EXPECT_EQ(draw(cast, *second, 30, 0.3), draw(cast, *make(cast, "mesh:triangles=300"), 30, 0.3));
  EXPECT_GT(fact(second->bake_info().facts, "error_max_mm"), 0);
  EXPECT_FALSE(second->bake_info().levels.at(0).meshoptimizer.has_value()) << "nobody simplified it";
  EXPECT_THROW(make(cast, "mesh:lod=3"), Error);
  EXPECT_THROW(make(cast_of(scene::make_mannequin({.triangles = 500})), "mesh:lod=1"), Error);
}

TEST_F(MeshLevelGl, TakesOneWayToSayHowCoarse) {
  const scene::Cast cast = cast_of(scene::make_mannequin({.triangles = 500}));
  for (const char* spec : {"mesh:triangles=100,ratio=0.1", "mesh:ratio=0.5,error=0.1", "mesh:lod=1,triangles=100",
                           "mesh:ratio=1.5", "mesh:triangles=-1", "mesh:error=x"})
    EXPECT_THROW(make(cast, spec), Error) << spec;
}

TEST_F(MeshLevelGl, IsPosedBeforehandToo) {
  const scene::Cast cast = cast_of(scene::make_mannequin({.triangles = 2200}));
  const auto rigid = make(cast, "rigid:poses=4,triangles=400");
  EXPECT_EQ(rigid->triangles(0), 400U);
  const auto level = make(cast, "mesh:triangles=400");
  const Capture a = draw(cast, *level, 30, 0.25);
  const Capture b = draw(cast, *rigid, 30, 0.25);
  size_t off = 0;
  for (size_t i = 0; i < a.ids.data.size(); ++i) off += a.ids.data[i] != b.ids.data[i] ? 1U : 0U;
  EXPECT_LE(off, 4U) << "in a stored pose they are one mesh, but for pixels on an edge";
}

// Of hybrids: three levels of which the middle one is simplified.
TEST_F(MeshLevelGl, IsALevelOfAHybrid) {
  const scene::Cast cast = cast_of(scene::make_mannequin({.triangles = 2200}));
  const std::string spec = "hybrid(mesh,hybrid(mesh:triangles=400,mesh:triangles=100,distance=20),distance=10)";
  EXPECT_EQ(parse_spec(spec).text(),
            "hybrid(mesh,hybrid((mesh:triangles=400),(mesh:triangles=100),distance=20),distance=10)");
  const auto hybrid = make(cast, spec);
  Renderer renderer(context(), cast);
  for (const auto& [distance, alone] :
       {std::pair{5.0, "mesh"}, {15.0, "mesh:triangles=400"}, {30.0, "mesh:triangles=100"}}) {
    scene::Frame frame = testing::frame_of_one(distance, 1.0, 120, 120, 20);
    testing::add_agent(frame, cast, {0, 0, 0}, 3, 0.3);
    EXPECT_EQ(renderer.capture(frame, *hybrid), renderer.capture(frame, *make(cast, alone))) << distance;
  }
  EXPECT_EQ(fact(hybrid->bake_info().facts, "far_near_triangles"), 400);
  ASSERT_EQ(hybrid->bake_info().levels.size(), 2U);
  EXPECT_EQ(hybrid->bake_info().levels[1].triangles, 100U);
}

// ---- kept on disk

size_t entries_in(const std::filesystem::path& folder) {
  return static_cast<size_t>(std::distance(std::filesystem::directory_iterator(folder), {}));
}

TEST_F(MeshLevelGl, IsReadFromTheCacheAndNotMadeAgain) {
  const support::CacheFolder folder;
  const scene::Cast cast = cast_of(scene::make_mannequin({.triangles = 2200}));
  const auto first = make(cast, "mesh:triangles=400", {.use_cache = true});
  const BakeInfo info = first->bake_info();
  EXPECT_FALSE(info.cached);
  EXPECT_GT(first->footprint().disk_bytes, 0U);
  const Capture picture = draw(cast, *first, 30, 0.3);
  const auto again = make(cast, "mesh:triangles=400", {.use_cache = true});
  EXPECT_TRUE(again->bake_info().cached);
  EXPECT_EQ(again->bake_info().cache_key, info.cache_key);
  EXPECT_EQ(again->bake_info().facts, info.facts) << "errors are kept as well";
  EXPECT_EQ(again->bake_info().levels.at(0).worst_clip, info.levels.at(0).worst_clip);
  EXPECT_EQ(draw(cast, *again, 30, 0.3), picture);
  EXPECT_EQ(make(cast, "rigid:poses=2,triangles=400", {.use_cache = true})->triangles(0), 400U);
  EXPECT_EQ(entries_in(folder.bakes()), 1U) << "whoever draws it";
  // Another level's entry in its place is what is drawn: nothing was simplified.
  const std::string other = make(cast, "mesh:triangles=300", {.use_cache = true})->bake_info().cache_key;
  const BakeCache cache(folder.bakes());
  ASSERT_GT(cache.store("mesh-level", info.cache_key, cache.load("mesh-level", other)->payload, 2.5), 0U);
  EXPECT_EQ(make(cast, "mesh:triangles=400", {.use_cache = true})->triangles(0), 300U);
  EXPECT_EQ(make(cast, "mesh:triangles=400")->triangles(0), 400U) << "without the cache";
}

TEST_F(MeshLevelGl, AnEntryThatIsNoLevelOfThisMeshIsMadeAnew) {
  const support::CacheFolder folder;
  const scene::Cast cast = cast_of(scene::make_mannequin({.triangles = 2200}));
  const scene::Cast small = cast_of(scene::make_mannequin({.triangles = 500}));
  const auto level_of = [](const scene::Cast& of) { return make(of, "mesh:triangles=300", {.use_cache = true}); };
  const std::string key = level_of(cast)->bake_info().cache_key;
  const std::string foreign = level_of(small)->bake_info().cache_key;
  const BakeCache cache(folder.bakes());
  std::vector<uint8_t> beyond = cache.load("mesh-level", key)->payload;
  for (size_t i = 16; i < 20; ++i) beyond[i] = 0xff;  // the first index
  for (const std::vector<uint8_t>& payload :
       {cache.load("mesh-level", foreign)->payload, beyond, std::vector<uint8_t>(100, 7), std::vector<uint8_t>{}}) {
    ASSERT_GT(cache.store("mesh-level", key, payload, 2.5), 0U);
    const auto made = level_of(cast);
    EXPECT_FALSE(made->bake_info().cached) << payload.size();
    EXPECT_EQ(made->triangles(0), 300U);
    EXPECT_TRUE(level_of(cast)->bake_info().cached) << "it was replaced";
  }
}

TEST(MeshLevelKey, IsOfTheOptionsTheClipsInUseAndTheFilesLevel) {
  scene::Character character = scene::make_mannequin({.triangles = 500});
  ASSERT_GE(character.clips.size(), 2U);
  character.levels = {character.mesh, character.mesh};
  character.levels[1].positions[0].x += 1;
  const scene::PoseBank walk(character, {0});
  std::set<std::string> keys;
  const std::vector<MeshLevelOptions> options = {{.request = {.triangles = 100}},
                                                 {.request = {.triangles = 101}},
                                                 {.request = {.ratio = 0.1}},
                                                 {.request = {.ratio = 0.2}},
                                                 {.request = {.error = 0.1}},
                                                 {.lod = 1},
                                                 {.lod = 2}};
  for (const MeshLevelOptions& one : options) keys.insert(mesh_level_key(character, walk, one));
  for (const scene::PoseBank& bank :
       {scene::PoseBank(character, {1}), scene::PoseBank(character, {0, 1}), scene::PoseBank(character, {-1}),
        scene::PoseBank::exact(character, 0, 0.1), scene::PoseBank::exact(character, 0, 0.2)})
    keys.insert(mesh_level_key(character, bank, options[0]));
  EXPECT_EQ(keys.size(), options.size() + 5);
  EXPECT_EQ(mesh_level_key(character, scene::PoseBank(character, {0}), options[0]),
            mesh_level_key(character, walk, options[0]));
  scene::Character other = character;
  other.content_hash += "0";
  EXPECT_NE(mesh_level_key(other, walk, options[0]), mesh_level_key(character, walk, options[0]));
}

// Without a driver, for those who ask what a level is.
TEST(MeshLevel, IsSaidByTheTypeOfTheReference) {
  const scene::Cast cast = cast_of(scene::make_mannequin({.triangles = 2200}));
  const auto level = [&](const char* spec) {
    return reference_type().level(parse_spec(spec), cast.characters[0], cast.banks[0],
                                  {.use_cache = false, .progress = false});
  };
  const auto made = level("mesh:triangles=400");
  ASSERT_TRUE(made.has_value());
  EXPECT_EQ(made->mesh.indices.size(), 3U * 400U);
  EXPECT_EQ(made->info.triangles, 400U);
  EXPECT_EQ(made->info.of_triangles, cast.characters[0]->triangles());
  EXPECT_GT(made->info.error.rms, 0);
  EXPECT_NEAR(made->info.pixels(60), made->info.error.max / cast.characters[0]->placement.height * 60, 1e-12);
  ASSERT_TRUE(made->info.meshoptimizer.has_value());
  EXPECT_GT(made->info.meshoptimizer->stated, 0);
  EXPECT_FALSE(level("mesh").has_value());
  EXPECT_THROW(level("mesh:triangles=9,ratio=0.5"), Error);
}

}  // namespace
}  // namespace crowdbench::renderers
