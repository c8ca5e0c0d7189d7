// Boxes that are not a joint's own: parts of a long one, cells of skin that bends.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <set>
#include <string>

#include "compare_captures.h"
#include "core/error.h"
#include "core/image_io.h"
#include "gl_test_support.h"
#include "renderers/relief/relief_bake.h"
#include "renderers/relief/relief_cells.h"
#include "scene/cast/cast.h"
#include "scene/pose/pose.h"
#include "solids.h"
#include "tests/support/sanitized.h"

namespace crowdbench::renderers {
namespace {

using testing::cast_of;
using testing::context;
using testing::fact;
using testing::GlTest;
using testing::make;

// A square column, 0.3 m thick, on two joints at 0 and 1 m, in rings of 12.5 mm; from 0.6 to 1.4 m its weight goes
// evenly from the lower to the upper one, which turns about X.
scene::Character soft_column() {
  scene::Character c = testing::two_bones();
  scene::Mesh& mesh = c.mesh;
  mesh = scene::Mesh{};
  constexpr uint32_t kRings = 129;
  const auto y_of = [](uint32_t ring) { return 0.2F + 0.0125F * static_cast<float>(ring); };
  for (uint32_t ring = 0; ring < kRings; ++ring)
    for (const glm::vec2& at : {glm::vec2(-1, -1), glm::vec2(1, -1), glm::vec2(1, 1), glm::vec2(-1, 1)}) {
      mesh.positions.emplace_back(0.15F * at.x, y_of(ring), 0.15F * at.y);
      mesh.normals.push_back(glm::normalize(glm::vec3(at.x, 0, at.y)));
    }
  for (uint32_t ring = 0; ring + 1 < kRings; ++ring)
    for (uint32_t k = 0; k < 4; ++k) {
      const uint32_t a = 4 * ring + k;
      const uint32_t b = 4 * ring + (k + 1) % 4;
      for (const uint32_t v : {a, a + 4, b, b, a + 4, b + 4}) mesh.indices.push_back(v);
    }
  testing::finish(c);
  for (uint32_t v = 0; v < 4 * kRings; ++v) {
    const float upper = std::clamp((y_of(v / 4) - 0.6F) / 0.8F, 0.0F, 1.0F);
    mesh.joints[v] = glm::u16vec4(0, 1, 0, 0);
    mesh.weights[v] = glm::vec4(1 - upper, upper, 0, 0);
  }
  for (scene::Material& m : c.materials) m.double_sided = true;
  c.content_hash = "soft_column";
  c.placement.height = 2;
  return c;
}

class ReliefPartsGl : public GlTest {};

// A wall seen edge-on, in texels whose centres another wall covers: an L of two squares.
TEST(ReliefParts, AWallBehindAnotherOnesEdgeIsKept) {
  scene::Character c = testing::one_joint_character();
  for (const glm::vec3& p : {glm::vec3(0, 0, 0), glm::vec3(1, 0, 0), glm::vec3(1, 1, 0), glm::vec3(0, 1, 0),
                             glm::vec3(0, 0, 1), glm::vec3(0, 1, 1)}) {
    c.mesh.positions.push_back(p);
    c.mesh.normals.emplace_back(0, 0, 1);
  }
  c.mesh.indices = {0, 1, 2, 0, 2, 3, 0, 4, 5, 0, 5, 3};  // the square z = 0 and the square x = 0
  testing::finish(c);
  constexpr size_t n = 32;
  const ReliefModel m = bake_relief(c, {.map_size = n});
  // Along X, (u, v) = (y, z): the first column of z holds the square z = 0, edge-on, all along x.
  const uint16_t* depth = m.depth_map(0, 0);
  for (size_t y = 0; y < n; ++y) {
    EXPECT_LE(depth[2 * y], 65535 / n) << y;
    EXPECT_GE(depth[2 * y + 1], 65535 - 65535 / n) << y;
    EXPECT_LE(depth[2 * (n * n / 2 + y) + 1], 65535 / n) << "elsewhere only the square x = 0";
  }
}

// In parts a sphere has the texels of smaller boxes and stays whole: no crack where parts meet.
TEST_F(ReliefPartsGl, ASphereInPartsIsWhole) {
  scene::Character ball = testing::sphere(0.5, 48);
  ball.placement.height = 1;
  const scene::Cast cast = cast_of(std::move(ball));
  const auto mesh = make(cast, "mesh");
  const auto whole = make(cast, "relief:map=32,merge=0,capture=bind");
  const auto parts = make(cast, "relief:map=32,merge=0,capture=bind,part=0.3");
  // 4 x 4 x 4 cells of a quarter, of which the surface meets all but the eight in the middle, whose
  // farthest corners lie at 0.43 m.
  EXPECT_EQ(fact(whole->bake_info().facts, "boxes"), 1);
  EXPECT_EQ(fact(parts->bake_info().facts, "boxes"), 56);
  Renderer renderer(context(), cast);
  double sum_whole = 0;
  double sum_parts = 0;
  for (const glm::dvec3& eye : {glm::dvec3(0, 0, 3), glm::dvec3(1.7, 1.7, 1.7), glm::dvec3(0.3, 2.9, 0.4)}) {
    scene::Frame frame = testing::frame_of_one(1, 0, 256, 256, 22);
    frame.camera.eye = eye;
    frame.camera.target = {0, 0, 0};
    frame.origin = eye;
    testing::add_agent(frame, cast, {0, 0, 0}, 1);
    const Capture truth = renderer.capture(frame, *mesh);
    const Capture a = renderer.capture(frame, *whole);
    const Capture b = renderer.capture(frame, *parts);
    EXPECT_EQ(testing::difference(truth, b).holes, 0);
    // A texel of a part is 0.25 m / 31, under 2 pixels of 4.5 mm; half of one around 220 pixels of sphere is at
    // most 3.3 %.
    EXPECT_GT(testing::iou(truth, b), 0.967);
    sum_whole += testing::iou(truth, a);
    sum_parts += testing::iou(truth, b);
  }
  EXPECT_GT(sum_parts, sum_whole);
}

// The bake budget asks for fewer parts; without tiers there are none unless asked for.
TEST_F(ReliefPartsGl, AutomaticPartsKeepToTheBudget) {
  scene::Character ball = testing::sphere(0.5, 24);
  ball.placement.height = 1;
  const scene::Cast cast = cast_of(std::move(ball));
  const auto boxes = [&](const std::string& spec, uint64_t budget) {
    return fact(make(cast, spec, {.budget = budget})->bake_info().facts, "boxes");
  };
  EXPECT_EQ(boxes("relief:map=32,capture=bind", 512 << 20), 56);
  // 2 MiB: 92160 bytes a box of 32 (60 bytes a texel of one map and its levels' half): 22 boxes; cells of 0.27 x 1.25^3
  // of the height and more are two a side.
  EXPECT_EQ(boxes("relief:map=32,capture=bind", 2 << 20), 8);
  EXPECT_EQ(boxes("relief:map=32,capture=bind,merge=0", 512 << 20), 1);
  EXPECT_THROW(make(cast, "relief:map=32,capture=bind,part=0.27", {.budget = 2 << 20}), Error)
      << "what is asked for is not changed";
  // What the refusal names does fit.
  const auto refusal = [&](const std::string& spec, uint64_t budget) -> std::string {
    try {
      make(cast, spec, {.budget = budget});
    } catch (const Error& e) {
      return e.what();
    }
    return "";
  };
  const std::string asked = "relief:map=64,capture=bind,part=0.27";
  const std::string said = refusal(asked, 8 << 20);
  EXPECT_NE(said.find("map=32 would fit"), std::string::npos) << said;
  EXPECT_NE(said.find("give it budget=8"), std::string::npos) << said;
  EXPECT_EQ(refusal("relief:map=32,capture=bind,part=0.27", 8 << 20), "");
  EXPECT_EQ(refusal(asked + ",budget=8", 8 << 20), "");
  EXPECT_THROW(make(cast, "relief:part=-1"), Error);
  EXPECT_THROW(make(cast, "relief:bend=x"), Error);
}

// Where a piece puts a point of capture space, in a pose.
glm::dvec3 moved(const Piece& piece, const std::vector<glm::dmat4>& capture, const std::vector<glm::dmat4>& pose,
                 const glm::dvec3& p) {
  const glm::dmat4 back = glm::inverse(matrix_of(piece, capture));
  glm::dmat4 sum(0.0);
  for (const Share& s : piece.shares) sum += pose[static_cast<size_t>(s.joint)] * (s.weight * back + s.change);
  return glm::dvec3(sum * glm::dvec4(p, 1.0));
}

TEST(ReliefParts, CellsStayWithTheSkinInEveryPose) {
  CROWDBENCH_SKIP_SANITIZED("ReliefPartsGl.CellsFollowBentSkin");
  const scene::Character soft = soft_column();
  const scene::PoseBank bank = scene::PoseBank::frames(soft, {0}, {12});
  const Carriers own = own_carriers(soft);
  const Cells joints = skin_cells(soft, bank, {}, own, {.tolerance = 10});
  ASSERT_EQ(joints.pieces.size(), 2U) << "nothing deviates so far";
  EXPECT_GT(joints.deviation, 0.05);

  constexpr double kTolerance = 0.01;
  const CapturePose capture{0, 0.25};
  const Cells cells = skin_cells(soft, bank, capture, own, {.tolerance = kTolerance, .skirt = 0.02, .texel = 0.005});
  EXPECT_GT(cells.pieces.size(), 4U);
  EXPECT_LT(cells.pieces.size(), 60U) << "bands, not triangles";
  EXPECT_LE(cells.deviation, kTolerance);
  const std::vector<glm::dmat4> palette = capture_palette(soft, capture);
  const std::vector<glm::dvec3> captured = scene::skin_positions(soft.mesh, palette);
  std::set<uint32_t> held;
  bool skirted = false;
  for (const Piece& piece : cells.pieces) {
    ASSERT_GE(piece.shares.size(), 1U);
    double weight = 0;
    for (const Share& share : piece.shares) {
      EXPECT_GT(share.weight, 0.0);
      EXPECT_LE(share.weight, piece.shares[0].weight) << "the first counts most";
      weight += share.weight;
    }
    EXPECT_NEAR(weight, 1.0, 1e-9);
    for (const uint32_t t : piece.triangles) {
      EXPECT_TRUE(held.insert(t).second) << "in two cells";
      for (uint32_t corner = 0; corner < 3; ++corner) {
        const uint32_t v = soft.mesh.indices[3 * t + corner];
        EXPECT_NEAR(glm::distance(moved(piece, palette, palette, captured[v]), captured[v]), 0, 1e-7)
            << "changes cancel where it was captured, as far as its weights, which are floats, sum to 1";
        for (const auto& pose : spread_poses(bank, 16))
          EXPECT_LE(glm::distance(moved(piece, palette, pose, captured[v]), scene::skin_positions(soft.mesh, pose)[v]),
                    kTolerance + 1e-7);
      }
    }
    for (const Skirt& skirt : piece.skirts) {
      EXPECT_TRUE(skirt.shared[0] || skirt.shared[1] || skirt.shared[2]);
      EXPECT_GT(skirt.reach, 0);
      skirted = true;
    }
  }
  EXPECT_TRUE(skirted);
  EXPECT_EQ(held.size(), soft.triangles()) << "every triangle in a cell";

  // Once more, the same; and where no vertex follows two joints, nothing is cut.
  const Cells again = skin_cells(soft, bank, capture, own, {.tolerance = kTolerance, .skirt = 0.02, .texel = 0.005});
  ASSERT_EQ(again.pieces.size(), cells.pieces.size());
  for (size_t i = 0; i < cells.pieces.size(); ++i) EXPECT_EQ(again.pieces[i].triangles, cells.pieces[i].triangles);
  scene::Character stiff = soft;
  stiff.mesh.weights.assign(stiff.mesh.weights.size(), glm::vec4(1, 0, 0, 0));
  const Cells whole = skin_cells(stiff, bank, capture, own, {.tolerance = kTolerance});
  ASSERT_EQ(whole.pieces.size(), 1U);
  EXPECT_EQ(whole.pieces[0].shares.size(), 1U);
  EXPECT_NEAR(whole.deviation, 0, 1e-9);
}

// A triangle that is half one joint's and half another's, which turns by up to half a turn about a line in its plane:
// the mean of their matrices has no length across the plane there. Its corners can be followed all the same.
TEST(ReliefParts, ATriangleThatFoldsByHalfATurnIsFollowed) {
  scene::Character c = testing::two_bones();
  c.mesh = scene::Mesh{};
  c.mesh.positions = {{-0.1F, 0.8F, 0}, {0.1F, 1, 0}, {0.1F, 1.3F, 0}};
  c.mesh.normals.assign(3, {0, 0, 1});
  c.mesh.indices = {0, 1, 2};
  testing::finish(c);
  c.mesh.joints.assign(3, glm::u16vec4(0, 1, 0, 0));
  c.mesh.weights = {{1, 0, 0, 0}, {0.5F, 0.5F, 0, 0}, {0, 1, 0, 0}};
  c.clips[0].channels[0].values = {0, 0, 0, 1, 1, 0, 0, 0, 0, 0, 0, 1};
  const scene::PoseBank bank = scene::PoseBank::frames(c, {0}, {12});
  const Cells cells = skin_cells(c, bank, {}, own_carriers(c), {.tolerance = 1e-3});
  ASSERT_EQ(cells.pieces.size(), 1U);
  EXPECT_EQ(cells.pieces[0].shares.size(), 2U);
  EXPECT_LT(cells.deviation, 1e-3);
  EXPECT_EQ(cells.loose, 0);
}

TEST_F(ReliefPartsGl, RigidBoxesThatTearSaySo) {
  const scene::Cast cast = cast_of(soft_column());
  const auto said = [&](const std::string& spec) {
    ::testing::internal::CaptureStderr();
    (void)make(cast, spec);
    return ::testing::internal::GetCapturedStderr();
  };
  const std::string rigid = said("relief:map=32,part=0,merge=0,bend=rigid");
  EXPECT_NE(rigid.find("warning: relief: rigid boxes miss "), std::string::npos) << rigid;
  EXPECT_NE(rigid.find("; bend=1 follows its skin\n"), std::string::npos) << rigid;
  EXPECT_EQ(said("relief:map=32,part=0,merge=0").find("warning"), std::string::npos);
  // Fewer cells than the skin needs: how far it is off, and what helps.
  const std::string few = said("relief:map=32,part=0,merge=0,bend=0.1,cells=16");
  EXPECT_NE(few.find("leave its skin by up to "), std::string::npos) << few;
  EXPECT_NE(few.find("; cells=32 holds more of it\n"), std::string::npos) << few;
}

// Bent by a quarter turn: cells follow the skin where one box a joint leaves it.
TEST_F(ReliefPartsGl, CellsFollowBentSkin) {
  const scene::Cast cast = cast_of(soft_column());
  scene::Frame frame = testing::frame_of_one(4, 1, 384, 384, 25);
  frame.camera.eye = {4, 1, 0.3};
  frame.camera.target = {0, 1, 0.3};
  frame.origin = frame.camera.eye;
  testing::add_agent(frame, cast, {0, 0, 0}, 1, 0.5);
  Renderer renderer(context(), cast);
  const Capture mesh = renderer.capture(frame, *make(cast, "mesh"));
  const auto torn = [&](const std::string& spec) {
    const Capture relief = renderer.capture(frame, *make(cast, spec));
    if (const char* folder = std::getenv("CROWDBENCH_TEST_OUT")) {
      write_png(std::string(folder) + "/soft_mesh.png", mesh.colour);
      write_png(std::string(folder) + "/soft_" + spec.substr(spec.find("bend=")) + ".png", relief.colour);
    }
    return testing::difference(mesh, relief);
  };
  const testing::Difference rigid = torn("relief:map=128,capture=bind,part=0,bend=rigid");
  const testing::Difference cells = torn("relief:map=128,capture=bind,part=0,bend=1");
  // One box a joint leaves the skin by up to half the turn; cells stay within a pixel of 240.
  EXPECT_GT(rigid.strays, 20);
  EXPECT_EQ(cells.strays, 0);
  EXPECT_EQ(cells.holes, 0);
  EXPECT_LT(1 - cells.iou, 0.3 * (1 - rigid.iou));
}

}  // namespace
}  // namespace crowdbench::renderers
