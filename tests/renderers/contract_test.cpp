// What every registered representation must keep, whatever it is made of. A new one is tested by its line in the
// registry, and states in bounds() how near to the mesh it comes.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <limits>
#include <map>
#include <set>

#include "gl_test_support.h"
#include "metrics/tears.h"
#include "renderers/frame/frame_resources.h"
#include "renderers/impostor/views/view_sampling.h"
#include "renderers/shaders/dither.shared.h"
#include "scene/cast/cast.h"
#include "scene/mannequin/mannequin.h"

namespace crowdbench::renderers {
namespace {

using testing::add_agent;
using testing::cast_of;
using testing::context;
using testing::frame_of_one;

std::vector<std::string> specs() {
  std::vector<std::string> out;
  for (const RepresentationType& type : representation_types()) {
    const Spec spec = parse_spec(example_spec(type));
    out.push_back(spec.text());
    if (stands_alone(type)) out.push_back(with_floor(spec).text());
  }
  out.emplace_back("mesh:triangles=600");  // a level of detail is a representation like any other
  return out;
}

// Agents about 120 pixels tall, with ids that are neither consecutive nor small.
constexpr uint32_t kIds[] = {5, 9, 70000};
constexpr int kWidth = 400;
constexpr int kHeight = 200;

// How near to the mesh's picture of this scene a representation comes, at the worst agent.
struct Nearness {
  double overlap = 1;   // pixels that both cover over those that either does
  double coverage = 1;  // pixels covered over the mesh's, or the inverse: the larger
  double depth = 0;     // metres by which a depth lies outside the range of the mesh's
  double holes = 0;     // per mille of the mesh's pixels (metrics/tears.h)
  double strays = 0;
};
// Bounds, each just outside of what the representation reaches; `why` says what keeps it from the mesh.
struct Bound {
  Nearness worst;
  const char* why;
};
const std::map<std::string, Bound>& bounds() {
  static const std::map<std::string, Bound> all = {
      {"mesh", {{1, 1, 0, 0, 0}, "it is the reference"}},
      {"mesh:triangles=600", {{0.93, 1.05, 0.05, 10, 1}, "a quarter of the triangles"}},
      {"flat",
       {{0.86, 1.08, 0.06, 20, 21}, "the nearest stored view is up to 12 degrees off, its depth is one plane's"}},
      {"hybrid", {{0.925, 1.02, 0.02, 1, 0.1}, "its far agent is the default impostor's, the others are the mesh"}},
      {"relief",
       {{0.975, 1.02, 0.06, 0.6, 0.1},
        "outlines to a texel of 128 across each joint's box, and as far outside of cut skin"}},
      {"rigid",
       {{0.755, 1.05, 0.10, 50, 63},
        "eleven stored poses of the walk: the nearest is up to 48 ms off, and legs swing"}},
      {"polypostor",
       {{0.935, 1.025, 0.06, 1.5, 0.45},
        "as flat's views, but parts that end in polygons of eight corners; one pixel of 2,355 is a stray"}},
      {"pseudo",
       {{0.83, 1.04, 0.05, 21, 30}, "eight poses of the walk: the nearest is up to 62 ms off, and legs swing"}},
      {"surfel",
       {{0.965, 1.023, 0.02, 5, 3},
        "discs cover what the figure covers and no more; poses stretch the surface between them: ten pixels of 2,009"}},
      {"dynamic", {{0.975, 1.01, 0.01, 1, 0.1}, "pictures of the same poses, resampled by half a texel"}},
      {"layered", {{0.905, 1.065, 0.07, 17, 7}, "as flat's views; eight layers close most of what lies between them"}},
      {"perjoint",
       {{0.965, 1.02, 0.02, 2, 1}, "as flat's views, of each joint's own space; pictures are stiff where skin bends"}},
      {"posecache", {{0.995, 1.005, 0.002, 0, 0}, "blended from the bank's own samples: normals of 16 bits"}},
      {"preskinned", {{0.999, 1.001, 0.001, 0, 0}, "the same sums, on drivers that contract them otherwise"}},
  };
  return all;
}
// A bound farther than this from what is reached would let something go wrong unseen.
constexpr Nearness kStale = {0.03, 0.03, 0.05, 8, 8};

scene::Frame make_frame(const scene::Cast& cast, double phase) {
  scene::Frame frame = frame_of_one(8.0, 1.5, kWidth, kHeight, 20.0);
  for (int i = 0; i < 3; ++i)
    add_agent(frame, cast, {1.9 * (i - 1), 0, -1.0 * (i - 1)}, kIds[i], phase + 0.3 * i,
              0.13F + 0.3F * static_cast<float>(i));
  return frame;
}

const scene::Cast& cast() {
  static const scene::Cast one = cast_of(scene::make_mannequin({.triangles = 2200}), 10.0);
  return one;
}

class ContractGl : public testing::GlTest, public ::testing::WithParamInterface<std::string> {
 protected:
  static void SetUpTestSuite() {
    // Bakes of the tests stay out of the user's cache, and are kept from one test to the next.
    const auto folder = std::filesystem::path(::testing::TempDir()) / "crowdbench_contract_cache";
    setenv("CROWDBENCH_CACHE_DIR", folder.c_str(), 1);
  }
  static void TearDownTestSuite() {
    shared_.clear();
    mesh_.reset();
    unsetenv("CROWDBENCH_CACHE_DIR");
  }
  // One representation a spec, made once: a bake takes seconds.
  Representation& representation() {
    auto& one = shared_[GetParam()];
    if (!one) one = make();
    return *one;
  }
  std::unique_ptr<Representation> make() const {
    return make_representation({.context = context(), .cast = cast(), .progress = false}, parse_spec(GetParam()));
  }
  static const Capture& mesh(double phase) {
    static std::map<double, Capture> made;
    auto found = made.find(phase);
    if (found == made.end()) {
      if (!mesh_) mesh_ = make_representation({.context = context(), .cast = cast()}, reference_spec());
      Renderer renderer(context(), cast());
      found = made.emplace(phase, renderer.capture(make_frame(cast(), phase), *mesh_)).first;
    }
    return found->second;
  }

