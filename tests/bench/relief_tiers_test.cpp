// Joints that share boxes at a distance: their pictures against the mesh, at the sizes at which they are used.
#include <gtest/gtest.h>

#include "bench/experiments/quality.h"
#include "renderers/gl/context.h"
#include "scene/cast/open_character.h"
#include "scene/gltf/gltf.h"
#include "tests/support/sanitized.h"

namespace crowdbench::bench {
namespace {

// A tier lets joints deviate a quarter of a pixel (root mean square, so no less than the mean), in maps whose texels
// are at most half a pixel: a quarter of a pixel each way. So silhouettes lie at most half a pixel farther from the
// mesh's, on average, than those of joints on their own.
TEST(ReliefTiersGl, StrayByTheirTolerance) {
  CROWDBENCH_SKIP_SANITIZED("QualityGl");
  gl::Context context;
  QualitySetup setup;
  setup.character = std::make_shared<const scene::Character>(scene::open_character("mannequin"));
  setup.representations = {"relief:capture=bind,merge=0", "relief:capture=bind"};
  setup.use_cache = false;
  setup.rows = 240;
  const int walk = setup.character->placement.default_clip;
  for (const double height : {36.0, 18.0, 9.0})
    for (const double azimuth : {0.0, 60.0})
      for (const double time : {0.2, 0.7}) setup.views.push_back({height, azimuth, 10.0, walk, time});
  const auto rows = compute_quality(context, setup);
  ASSERT_EQ(rows.size(), 2 * setup.views.size());
  bool differs = false;
  for (size_t i = 0; i < setup.views.size(); ++i) {
    const metrics::FigureScores& alone = rows[i].scores;
    const metrics::FigureScores& shared = rows[i + setup.views.size()].scores;
    const std::optional<double> boundary_alone = alone.value("boundary_px_mean");
    const std::optional<double> boundary_shared = shared.value("boundary_px_mean");
    ASSERT_TRUE(boundary_alone && boundary_shared);
    EXPECT_LT(*boundary_shared, *boundary_alone + 0.5)
        << setup.views[i].height_px << " px from " << setup.views[i].azimuth_deg;
    differs = differs || shared.value("psnr") != alone.value("psnr");
    if (std::getenv("CROWDBENCH_TEST_OUT"))
      std::printf("%g px %g deg: boundary %.3f alone %.3f, iou %.3f alone %.3f\n", setup.views[i].height_px,
                  setup.views[i].azimuth_deg, *boundary_shared, *boundary_alone,
                  shared.value("silhouette_iou").value_or(0), alone.value("silhouette_iou").value_or(0));
  }
  EXPECT_TRUE(differs) << "tiers were drawn";
}

}  // namespace
}  // namespace crowdbench::bench
