// Another driver's pictures: Mesa's zink, which gives OpenGL to a Vulkan driver (here lavapipe, in software) as SPIR-V
// and so takes little that the language does not promise, against llvmpipe's.
#include <gtest/gtest.h>

#include "core/files.h"
#include "core/image_io.h"
#include "renderers/representation.h"
#include "tests/support/cache_folder.h"
#include "tests/support/driver.h"
#include "tests/support/picture_comparison.h"
#include "tests/support/sanitized.h"

namespace crowdbench::bench {
namespace {

// The leak check of sanitizer builds is off: both drivers leave a few bytes of their own at exit.
constexpr const char* kZink = "MESA_LOADER_DRIVER_OVERRIDE=zink LIBGL_ALWAYS_SOFTWARE=1 ASAN_OPTIONS=detect_leaks=0";

class ZinkGl : public ::testing::Test, public ::testing::WithParamInterface<const char*> {
 protected:
  static void SetUpTestSuite() {
    if (!support::driver_is_built()) return;
    told_ = support::run_driver(kZink, "info --device software").text;
  }
  void SetUp() override {
    if (!support::driver_is_built()) GTEST_SKIP() << "the driver is not built";
    if (told_.find("zink") == std::string::npos)
      GTEST_SKIP() << "Mesa's zink over lavapipe is not here (mesa-vulkan-drivers): " << told_;
  }
  // Ten figures from near to far.
  Image8 picture(const std::string& environment, const std::string& name) {
    const std::string file = (folder_ / name).string();
    const support::Outcome outcome = support::run_driver(
        environment,
        "render --device software --character mannequin:triangles=500 --agents 10 --seed 7 --size 160x120 "
        "--representation '" +
            std::string(GetParam()) + "' --out '" + file + "'");
    EXPECT_EQ(outcome.status, 0) << outcome.text;
    EXPECT_EQ(outcome.text.find("zink") != std::string::npos, !environment.empty()) << outcome.text;
    Image8 read = decode_png(read_file(file), file);
    if (read.channels == 4) return read;
    Image8 out(read.width, read.height, 4);
    for (size_t i = 0; i < out.pixels(); ++i) {
      std::copy_n(&read.data[3 * i], 3, &out.data[4 * i]);
      out.data[4 * i + 3] = 255;
    }
    return out;
  }
  support::CacheFolder folder_;
  static std::string told_;
};
std::string ZinkGl::told_;

TEST_P(ZinkGl, PictureIsLlvmpipes) {
  if (std::string(GetParam()) != "mesh") CROWDBENCH_SKIP_SANITIZED("the same over llvmpipe, which other tests draw");
  const Image8 ours = picture("", "llvmpipe.png");
  const Image8 theirs = picture(kZink, "zink.png");
  if (HasFailure()) return;
  const support::PictureComparison c = support::compare(theirs, ours);
  EXPECT_GT(c.shown, 400U);
  EXPECT_TRUE(c.same()) << 100 * c.differing << " % of " << c.shown << " pixels differ, channels by " << c.bias[0]
                        << ", " << c.bias[1] << ", " << c.bias[2] << " on the mean";
  int most = 0;
  for (size_t i = 0; i < ours.data.size(); ++i) most = std::max(most, std::abs(ours.data[i] - theirs.data[i]));
  RecordProperty("largest_difference", most);
}

const std::vector<const char*>& specs() {
  static const std::vector<const char*> all = {
      "mesh",
      "preskinned",
      "pseudo:poses=4",
      "posecache:keys=4",
      "dynamic",
      "layered:views=sphere-4x1,frames=2,texels=64",
      "surfel:points=512",
      "perjoint:views=cube-2,texels=64",
      "perjoint:views=cube-2,texels=64,depth=plane",
      "rigid:poses=4",
      "flat:views=sphere-4x1,frames=2,texels=64",
      "flat:views=sphere-4x1,frames=2,texels=64,depth=nailboard,blend=3",
      "flat:views=sphere-4x1,frames=2,texels=64,frames_between=move_blend",
      "flat:views=sphere-4x1,frames=2,texels=64,frames_between=move,parallax=2",
      "polypostor:views=sphere-4x1,frames=2,texels=64",
      "relief:map=32",
      "relief:map=32,search=cone",
      "relief:map=32,search=linear,proxy=box",
      "relief:map=32,projection=cube",
      "hybrid(mesh,relief:map=32,distance=6)"};
  return all;
}

INSTANTIATE_TEST_SUITE_P(Pictures, ZinkGl, ::testing::ValuesIn(specs()));

// Tiles that are drawn anew a second time: a driver that loses a clear would show the first ones' remains.
class ZinkAgainGl : public ZinkGl {};
TEST_P(ZinkAgainGl, TheSameSeedIsTheSamePicture) {
  CROWDBENCH_SKIP_SANITIZED("the same over llvmpipe, which the stability tests draw");
  const support::Outcome outcome = support::run_driver(
      kZink, "stability --device software --small --case time_seeds --representation " + std::string(GetParam()));
  EXPECT_EQ(outcome.status, 0) << outcome.text;
}
INSTANTIATE_TEST_SUITE_P(Pictures, ZinkAgainGl, ::testing::Values("dynamic"));

TEST(Zink, EveryRepresentationIsDrawn) {
  for (const renderers::RepresentationType& type : renderers::representation_types())
    EXPECT_TRUE(std::any_of(specs().begin(), specs().end(), [&](const std::string& spec) {
      return renderers::parse_spec(spec).name == type.name;
    })) << type.name;
}

}  // namespace
}  // namespace crowdbench::bench
