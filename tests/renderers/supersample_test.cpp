// Supersampling smooths what is drawn and draws nothing else: with an odd number of samples the middle one of each
// pixel is the sample of a plain picture, so whatever is chosen by pixels (the level of a map, the tier of the boxes,
// the side of a switch) must be chosen by the pixels of the picture and not by the samples.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "renderers/frame/capture.h"
#include "renderers/gl/context.h"
#include "renderers/representation.h"
#include "tests/renderers/gl_test_support.h"
#include "tests/support/sanitized.h"

namespace crowdbench::renderers {
namespace {

using testing::add_agent;
using testing::context;
using testing::frame_of_one;
using testing::make;
using testing::walker;

constexpr int kSamples = 3;  // a side

struct Chooser {
  const char* name;
  const char* spec;
};
class SupersampleGl : public ::testing::TestWithParam<Chooser> {};

constexpr int kSide = 64;  // pixels of the picture

// Two walkers, about 25 pixels tall where the picture is kSide on a side.
scene::Frame frame_of(int side) {
  scene::Frame frame = frame_of_one(6.2, 1.0, side, side);
  add_agent(frame, walker(), {-0.6, 0, 0}, 1, 0.1, 0.05F);
  add_agent(frame, walker(), {0.7, 0, -0.3}, 2, 0.6, 0.4F);
  return frame;
}

// Drawn with `samples` x `samples` a pixel: what stands at the middle of each of kSide x kSide squares.
Capture draw(Renderer& renderer, const scene::Frame& frame, Representation& representation, int samples) {
  const int side = frame.width * samples;
  const Target target(context(), side, side, {.ids = true, .linear = true});
  renderer.draw(frame, representation, target);
  const Capture fine = target.read();
  const int step = side / kSide;
  Capture out;
  out.linear = ImageF(kSide, kSide, 4);
  out.depth = ImageF(kSide, kSide, 1);
  out.ids = ImageU32(kSide, kSide, 1);
  for (int y = 0; y < kSide; ++y)
    for (int x = 0; x < kSide; ++x) {
      const int u = x * step + step / 2;
      const int v = y * step + step / 2;
      std::copy_n(fine.linear.at(u, v), 4, out.linear.at(x, y));
      out.depth.at(x, y)[0] = fine.depth.at(u, v)[0];
      out.ids.at(x, y)[0] = fine.ids.at(u, v)[0];
    }
  return out;
}

// Pixels that show another agent, a depth a centimetre off or a colour two hundredths off, over those that show
// anybody.
double differing(const Capture& a, const Capture& b) {
  int differ = 0;
  int anybody = 0;
  for (size_t i = 0; i < a.ids.data.size(); ++i) {
    if (a.ids.data[i] == 0 && b.ids.data[i] == 0) continue;
    ++anybody;
    bool same = a.ids.data[i] == b.ids.data[i] && std::abs(a.depth.data[i] - b.depth.data[i]) < 0.01F;
    for (size_t c = 0; c < 3; ++c) same = same && std::abs(a.linear.data[4 * i + c] - b.linear.data[4 * i + c]) < 0.02F;
    differ += same ? 0 : 1;
  }
  return static_cast<double>(differ) / std::max(anybody, 1);
}

TEST_P(SupersampleGl, TheMiddleSamplesAreThePictureWithoutSupersampling) {
  if (!std::string(GetParam().spec).starts_with("hybrid"))
    CROWDBENCH_SKIP_SANITIZED("the hybrids here, and ContractGl");
  Renderer renderer(context(), walker());
  const auto representation = make(walker(), GetParam().spec);
  const Capture plain = draw(renderer, frame_of(kSide), *representation, 1);
  const Capture middle = draw(renderer, frame_of(kSide), *representation, kSamples);
  // Corners are rounded to a grid of 1/256 sample, so that an edge may pass over a pixel's centre.
  EXPECT_LT(differing(plain, middle), 0.02);
  // A picture three times as large is drawn from finer maps, more boxes or the near side: the choice is there to make.
  const Capture larger = draw(renderer, frame_of(kSide * kSamples), *representation, 1);
  EXPECT_GT(differing(plain, larger), 0.10);
}

const std::vector<Chooser>& choosers() {
  static const std::vector<Chooser> all = {
      {"flat", "flat:views=sphere-8x2,frames=4,texels=128"},
      {"polypostor", "polypostor:views=sphere-8x2,frames=4,texels=128"},
      {"layered", "layered:views=sphere-8x2,frames=4,texels=128"},
      {"dynamic", "dynamic"},
      {"perjoint", "perjoint:views=cube-2"},
      {"relief", "relief:map=64"},
      {"relief_levels", "relief:map=64,merge=0"},
      {"surfel", "surfel:size=3"},
      {"height", "hybrid(mesh,(flat:views=sphere-8x2,frames=4,texels=128),height=50)"},
      {"ratio", "hybrid(mesh,(flat:views=sphere-8x2,frames=4,texels=64),ratio=1)"},
  };
  return all;
}

INSTANTIATE_TEST_SUITE_P(Choosers, SupersampleGl, ::testing::ValuesIn(choosers()),
                         [](const auto& chooser) { return std::string(chooser.param.name); });

// Who chooses nothing by pixels draws the same samples whether they are those of a larger picture or several of each
// pixel of this one; who draws others belongs above.
TEST(SupersampleChoosersGl, AreAllThatDrawOtherwiseInALargerPicture) {
  Renderer renderer(context(), walker());
  const auto is_above = [](const RepresentationType& type) {
    return std::any_of(choosers().begin(), choosers().end(),
                       [&](const Chooser& chooser) { return parse_spec(chooser.spec).name == type.name; });
  };
  size_t asked = 0;
  for (const RepresentationType& type : representation_types()) {
    if (is_above(type)) continue;
    ++asked;
    const auto representation = make(walker(), example_spec(type));
    const Capture samples = draw(renderer, frame_of(kSide), *representation, kSamples);
    const Capture larger = draw(renderer, frame_of(kSide * kSamples), *representation, 1);
    EXPECT_EQ(differing(samples, larger), 0) << type.name << " chooses by pixels: name it among the choosers";
  }
  EXPECT_GT(asked, 0U) << "the reference at least";
}

}  // namespace
}  // namespace crowdbench::renderers
