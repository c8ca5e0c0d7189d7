// Crowds of specks: what flat impostors cover of the picture.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "core/random.h"
#include "tests/renderers/compare_captures.h"
#include "tests/renderers/gl_test_support.h"
#include "tests/support/sanitized.h"

namespace crowdbench::renderers {
namespace {

using testing::context;
using testing::covered;
using testing::make;
using testing::walker;
using FlatGl = testing::GlTest;

// A picture in which a figure at the origin is `tall` pixels tall, and walkers in it, all steps and headings in turn.
struct Specks {
  Specks(double tall, int width, int height) : metre(tall / 1.75) {
    frame = testing::frame_of_one(height / metre / (2 * std::tan(15 * std::numbers::pi / 180)), 1, width, height, 30);
  }
  void add(int i, const glm::dvec3& place) {
    testing::add_agent(frame, walker(), place, static_cast<uint32_t>(i + 1), (i % 4) * 0.25,
                       static_cast<float>(i % 8) / 8);
  }

  double metre;  // pixels
  scene::Frame frame;
};

// Pixels that flat impostors cover for each that the meshes do, which are at least `least`.
double coverage(const scene::Frame& frame, int texels, double least) {
  Renderer renderer(context(), walker());
  const auto mesh = make(walker(), "mesh");
  const auto flat = make(walker(), fmt::format("flat:views=sphere-8x2,frames=4,texels={}", texels));
  const auto expected = static_cast<double>(covered(renderer.capture(frame, *mesh)));
  EXPECT_GT(expected, least);
  return static_cast<double>(covered(renderer.capture(frame, *flat))) / expected;
}

TEST_F(FlatGl, CoverageOfACrowdIsKeptWhenAgentsAreSpecks) {
  for (const double tall : {24.0, 6.0, 2.0}) {
    Specks specks(tall, 320, 240);
    const double away = specks.frame.camera.eye.z;
    constexpr int kColumns = 40;
    for (int i = 0; i < 1200; ++i) {
      // A lattice that does not beat with the pixels, all within the view.
      const int column = i % kColumns - kColumns / 2;
      const int row = i / kColumns;
      const double x = (column + 0.37 * (row % 3)) * away * 0.65 / kColumns;
      const double y = (row - 15) * away * 0.5 / 31;
      specks.add(i, {x, y, 0.1 * (i % 7)});
    }
    EXPECT_NEAR(coverage(specks.frame, 64, 500), 1, 0.03) << tall << " pixels tall";
  }
}

// Figures that overlap: shapes must be kept too, since blobs of the same area would cover more of the picture.
TEST_F(FlatGl, AHundredThousandAgentsCoverWhatTheirMeshesCover) {
  CROWDBENCH_SKIP_SANITIZED("CoverageOfACrowdIsKeptWhenAgentsAreSpecks");
  Specks specks(1.5, 640, 480);
  for (int i = 0; i < 100000; ++i) {
    const double x = 600 / specks.metre * (random_unit(7, static_cast<uint64_t>(i), 1) - 0.5);
    const double y = 440 / specks.metre * (random_unit(7, static_cast<uint64_t>(i), 2) - 0.5);
    specks.add(i, {x, y, 0.05 * (i % 50)});
  }
  EXPECT_NEAR(coverage(specks.frame, 64, 0.1 * 640 * 480), 1, 0.02);
}

TEST_F(FlatGl, CoverageOfADenseCrowdIsKept) {
  Specks specks(4, 320, 240);
  for (int i = 0; i < 4000; ++i) {
    const double x = 280 / specks.metre * (random_unit(5, static_cast<uint64_t>(i), 1) - 0.5);
    const int row = i / 1000;
    const double y = (80 * row + 20 * random_unit(5, static_cast<uint64_t>(i), 2) - 150) / specks.metre;
    specks.add(i, {x, y, 0.05 * (i % 50)});
  }
  EXPECT_NEAR(coverage(specks.frame, 128, 5000), 1, 0.02);
}

}  // namespace
}  // namespace crowdbench::renderers
