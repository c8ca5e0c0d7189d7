// Multisampling: what several samples a pixel draw is what as many supersamples show, at edges of triangles and at
// outlines that a fragment shader finds; ids and depths stay the centre sample's.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/error.h"
#include "renderers/frame/capture.h"
#include "renderers/gl/context.h"
#include "renderers/gl/per_sample.h"
#include "tests/renderers/gl_test_support.h"
#include "tests/support/sanitized.h"

namespace crowdbench::renderers {
namespace {

using testing::add_agent;
using testing::context;
using testing::frame_of_one;
using testing::make;
using testing::walker;

constexpr int kSamples = 4;  // every driver of OpenGL 4.5 has them

scene::Frame two_walkers() {
  scene::Frame frame = frame_of_one(6.2, 1.0, 192, 192);
  add_agent(frame, walker(), {-0.6, 0, 0}, 1, 0.1, 0.05F);
  add_agent(frame, walker(), {0.7, 0, -0.3}, 2, 0.6, 0.4F);
  return frame;
}

// Root mean square difference of linear colours over pixels beside another id: the outlines.
double apart_at_outlines(const Capture& a, const Capture& b) {
  double sum = 0;
  size_t count = 0;
  const ImageU32& ids = a.ids;
  for (int y = 1; y + 1 < ids.height; ++y)
    for (int x = 1; x + 1 < ids.width; ++x) {
      bool edge = false;
      for (int j = -1; j <= 1; ++j)
        for (int i = -1; i <= 1; ++i) edge = edge || *ids.at(x + i, y + j) != *ids.at(x, y);
      if (!edge) continue;
      for (int c = 0; c < 3; ++c) sum += std::pow(a.linear.at(x, y)[c] - b.linear.at(x, y)[c], 2);
      count += 3;
    }
  EXPECT_GT(count, 300U);
  return std::sqrt(sum / static_cast<double>(count));
}

class SamplesGl : public ::testing::TestWithParam<const char*> {};

TEST_P(SamplesGl, SmoothOutlinesAsSupersamplingDoes) {
  if (std::string(GetParam()) != "mesh" && !std::string(GetParam()).starts_with("hybrid"))
    CROWDBENCH_SKIP_SANITIZED("the mesh and the hybrid here, and ContractGl");
  Renderer renderer(context(), walker());
  const auto representation = make(walker(), GetParam());
  scene::Frame frame = two_walkers();
  const auto draw = [&](scene::Antialiasing antialiasing) {
    frame.antialiasing = antialiasing;
    return renderer.capture(frame, *representation, {.linear = true});
  };
  const Capture plain = draw({});
  const Capture sampled = draw({.samples = kSamples});
  const Capture truth = draw({.supersample = 9});
  EXPECT_EQ(sampled.ids, plain.ids);
  EXPECT_EQ(sampled.depth, plain.depth);
  EXPECT_NE(sampled.colour, plain.colour);
  // The error of 4 of a pixel's samples is about half that of one.
  EXPECT_LT(apart_at_outlines(sampled, truth), 0.65 * apart_at_outlines(plain, truth));
  for (size_t i = 3; i < sampled.colour.data.size(); i += 4) ASSERT_EQ(sampled.colour.data[i], 255);
  EXPECT_EQ(draw({}), plain) << "the state is as it was";
}

INSTANTIATE_TEST_SUITE_P(Families, SamplesGl,
                         ::testing::Values("mesh", "rigid:poses=8", "preskinned:passes=2", "pseudo", "surfel",
                                           "posecache:keys=4", "dynamic:ratio=2", "layered:views=sphere-8x2,frames=4",
                                           "flat:views=sphere-8x2,frames=4,texels=128",
                                           "polypostor:views=sphere-8x2,frames=4,texels=128", "relief:map=64",
                                           "hybrid(mesh,(flat:views=sphere-8x2,frames=4,texels=128),distance=6.2)"),
                         [](const auto& test) {
                           const std::string spec = test.param;
                           return spec.substr(0, spec.find_first_of(":("));
                         });

TEST(SampleLimitGl, MoreThanTheDriverHasAreRefused) {
  Renderer renderer(context(), walker());
  const auto mesh = make(walker(), "mesh");
  scene::Frame frame = two_walkers();
  for (const int samples : {0, 3, 5, 16}) {
    frame.antialiasing.samples = samples;
    EXPECT_THROW((void)renderer.capture(frame, *mesh), Error) << samples;
  }
  if (context().limits().samples >= 8) GTEST_SKIP() << "this driver has 8 samples a pixel";
  try {
    frame.antialiasing.samples = 8;
    (void)renderer.capture(frame, *mesh);
    FAIL();
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find("8 samples a pixel are more than this driver's"), std::string::npos);
  }
}

class PerSampleGl : public testing::GlTest {};

TEST_F(PerSampleGl, IsOnWhileAScopeOfSeveralSamplesLives) {
  context();
  for (const int samples : {1, 2, 8}) {
    SCOPED_TRACE(samples);
    {
      const gl::PerSampleScope scope(samples);
      EXPECT_EQ(glIsEnabled(GL_SAMPLE_SHADING) == GL_TRUE, samples > 1);
      float share = 0;
      glGetFloatv(GL_MIN_SAMPLE_SHADING_VALUE, &share);
      if (samples > 1) {
        EXPECT_EQ(share, 1.0F) << "every sample, not some of them";
      }
    }
    EXPECT_EQ(glIsEnabled(GL_SAMPLE_SHADING), GL_FALSE);
  }
}

}  // namespace
}  // namespace crowdbench::renderers
