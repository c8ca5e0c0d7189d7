#include "renderers/preskinned/preskinned.h"

#include <gtest/gtest.h>

#include <cmath>

#include "renderers/frame/frame_resources.h"
#include "renderers/gl/counters.h"
#include "renderers/mesh/skinned_buffer.h"
#include "scene/cast/cast.h"
#include "scene/mannequin/mannequin.h"
#include "tests/renderers/compare_captures.h"
#include "tests/renderers/gl_test_support.h"

namespace crowdbench::renderers {
namespace {

using testing::add_agent;
using testing::cast_of;
using testing::context;
using testing::covered;
using testing::different_ids;
using testing::frame_of_one;
using testing::GlTest;
using testing::make;
using testing::walker;
using testing::worst_colour_difference;

class PreskinnedGl : public GlTest {};

// A row of agents in different poses, scales and headings.
scene::Frame row_of(const scene::Cast& cast, int agents) {
  scene::Frame frame = frame_of_one(14, 1.2, 480, 96, 14);
  for (int i = 0; i < agents; ++i)
    add_agent(frame, cast, {0.9 * (i % 20) - 8.5, 0, -1.5 * (i / 20)}, static_cast<uint32_t>(i + 1),
              0.1 * ((7 * i) % 10), 0.13F * static_cast<float>(i), 0.8F + 0.02F * static_cast<float>(i % 20));
  return frame;
}

Capture draw(const scene::Cast& cast, const scene::Frame& frame, const std::string& spec) {
  Renderer renderer(context(), cast);
  return renderer.capture(frame, *make(cast, spec));
}

// The same sums in the same order; normals are rounded to 16 bits on their way, which a grey level's edge may see.
TEST_F(PreskinnedGl, DrawsWhatTheMeshDraws) {
  const scene::Frame frame = row_of(walker(), 20);
  const Capture mesh = draw(walker(), frame, "mesh");
  const Capture test = draw(walker(), frame, "preskinned");
  EXPECT_GT(covered(mesh), 2000U);
  EXPECT_LE(different_ids(mesh, test), 2U);
  EXPECT_LE(worst_colour_difference(mesh, test), 2);
}

// One MiB holds 21 posed meshes of 3,000 vertices: agents after those are skinned into the same slots.
TEST_F(PreskinnedGl, BatchesDrawEveryAgentInItsOwnPose) {
  const scene::Cast cast = cast_of(scene::make_mannequin({.triangles = 5000}));
  const scene::Frame frame = row_of(cast, 40);
  const Capture whole = draw(cast, frame, "preskinned");
  EXPECT_EQ(draw(cast, frame, "preskinned:block=1"), whole);
  const auto batched = make(cast, "preskinned:block=1");
  const uint64_t before = batched->footprint().buffer_bytes;
  Renderer renderer(context(), cast);
  (void)renderer.capture(frame, *batched);
  const uint64_t grown = batched->footprint().buffer_bytes - before;
  EXPECT_GT(grown, uint64_t{900} << 10U) << "or all fitted at once";
  EXPECT_LE(grown, uint64_t{1} << 20U);
}

// Passes that write depth first leave the picture as it is, and are drawn: vertices are run as often as there are
// passes, skinned each time by the mesh and once by the buffer.
TEST_F(PreskinnedGl, PassesShowTheSameAndCostTheirVertices) {
  const scene::Frame frame = row_of(walker(), 20);
  for (const std::string name : {"mesh", "preskinned"}) {
    EXPECT_EQ(draw(walker(), frame, name + ":passes=3"), draw(walker(), frame, name)) << name;
    const auto invocations = [&](int passes) {
      const auto one = make(walker(), name + ":passes=" + std::to_string(passes));
      Renderer renderer(context(), walker());
      const Target target(context(), frame.width, frame.height, {});
      renderer.draw(frame, *one, target);
      gl::PipelineCounter counter(context());
      counter.begin();
      renderer.draw(frame, *one, target);
      counter.end();
      return counter.result();
    };
    const gl::PipelineCounts once = invocations(1);
    const gl::PipelineCounts thrice = invocations(3);
    if (!once.primitives_submitted || !once.compute_invocations) GTEST_SKIP() << "GL_ARB_pipeline_statistics_query";
    EXPECT_EQ(*thrice.primitives_submitted, 3 * *once.primitives_submitted) << name;
    EXPECT_EQ(*thrice.compute_invocations, *once.compute_invocations) << name;
  }
}

TEST_F(PreskinnedGl, MasksAndCrossFadesHoldInEveryPass) {
  scene::Character character = scene::make_mannequin({.triangles = 500});
  character.mesh.uvs.assign(character.mesh.positions.size(), glm::vec2(0.5F));
  scene::Texture texture;
  texture.image = Image8(4, 4, 4);
  character.images = {texture};
  character.materials[0].base_colour_image = 0;
  character.materials[0].alpha_cutoff = 0.5F;  // none of it is there
  const scene::Cast cast = cast_of(character);
  const scene::Frame frame = row_of(cast, 5);
  const Capture mesh = draw(cast, frame, "mesh");
  EXPECT_LT(covered(mesh), covered(draw(cast_of(scene::make_mannequin({.triangles = 500})), frame, "mesh")));
  EXPECT_EQ(draw(cast, frame, "preskinned:passes=2").ids, mesh.ids);
  const auto one = make(walker(), "preskinned:passes=2");
  Renderer renderer(context(), walker());
  const scene::Frame faded = row_of(walker(), 5);
  const Target target(context(), faded.width, faded.height, {.ids = true, .dithered = true});
  scene::Frame empty = faded;
  empty.agents[0].clear();
  renderer.draw(empty, *one, target);
  renderer.resources().upload(faded);
  renderer.resources().set_dither({0.0F, 0.5F});
  one->draw(faded, renderer.resources(), all_agents(faded), target.pass());
  const Capture half = target.read();
  const Capture all = draw(walker(), faded, "preskinned");
  EXPECT_NEAR(static_cast<double>(covered(half)), 0.5 * static_cast<double>(covered(all)), 0.03 * 480 * 96);
  for (size_t i = 0; i < half.ids.data.size(); ++i)
    EXPECT_EQ(std::isfinite(half.depth.data[i]), half.ids.data[i] != 0) << "depth of the other side";
}

TEST_F(PreskinnedGl, SlotsFitTheBlock) {
  const scene::Cast cast = cast_of(testing::two_bones());
  const CharacterMesh mesh = upload_mesh(context(), *cast.characters[0], 2, MeshUse::preskinned, {});
  ASSERT_EQ(mesh.vertex_count, 48U);
  EXPECT_EQ(mesh.rest.size(), 48U * 32);
  EXPECT_EQ(SkinnedBuffer(context(), 48 * 16 * 7 + 5).capacity(mesh), 7U);
  EXPECT_EQ(SkinnedBuffer(context(), 100).capacity(mesh), 1U) << "one agent at least";
  SkinnedBuffer buffer(context());
  EXPECT_EQ(buffer.bytes(), 0U);
}

}  // namespace
}  // namespace crowdbench::renderers
