// Levels of detail of the mesh, drawn: by triangles, share, error, and the file's own.
#include <gtest/gtest.h>

#include "core/error.h"
#include "scene/mannequin/mannequin.h"
#include "scene/pose/lod_mesh.h"
#include "tests/renderers/gl_test_support.h"

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
}

}  // namespace
}  // namespace crowdbench::renderers
