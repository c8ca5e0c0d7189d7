// What the options of bone-relief impostors promise: resolution by joint, the published sizes, triangle rules.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <string>

#include "compare_captures.h"
#include "core/error.h"
#include "core/image_io.h"
#include "gl_test_support.h"
#include "renderers/relief/relief_pieces.h"
#include "scene/cast/cast.h"
#include "scene/cast/open_character.h"
#include "scene/gltf/gltf.h"
#include "scene/mannequin/mannequin.h"
#include "solids.h"
#include "tests/support/sanitized.h"

namespace crowdbench::renderers {
namespace {

using testing::cast_of;
using testing::context;
using testing::covered;
using testing::Difference;
using testing::difference;
using testing::different_ids;
using testing::fact;
using testing::GlTest;
using testing::make;
using testing::outline_pixels;

class ReliefOptionsGl : public GlTest {};

// By name or by number, over what map and size say; the rest keep theirs.
TEST_F(ReliefOptionsGl, ResolutionOfSingleJoints) {
  const scene::Cast cast = cast_of(testing::two_bones());  // joints "lower" and "upper"
  const auto texels = [&](const std::string& options) {
    std::vector<double> out;
    for (const BakeItem& part : make(cast, "relief:map=64,merge=0,capture=bind" + options)->bake_info().items)
      out.push_back(fact(part.facts, "texels"));
    return out;
  };
  EXPECT_EQ(texels(""), (std::vector<double>{64, 64}));
  EXPECT_EQ(texels(",resolution=upper@256"), (std::vector<double>{64, 256}));
  EXPECT_EQ(texels(",resolution=0@16+upper@32"), (std::vector<double>{16, 32}));
  EXPECT_EQ(texels(",size=by_area,resolution=lower@256"), (std::vector<double>{256, 64}));
  // Finer maps on one joint are seen in the bytes: 4.5 n x n texels of 20.5 bytes each.
  const auto plain = make(cast, "relief:map=64,merge=0,capture=bind");
  const auto fine = make(cast, "relief:map=64,merge=0,capture=bind,resolution=upper@128");
  EXPECT_EQ(fact(fine->bake_info().items[1].facts, "bytes"), 4.5 * 128 * 128 * 20.5);
  EXPECT_EQ(fact(plain->bake_info().items[1].facts, "bytes"), 4.5 * 64 * 64 * 20.5);
  EXPECT_GT(fact(fine->bake_info().facts, "actual_bytes"), fact(plain->bake_info().facts, "actual_bytes"));
}

// Under a budget all sizes are halved alike, so that what was worth more stays so.
TEST_F(ReliefOptionsGl, ABudgetKeepsTheProportions) {
  const scene::Cast cast = cast_of(testing::two_bones());
  const auto fits = make(cast, "relief:map=64,merge=0,capture=bind,resolution=upper@256,budget=2.2");
  // Whole: 4.5 x 20.5 x (64^2 + 256^2) = 6.4 MB and the shelf's rest; halved: a quarter.
  EXPECT_EQ(fact(fits->bake_info().items[0].facts, "texels"), 32);
  EXPECT_EQ(fact(fits->bake_info().items[1].facts, "texels"), 128);
  EXPECT_LE(fact(fits->bake_info().facts, "actual_bytes"), 2.2 * 1048576);
}

// What is too small a budget is told one that is not.
TEST_F(ReliefOptionsGl, ABudgetThatIsTooSmallIsToldWhatFits) {
  const scene::Cast cast = cast_of(testing::two_bones());
  const std::string spec = "relief:map=32,merge=0,capture=bind";
  try {
    make(cast, spec + ",budget=0.01");
    FAIL() << "nothing is as small";
  } catch (const Error& e) {
    const std::string said = e.what();
    const size_t at = said.find("budget=");
    ASSERT_NE(at, std::string::npos) << said;
    const std::string named = said.substr(at, said.find(' ', at) - at);
    EXPECT_NO_THROW(make(cast, spec + "," + named)) << said;
  }
}

// Skin that is cut into cells has texels of its own: they get coarser as well.
TEST_F(ReliefOptionsGl, ABudgetHoldsOfCutSkinToo) {
  CROWDBENCH_SKIP_SANITIZED("ABudgetKeepsTheProportions");
  const scene::Cast cast = cast_of(scene::make_mannequin({.triangles = 500}));
  const std::string spec = "relief:map=64,merge=0,capture=bind,cells=24";
  const auto mib = [](const Representation& one) { return fact(one.bake_info().facts, "actual_bytes") / 1048576; };
  const double some = 0.6 * mib(*make(cast, spec));
  EXPECT_LE(mib(*make(cast, spec + fmt::format(",budget={:.2f}", some))), some);
}

TEST_F(ReliefOptionsGl, WrongResolutionsAreNamed) {
  const scene::Cast cast = cast_of(testing::two_bones());
  const auto said = [&](const std::string& value) -> std::string {
    try {
      make(cast, "relief:map=32,resolution=" + value);
    } catch (const Error& e) {
      return e.what();
    }
    return "nothing";
  };
  EXPECT_NE(said("uper@64").find("no joint \"uper\"; did you mean \"upper\"?"), std::string::npos) << said("uper@64");
  EXPECT_NE(said("2@64").find("no joint \"2\""), std::string::npos);
  for (const char* wrong : {"upper", "upper@", "upper@100", "upper@8", "upper@512", "upper@64+", "@64", "upper@64x"})
    EXPECT_NE(said(wrong).find("representation 'relief', option 'resolution'"), std::string::npos)
        << wrong << ": " << said(wrong);
}

// The kinds add up to what the textures take.
TEST_F(ReliefOptionsGl, BytesByKindAddUp) {
  const scene::Cast cast = cast_of(testing::two_bones());
  for (const char* spec : {"relief:map=64,search=cone", "relief:map=64,depth=8,merge=16"}) {
    const auto relief = make(cast, spec);
    const auto& facts = relief->bake_info().facts;
    double sum = 0;
    for (const char* kind : {"depth_bytes", "colour_bytes", "normal_bytes", "bounds_bytes", "cone_bytes",
                             "emission_bytes", "merged_bytes"})
      sum += fact(facts, kind);
    EXPECT_EQ(sum, fact(facts, "actual_bytes")) << spec;
    EXPECT_EQ(sum, static_cast<double>(relief->footprint().texture_bytes)) << spec;
    EXPECT_LT(fact(facts, "level_bytes"), sum);
  }
}

// 40 joints at 64 texels: the source's smaller figure, through the bake that reports it.
TEST_F(ReliefOptionsGl, NominalBytesOfFortyJoints) {
  scene::Character c = testing::sphere(0.3, 8);
  for (int joint = 1; joint < 40; ++joint) {
    c.skeleton.nodes.push_back({.name = "extra" + std::to_string(joint), .parent = 0});
    c.skeleton.joints.push_back({.name = "extra" + std::to_string(joint), .node = joint});
  }
  const scene::Cast cast = cast_of(std::move(c));
  const auto relief = make(cast, "relief:map=64,merge=0,capture=bind");
  EXPECT_EQ(fact(relief->bake_info().facts, "nominal_bytes"), 7'864'320);
  EXPECT_EQ(fact(relief->bake_info().facts, "boxes"), 1) << "joints without triangles have none";
  EXPECT_EQ(relief->bake_info().items.size(), 40U);
  EXPECT_EQ(fact(relief->bake_info().items[39].facts, "bytes"), 0);
}

// ---- triangle rules

// A square column, 0.3 m thick, on two joints: rings at 0.2 and 0.8 m belong to the lower one, at 1.2 and 1.8 m to the
// upper one, which turns about 1 m. The eight triangles in the middle have two corners of one and one of the other.
scene::Character bending_column() {
  scene::Character c = testing::two_bones();
  scene::Mesh& mesh = c.mesh;
  mesh = scene::Mesh{};
  for (int ring = 0; ring < 4; ++ring) {
    const float y = std::array{0.2F, 0.8F, 1.2F, 1.8F}[static_cast<size_t>(ring)];
    for (const glm::vec2& at : {glm::vec2(-1, -1), glm::vec2(1, -1), glm::vec2(1, 1), glm::vec2(-1, 1)}) {
      mesh.positions.emplace_back(0.15F * at.x, y, 0.15F * at.y);
      mesh.normals.push_back(glm::normalize(glm::vec3(at.x, 0, at.y)));
    }
  }
  for (uint32_t ring = 0; ring < 3; ++ring)
    for (uint32_t k = 0; k < 4; ++k) {
      const uint32_t a = 4 * ring + k;
      const uint32_t b = 4 * ring + (k + 1) % 4;
      for (const uint32_t v : {a, a + 4, b, b, a + 4, b + 4}) mesh.indices.push_back(v);
    }
  testing::finish(c);
  for (size_t v = 8; v < 16; ++v) mesh.joints[v] = glm::u16vec4(1, 0, 0, 0);
  for (scene::Material& m : c.materials) m.double_sided = true;
  c.content_hash = "bending_column";
  return c;
}

Difference against_mesh(const scene::Cast& cast, const scene::Frame& frame, const std::string& spec) {
  Renderer renderer(context(), cast);
  const Capture mesh = renderer.capture(frame, *make(cast, "mesh"));
  const Capture relief = renderer.capture(frame, *make(cast, spec));
  if (const char* folder = std::getenv("CROWDBENCH_TEST_OUT")) {
    write_png(std::string(folder) + "/rule_mesh.png", mesh.colour);
    write_png(std::string(folder) + "/rule_" + spec.substr(spec.find("rule=") + 5) + ".png", relief.colour);
  }
  const Difference d = difference(mesh, relief);
  if (std::getenv("CROWDBENCH_TEST_OUT")) std::printf("%s holes %d strays %d\n", spec.c_str(), d.holes, d.strays);
  return d;
}

TEST_F(ReliefOptionsGl, TriangleRulesOpenAndCloseTheJoint) {
  const scene::Character column = bending_column();
  const Carriers own = own_carriers(column);
  const auto counts = [&](TriangleRule rule, double threshold) {
    const auto of = assign_triangles(column, rule, threshold, own);
    return std::pair(of[0].size(), of[1].size());
  };
  // 8 triangles each, and of the 8 in the middle 4 with most weight on either.
  EXPECT_EQ(counts(TriangleRule::dominant, 0), std::pair(size_t{12}, size_t{12}));
  EXPECT_EQ(counts(TriangleRule::any, 0), std::pair(size_t{16}, size_t{16}));
  EXPECT_EQ(counts(TriangleRule::threshold, 0.9), std::pair(size_t{16}, size_t{16})) << "one corner is 1";
  EXPECT_EQ(counts(TriangleRule::threshold, 1.1), std::pair(size_t{12}, size_t{12}));
  EXPECT_EQ(counts(TriangleRule::threshold, 2.5), std::pair(size_t{12}, size_t{12})) << "the dominant one always";

  // Bent by a quarter turn about X, seen from the side (+X).
  const scene::Cast cast = cast_of(bending_column());
  scene::Frame frame = testing::frame_of_one(4, 1, 384, 384, 25);
  frame.camera.eye = {4, 1, 0.3};
  frame.camera.target = {0, 1, 0.3};
  frame.origin = frame.camera.eye;
  testing::add_agent(frame, cast, {0, 0, 0}, 1, 0.5);
  // Half a texel is 4 mm, less than a pixel (4.6 mm).
  const std::string common = "relief:map=128,merge=0,capture=bind,bend=rigid,rule=";
  const Difference dominant = against_mesh(cast, frame, common + "dominant");
  const Difference any = against_mesh(cast, frame, common + "any");
  const Difference low = against_mesh(cast, frame, common + "threshold0.9");
  const Difference high = against_mesh(cast, frame, common + "threshold1.1");
  // The straight prolongations of both pieces cover the bent skin between them but for a fillet on the inner side,
  // whose legs are 0.2 m - 0.15 m: 12.5 square centimetres, at 4.6 mm a pixel (8 m tan(12.5 degrees) / 384) 59 pixels.
  EXPECT_LT(any.holes, 59);
  EXPECT_GT(dominant.holes, any.holes) << "half of the triangles between the joints are missing on either";
  EXPECT_GT(any.strays, dominant.strays) << "what closes the gap sticks out";
  EXPECT_EQ(low.holes, any.holes);
  EXPECT_EQ(low.strays, any.strays);
  EXPECT_EQ(high.holes, dominant.holes);
  EXPECT_EQ(high.strays, dominant.strays);
}

// ---- mirrored joints

// A joint that mirrors shows what the mirrored mesh shows, light and all. (The mesh renderer's own normals turn inward
// there, so the mesh is mirrored by hand and drawn unposed.)
TEST_F(ReliefOptionsGl, MirroredJointsAreLitLikeTheMirroredMesh) {
  const auto ell = [] {
    scene::Character c = testing::sphere(0.3, 32);
    testing::append(c, testing::sphere(0.15, 16), {0.4F, 0.1F, 0.2F});
    return c;
  };
  scene::Character posed = ell();
  scene::Clip clip;
  clip.name = "mirror";
  clip.end = 1;
  scene::Channel channel;
  channel.target = scene::Target::scale;
  channel.times = {0, 1};
  channel.values = {-1, 1, 1, -1, 1, 1};
  clip.channels.push_back(channel);
  posed.clips.push_back(clip);
  posed.motion.resize(1);
  scene::Character mirrored = ell();
  for (glm::vec3& p : mirrored.mesh.positions) p.x = -p.x;
  for (glm::vec3& n : mirrored.mesh.normals) n.x = -n.x;
  for (size_t i = 0; i + 2 < mirrored.mesh.indices.size(); i += 3)
    std::swap(mirrored.mesh.indices[i + 1], mirrored.mesh.indices[i + 2]);
  const scene::Cast posed_cast = cast_of(std::move(posed));
  const scene::Cast mirrored_cast = cast_of(std::move(mirrored));
  for (const char* proxy : {"hull", "box"}) {
    const auto picture = [&](const scene::Cast& cast, const std::string& spec) {
      scene::Frame frame = testing::frame_of_one(3, 0, 192, 192);
      testing::add_agent(frame, cast, {0, 0, 0}, 1, 0.5, 0.1F);
      Renderer renderer(context(), cast);
      return renderer.capture(frame, *make(cast, spec));
    };
    const Capture mesh = picture(mirrored_cast, "mesh");
    const Capture relief = picture(posed_cast, std::string("relief:map=64,capture=bind,proxy=") + proxy);
    const Difference d = difference(mesh, relief);
    EXPECT_GT(d.drawn, 1000);
    EXPECT_GT(d.iou, 0.94) << proxy;
    // The bound of the unmirrored figure: a texel's normal is up to 1/63 / 0.15 = 6 degrees off.
    EXPECT_LT(d.mean_colour, 8.0) << proxy;
  }
}

// ---- near and far

// The mannequin's face from 0.3 m, and the whole figure from 2 km through a lens that shows it as large as from 3 m.
TEST_F(ReliefOptionsGl, AgentsAtThirtyCentimetresAndTwoKilometres) {
  CROWDBENCH_SKIP_SANITIZED("ReliefNumericsGl.NearAndFarAndFieldsOfView");
  scene::Cast cast = cast_of(scene::open_character("mannequin"));
  Renderer renderer(context(), cast);
  const auto mesh = make(cast, "mesh");
  const auto relief = make(cast, "relief:capture=bind");
  const double texel = relief->texel_metres(0);
  for (const bool near : {true, false}) {
    scene::Frame frame = testing::frame_of_one(near ? 0.4 : 2000, near ? 1.62 : 0.9, 192, 192, near ? 50 : 0.06);
    frame.camera.near = near ? 0.02 : 0.1;
    testing::add_agent(frame, cast, {0, 0, 0}, 1, 0.0, 0.0F);
    const Capture a = renderer.capture(frame, *mesh);
    const Capture b = renderer.capture(frame, *relief);
    if (const char* folder = std::getenv("CROWDBENCH_TEST_OUT")) {
      write_png(std::string(folder) + (near ? "/near_mesh.png" : "/far_mesh.png"), a.colour);
      write_png(std::string(folder) + (near ? "/near_relief.png" : "/far_relief.png"), b.colour);
    }
    std::vector<double> gaps;
    for (size_t i = 0; i < a.ids.data.size(); ++i)
      if (a.ids.data[i] != 0 && b.ids.data[i] != 0)
        gaps.push_back(std::abs(static_cast<double>(a.depth.data[i]) - static_cast<double>(b.depth.data[i])));
    const auto outline = static_cast<double>(outline_pixels(a));
    const auto differ = static_cast<double>(different_ids(a, b));
    EXPECT_GT(covered(a), 1500U) << near;
    // Half a texel and half a pixel on either side of the outline; a pixel is 2 d tan(fov / 2) / 192 wide.
    const double pixel =
        near ? 2 * 0.4 * std::tan(25 * 3.14159265 / 180) / 192 : 2 * 2000 * std::tan(0.03 * 3.14159265 / 180) / 192;
    EXPECT_LT(differ, outline * (0.5 * texel / pixel + 0.5) + 1) << near;
    // Half of all pixels lie within a texel of the mesh, or within the depth's last bit at 2 km (24 bits: 0.12 mm).
    ASSERT_FALSE(gaps.empty());
    std::nth_element(gaps.begin(), gaps.begin() + static_cast<std::ptrdiff_t>(gaps.size() / 2), gaps.end());
    EXPECT_LT(gaps[gaps.size() / 2], texel + 0.00012) << near;
    if (std::getenv("CROWDBENCH_TEST_OUT"))
      std::printf("near %d outline %g differ %g median gap %g texel %g pixel %g\n", near, outline, differ,
                  gaps[gaps.size() / 2], texel, pixel);
  }
}

}  // namespace
}  // namespace crowdbench::renderers