  static std::map<std::string, std::unique_ptr<Representation>> shared_;
  static std::unique_ptr<Representation> mesh_;
};
std::map<std::string, std::unique_ptr<Representation>> ContractGl::shared_;
std::unique_ptr<Representation> ContractGl::mesh_;

metrics::Mask mask_of(const Capture& capture, uint32_t id) {
  metrics::Mask mask(capture.ids.width, capture.ids.height, 1);
  for (size_t i = 0; i < mask.data.size(); ++i) mask.data[i] = capture.ids.data[i] == id ? 255 : 0;
  return mask;
}

// Of one agent; that of a picture without it is the worst there is.
Nearness nearness(const Capture& test, const Capture& reference, uint32_t id) {
  size_t both = 0;
  size_t either = 0;
  size_t ours = 0;
  size_t theirs = 0;
  float near = std::numeric_limits<float>::infinity();
  float far = 0;
  for (size_t i = 0; i < test.ids.data.size(); ++i) {
    const bool a = test.ids.data[i] == id;
    const bool b = reference.ids.data[i] == id;
    both += a && b ? 1U : 0U;
    either += a || b ? 1U : 0U;
    ours += a ? 1U : 0U;
    theirs += b ? 1U : 0U;
    if (b) {
      near = std::min(near, reference.depth.data[i]);
      far = std::max(far, reference.depth.data[i]);
    }
  }
  EXPECT_GT(theirs, 800U) << "the mesh shows agent " << id;
  Nearness out;
  out.overlap = static_cast<double>(both) / static_cast<double>(either);
  out.coverage = static_cast<double>(std::max(ours, theirs)) / static_cast<double>(std::min(ours, theirs));
  for (size_t i = 0; i < test.ids.data.size(); ++i)
    if (test.ids.data[i] == id)
      out.depth =
          std::max(out.depth, static_cast<double>(std::max(near - test.depth.data[i], test.depth.data[i] - far)));
  const metrics::Tears torn = metrics::tears(mask_of(reference, id), mask_of(test, id)).value();
  out.holes = torn.holes;
  out.strays = torn.strays;
  return out;
}

TEST_P(ContractGl, IsAsNearToTheMeshAsItsBound) {
  // A floor may draw another pose; phase 0 is the mesh floor's.
  if (is_floor(parse_spec(GetParam()))) GTEST_SKIP() << "a floor is no picture of the crowd";
  Renderer renderer(context(), cast());
  Nearness worst;
  for (const double phase : {0.0, 0.4}) {
    const Capture test = renderer.capture(make_frame(cast(), phase), representation());
    for (const uint32_t id : kIds) {
      const Nearness one = nearness(test, mesh(phase), id);
      worst.overlap = std::min(worst.overlap, one.overlap);
      worst.coverage = std::max(worst.coverage, one.coverage);
      worst.depth = std::max(worst.depth, one.depth);
      worst.holes = std::max(worst.holes, one.holes);
      worst.strays = std::max(worst.strays, one.strays);
    }
  }
  const std::string name = parse_spec(GetParam()).name;
  const auto own = bounds().find(GetParam());
  const auto bound = own != bounds().end() ? own : bounds().find(name);
  ASSERT_NE(bound, bounds().end()) << "no bound stated for " << name << ": it reached an overlap of " << worst.overlap
                                   << ", a coverage of " << worst.coverage << ", " << worst.depth
                                   << " m of depth, holes of " << worst.holes << " and strays of " << worst.strays
                                   << " per mille; give bounds() a line that says why";
  const Nearness& limit = bound->second.worst;
  EXPECT_GE(worst.overlap, limit.overlap) << bound->second.why;
  EXPECT_LE(worst.coverage, limit.coverage) << bound->second.why;
  EXPECT_LE(worst.depth, limit.depth) << bound->second.why;
  EXPECT_LE(worst.holes, limit.holes) << bound->second.why;
  EXPECT_LE(worst.strays, limit.strays) << bound->second.why;
  EXPECT_LE(worst.overlap, limit.overlap + kStale.overlap) << "it does better than its bound says: move the bound";
  EXPECT_GE(worst.coverage, limit.coverage - kStale.coverage) << "move the bound";
  EXPECT_GE(worst.depth, limit.depth - kStale.depth) << "move the bound";
  EXPECT_GE(worst.holes, limit.holes - kStale.holes) << "move the bound";
  EXPECT_GE(worst.strays, limit.strays - kStale.strays) << "move the bound";
}

TEST(ContractBounds, AreOfRegisteredRepresentations) {
  for (const auto& [name, bound] : bounds())
    EXPECT_EQ(name.find(':') == std::string::npos ? representation_type(name).name : parse_spec(name).text(), name);
}

TEST_P(ContractGl, IdsAndDepthsAreThoseOfDrawnAgents) {
  Renderer renderer(context(), cast());
  const Capture c = renderer.capture(make_frame(cast(), 0.0), representation());
  std::set<uint32_t> seen;
  for (size_t i = 0; i < c.ids.data.size(); ++i) {
    if (c.ids.data[i] != 0) seen.insert(c.ids.data[i]);
    ASSERT_EQ(std::isfinite(c.depth.data[i]), c.ids.data[i] != 0) << "depth is finite exactly where an agent is";
    if (c.ids.data[i] == 0) {
      ASSERT_EQ(c.colour.data[4 * i], 128) << "the background shows exactly where no agent is";
    }
  }
  EXPECT_EQ(seen, (std::set<uint32_t>{5, 9, 70000}));
}

TEST_P(ContractGl, DrawsOnlyTheListedAgents) {
  Renderer renderer(context(), cast());
  const scene::Frame frame = make_frame(cast(), 0.0);
  const Target target(context(), kWidth, kHeight, {.ids = true});
  const auto draw = [&](const AgentLists& lists) {
    // An empty frame clears the target and leaves the state that draw() starts from.
    scene::Frame empty = frame;
    for (auto& agents : empty.agents) agents.clear();
    renderer.draw(empty, representation(), target);
    renderer.resources().upload(frame);
    representation().draw(frame, renderer.resources(), lists, target.pass());
    std::set<uint32_t> seen;
    for (const uint32_t id : target.read().ids.data)
      if (id != 0) seen.insert(id);
    return seen;
  };
  EXPECT_EQ(draw({{}}), (std::set<uint32_t>{}));
  EXPECT_EQ(draw({{1}}), (std::set<uint32_t>{9}));
  EXPECT_EQ(draw({{0, 2}}), (std::set<uint32_t>{5, 70000}));
}

TEST_P(ContractGl, MovesAndRepeats) {
  Renderer renderer(context(), cast());
  const Capture a = renderer.capture(make_frame(cast(), 0.0), representation());
  const Capture b = renderer.capture(make_frame(cast(), 0.35), representation());
  const Capture again = renderer.capture(make_frame(cast(), 0.0), representation());
  EXPECT_EQ(a, again) << "the same frame gives the same bytes, whatever came between";
  if (!is_floor(parse_spec(GetParam()))) {
    EXPECT_NE(a.colour, b.colour) << "two ticks differ";
  }
}

TEST_P(ContractGl, ColoursAreTheSameWithAndWithoutIds) {
  Renderer renderer(context(), cast());
  const scene::Frame frame = make_frame(cast(), 0.2);
  const Capture with = renderer.capture(frame, representation());
  const Target plain(context(), kWidth, kHeight, {});
  renderer.draw(frame, representation(), plain);
  const Capture without = plain.read();
  EXPECT_EQ(with.colour, without.colour);
  EXPECT_EQ(with.depth, without.depth);
}

// The two sides of a cross-fade: every pixel is drawn by exactly one of them, by its place in the ordered dither,
// whatever the share. A representation that fails here does not define CB_DITHER for passes with `dithered`.
TEST_P(ContractGl, DitheredPassesShareThePixels) {
  Renderer renderer(context(), cast());
  const scene::Frame frame = make_frame(cast(), 0.2);
  const Capture whole = renderer.capture(frame, representation());
  const AgentLists everybody = {{0, 1, 2}};
  const Target target(context(), kWidth, kHeight, {.ids = true, .dithered = true});
  const auto draw = [&](float low, float high) {
    scene::Frame empty = frame;
    for (auto& agents : empty.agents) agents.clear();
    renderer.draw(empty, representation(), target);
    renderer.resources().upload(frame);
    renderer.resources().set_dither({low, high});
    representation().draw(frame, renderer.resources(), everybody, target.pass());
    return target.read();
  };
  for (const float share : {0.25F, 1.0F / 3, 0.9F}) {
    const Capture a = draw(0, share);
    const Capture b = draw(share, 1);
    size_t in_a = 0;
    size_t covered = 0;
    for (int y = 0; y < kHeight; ++y)
      for (int x = 0; x < kWidth; ++x) {
        const size_t i = static_cast<size_t>(y) * kWidth + static_cast<size_t>(x);
        const bool first = (dither_rank(static_cast<uint>(x), static_cast<uint>(kHeight - 1 - y)) + 0.5F) / 64 < share;
        ASSERT_EQ(a.ids.data[i], first ? whole.ids.data[i] : 0U) << x << " " << y;
        ASSERT_EQ(b.ids.data[i], first ? 0U : whole.ids.data[i]) << x << " " << y;
        const Capture& drawn = first ? a : b;
        for (size_t c = 0; c < 4; ++c) ASSERT_EQ(drawn.colour.data[4 * i + c], whole.colour.data[4 * i + c]);
        ASSERT_EQ(drawn.depth.data[i], whole.depth.data[i]);
        in_a += a.ids.data[i] != 0 ? 1U : 0U;
        covered += whole.ids.data[i] != 0 ? 1U : 0U;
      }
    EXPECT_NEAR(static_cast<double>(in_a) / static_cast<double>(covered), share, 0.03);
  }
}

// What the type says of itself holds of what it makes.
TEST_P(ContractGl, CapabilitiesAreTrue) {
  const Spec spec = parse_spec(GetParam());
  const RepresentationType& type = representation_type(spec.name);
  Renderer renderer(context(), cast());
  const Capture picture = renderer.capture(make_frame(cast(), 0.2), representation());
  for (const std::string& view : debug_views(type)) {
    Spec shown = spec;
    set_debug_view(shown, view);
    const auto one = make_representation({.context = context(), .cast = cast(), .progress = false}, shown);
    EXPECT_NE(renderer.capture(make_frame(cast(), 0.2), *one).colour, picture.colour) << view;
  }
  if (type.view_sampling != nullptr) {
    const ViewSampling sampling = type.view_sampling(spec, *cast().characters[0], cast().banks[0]);
    EXPECT_NEAR(sampling.texel, representation().texel_metres(0), 1e-6 * sampling.texel);
    EXPECT_GT(sampling.grid.size(), 1);
    // The forecast goes by bounds, a bake by what it covers.
    const auto baked = static_cast<double>(representation().footprint().texture_bytes);
    EXPECT_NEAR(static_cast<double>(sampling.texture_bytes), baked, 0.25 * baked);
  }
  if (type.required_by) {
    // Of a scenario that shows one pose from one side.
    MakeContext make{.context = context(), .cast = cast(), .progress = false};
    make.required_by = [](size_t, const std::function<void(const ViewSample&)>& see) { see({{0, 1, 8}, 0, 0}); };
    const auto part = make_representation(make, spec);
    ASSERT_EQ(part->bake_info().kept.size(), 1U);
    const Kept kept = part->bake_info().kept[0];
    EXPECT_GT(kept.kept, 0U);
    EXPECT_LT(kept.kept, kept.whole);
    EXPECT_LT(kept.kept_bytes, kept.whole_bytes);
    EXPECT_LE(kept.whole_bytes, representation().footprint().gpu_bytes());
    EXPECT_LT(part->footprint().gpu_bytes(), representation().footprint().gpu_bytes());
  }
}

TEST_P(ContractGl, AnEmptyFrameIsBackground) {
  Renderer renderer(context(), cast());
  scene::Frame frame = make_frame(cast(), 0.0);
  frame.agents[0].clear();
  const Capture c = renderer.capture(frame, representation());
  for (size_t i = 0; i < c.ids.data.size(); ++i) {
    ASSERT_EQ(c.ids.data[i], 0U);
    ASSERT_EQ(c.colour.data[4 * i], 128);
  }
}

TEST_P(ContractGl, FootprintIsWhatWasAllocated) {
  context().make_current();
  const gl::Allocated before = context().allocated();
  const std::unique_ptr<Representation> one = make();
  {
    Renderer renderer(context(), cast());
    (void)renderer.capture(make_frame(cast(), 0.0), *one);
  }  // the renderer's own buffers are gone
  const gl::Allocated after = context().allocated();
  const Footprint footprint = one->footprint();
  EXPECT_EQ(footprint.texture_bytes, after.texture_bytes - before.texture_bytes);
  EXPECT_EQ(footprint.buffer_bytes, after.buffer_bytes - before.buffer_bytes);
  EXPECT_GT(footprint.gpu_bytes(), 0U);
  EXPECT_GT(one->triangles(0), 0U);
}

INSTANTIATE_TEST_SUITE_P(Registered, ContractGl, ::testing::ValuesIn(specs()),
                         [](const ::testing::TestParamInfo<std::string>& param) {
                           std::string name;
                           for (const char c : param.param)
                             name += std::isalnum(static_cast<unsigned char>(c)) ? c : '_';
                           return name;
                         });

}  // namespace
}  // namespace crowdbench::renderers
