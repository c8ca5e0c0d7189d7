#include "bench/experiments/audit.h"

#include <gtest/gtest.h>

#include "core/error.h"
#include "renderers/gl/context.h"
#include "scene/mannequin/mannequin.h"
#include "tests/support/sanitized.h"

namespace crowdbench::bench {
namespace {

class AuditGl : public ::testing::Test {
 protected:
  ViewAudit audit(const std::string& spec) {
    return audit_views(context_, character_, renderers::parse_spec(spec), uint64_t{512} << 20, false);
  }
  gl::Context context_;
  std::shared_ptr<const scene::Character> character_ =
      std::make_shared<const scene::Character>(scene::make_mannequin({.triangles = 500}));
};

TEST_F(AuditGl, StatesStepsBytesAndTheLimit) {
  CROWDBENCH_SKIP_SANITIZED("MirroringIsComparedWithTheFullTurn");
  const ViewAudit a = audit("flat:views=sphere-8x4,frames=4,texels=64");
  EXPECT_EQ(a.views, 32);
  EXPECT_NEAR(a.step_deg_max, 45, 1e-9) << "azimuths on the horizon";
  EXPECT_FALSE(a.meets_limit);
  EXPECT_EQ(a.limit_grid, "sphere-60x16");
  EXPECT_EQ(a.limit_views, 960);
  // Thirty times the views; those near the pole are smaller pictures of the same figure, or larger ones.
  EXPECT_NEAR(static_cast<double>(a.limit_bytes) / static_cast<double>(a.bytes), 30, 6);
  EXPECT_EQ(a.frames, 4);
  EXPECT_GT(a.pose_step_mm_max, a.pose_step_mm_mean);
  EXPECT_GT(a.pose_step_mm_mean, 100) << "a quarter of a walk";
  EXPECT_GT(a.pose_step_seconds, 0.2);
  // What the figures must say of any impostor: best where it was taken, worse between, worst between frames too.
  EXPECT_GT(a.stored.mean("silhouette_iou").value(), a.between.mean("silhouette_iou").value() + 0.02);
  EXPECT_GT(a.between.mean("silhouette_iou").value(), a.between_frames.mean("silhouette_iou").value() + 0.02);
  EXPECT_GT(a.orbit_flicker, 0);
  EXPECT_FALSE(a.unmirrored);
}

TEST_F(AuditGl, MirroringIsComparedWithTheFullTurn) {
  CROWDBENCH_SKIP_SANITIZED("BakeReportGl.RequiredByKeepsAPartOrIsRefused");
  const ViewAudit a = audit("flat:views=sphere-7x3-mirrored,frames=2,texels=48");
  EXPECT_NEAR(a.step_deg_max, 45, 1e-9);
  ASSERT_TRUE(a.unmirrored);
  EXPECT_EQ(a.unmirrored->views, a.between.views);
  // The mannequin walks alike on both sides, half a cycle later, so that half of the turn serves nearly as well.
  EXPECT_NEAR(a.unmirrored->mean("silhouette_iou").value(), a.between.mean("silhouette_iou").value(), 0.03);
  EXPECT_NE(a.unmirrored->mean("silhouette_iou").value(), a.between.mean("silhouette_iou").value());
}

TEST_F(AuditGl, MovingCornersAreAsGoodBetweenFrames) {
  CROWDBENCH_SKIP_SANITIZED("BakeReportGl.PolypostorsAreAudited");
  const std::string sampling = ":views=sphere-6x3,frames=8,texels=64";
  const ViewAudit a = audit("polypostor" + sampling);
  const ViewAudit still = audit("flat" + sampling);
  EXPECT_EQ(a.grid, "sphere-6x3");
  EXPECT_EQ(a.views, 18);
  EXPECT_NEAR(a.step_deg_max, 60, 1e-9);
  EXPECT_EQ(a.limit_grid, "sphere-60x16");
  EXPECT_EQ(a.frames, 8);
  EXPECT_EQ(a.pose_step_mm_max, still.pose_step_mm_max) << "of the same stored frames";
  // Its pictures also hold what an eye nearby sees beyond the parallel outline.
  EXPECT_NEAR(a.texel_mm, still.texel_mm, 0.01 * still.texel_mm);
  EXPECT_LT(a.bytes, still.bytes / 2) << "an image a part, and not one a frame";
  // The bytes of a view hardly depend on how many there are.
  EXPECT_NEAR(static_cast<double>(a.limit_bytes) / static_cast<double>(a.bytes), 960.0 / 18, 10);
  const auto overlap = [](const AuditError& error) { return error.mean("silhouette_iou").value(); };
  EXPECT_GT(overlap(a.stored), overlap(a.between));
  // Half-way between frames flat impostors show one of the two.
  EXPECT_LT(overlap(a.between) - overlap(a.between_frames),
            0.5 * (overlap(still.between) - overlap(still.between_frames)));
  EXPECT_GT(a.orbit_flicker, 0);
}

// Of what is made of others, those are audited that store views.
TEST(ViewAuditSpecs, AreTheComponentsThatStoreViews) {
  const auto texts = [](const std::string& spec) {
    std::vector<std::string> out;
    for (const renderers::Spec& one : audited_specs(renderers::parse_spec(spec))) out.push_back(one.text());
    return out;
  };
  using Texts = std::vector<std::string>;
  EXPECT_EQ(texts("flat:texels=64"), Texts{"flat:texels=64"});
  EXPECT_EQ(texts("mesh"), Texts{"mesh"}) << "refused by itself";
  EXPECT_EQ(texts("hybrid(mesh,(flat:texels=64),distance=9)"), Texts{"flat:texels=64"});
  EXPECT_EQ(texts("hybrid(flat,polypostor,distance=9)"), (Texts{"flat", "polypostor"}));
  EXPECT_EQ(texts("hybrid(mesh,surfel,distance=9)"), Texts{"hybrid(mesh,surfel,distance=9)"});
}

// Every type is audited or refused by what it says of itself; a refusal names those that can be.
TEST_F(AuditGl, OnlyTypesThatStoreViewsAreAudited) {
  size_t refused = 0;
  for (const renderers::RepresentationType& type : renderers::representation_types()) {
    if (type.view_sampling != nullptr) continue;
    ++refused;
    try {
      (void)audit(example_spec(type));
      ADD_FAILURE() << type.name << " was audited";
    } catch (const Error& error) {
      const std::string said = error.what();
      const std::vector<renderers::OptionDoc> options = option_docs(type);
      const bool has_views =
          std::ranges::any_of(options, [](const renderers::OptionDoc& option) { return option.key == "views"; });
      EXPECT_NE(said.find("'" + type.name +
                          (has_views ? "' has no grid of views of the whole figure to audit: its own is "
                                     : "' has no grid of stored views to audit")),
                std::string::npos)
          << said;
      EXPECT_NE(said.find(renderers::default_impostor().name), std::string::npos) << said;
    }
  }
  EXPECT_GT(refused, 0U);
}

}  // namespace
}  // namespace crowdbench::bench
