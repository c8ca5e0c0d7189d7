#include "renderers/perjoint/perjoint.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/error.h"
#include "renderers/perjoint/perjoint.shared.h"
#include "renderers/perjoint/perjoint_bake.h"
#include "renderers/perjoint/perjoint_border.h"
#include "renderers/perjoint/perjoint_pieces.h"
#include "scene/mannequin/mannequin.h"
#include "tests/renderers/compare_captures.h"
#include "tests/renderers/gl_test_support.h"

namespace crowdbench::renderers {
namespace {

using testing::add_agent;
using testing::card;
using testing::card_of_two_joints;
using testing::cast_of;
using testing::context;
using testing::frame_from;
using testing::frame_of_one;
using testing::GlTest;
using testing::make;
using testing::two_bones;
using testing::walker;

ViewGrid all_round(const char* text) { return parse_view_grid(text, -1.5, "test"); }

// A character whose joints do not move.
scene::PoseBank still(const scene::Character& character) { return scene::PoseBank::exact(character, -1, 0); }

double surface_area(const PieceSurface& surface, const std::vector<glm::vec3>& positions) {
  const std::vector<glm::vec3> p = corner_positions(surface, positions);
  double sum = 0;
  for (size_t i = 0; i + 2 < surface.indices.size(); i += 3)
    sum += 0.5 * static_cast<double>(glm::length(glm::cross(p[surface.indices[i + 1]] - p[surface.indices[i]],
                                                            p[surface.indices[i + 2]] - p[surface.indices[i]])));
  return sum;
}

TEST(PerJointPieces, AffineMapsAreInvertedUnlessTheyFlatten) {
  const scene::Mat3x4 m{{{0, -2, 0, 3}, {2, 0, 0, 5}, {0, 0, 2, 7}}};  // doubled and turned about z by a quarter
  scene::Mat3x4 back;
  ASSERT_TRUE(invert_affine(m, back));
  EXPECT_EQ(back.rows[0], glm::vec4(0, 0.5F, 0, -2.5F));
  EXPECT_EQ(back.rows[1], glm::vec4(-0.5F, 0, 0, 1.5F));
  EXPECT_EQ(back.rows[2], glm::vec4(0, 0, 0.5F, -3.5F));
  EXPECT_FALSE(invert_affine({{{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 0, 0}}}, back));
  EXPECT_EQ(back.rows[0], glm::vec4(0));
}

TEST(PerJointPieces, EndWhereTheirWeightDoes) {
  const scene::Character c = card_of_two_joints();
  const RestPose rest = rest_pose(c, still(c));
  const JointPieces pieces = find_joint_pieces(c, rest, 0.006);
  ASSERT_EQ(pieces.count(), 2);
  EXPECT_EQ(pieces.joint, (std::vector<int>{0, 1}));
  // Two metres wide; the upper one from the border up, the lower one up to what is left of one.
  for (const int piece : {0, 1}) {
    EXPECT_NEAR(surface_area(cut_joint_piece(c.mesh, pieces, piece, 0.5F), rest.positions), 1.0, 1e-5);
    EXPECT_NEAR(surface_area(cut_joint_piece(c.mesh, pieces, piece, 0.2F), rest.positions), 1.6, 1e-5);
  }
  for (const glm::vec3& p : corner_positions(cut_joint_piece(c.mesh, pieces, 1, 0.2F), rest.positions))
    EXPECT_GE(p.y, 0.2F - 1e-6F);
  const scene::Character alone = piece_character(c, rest, cut_joint_piece(c.mesh, pieces, 1, 0.2F));
  EXPECT_TRUE(alone.materials[0].double_sided);
  ASSERT_EQ(alone.mesh.primitives.size(), 1U);
  EXPECT_EQ(alone.mesh.primitives[0].index_count, alone.mesh.indices.size());
  for (size_t v = 0; v < alone.mesh.positions.size(); ++v) EXPECT_EQ(alone.mesh.normals[v], c.mesh.normals[0]);
}

TEST(PerJointPieces, SmallOnesGoWithTheJointAbove) {
  scene::Character c = card_of_two_joints();
  for (size_t v = 0; v < 4; ++v) c.mesh.weights[v] = {0.99F, 0.01F, 0.0F, 0.0F};
  const RestPose rest = rest_pose(c, still(c));
  EXPECT_EQ(find_joint_pieces(c, rest, 0.006).count(), 2);
  const JointPieces one = find_joint_pieces(c, rest, 0.02);
  EXPECT_EQ(one.count(), 1);
  EXPECT_EQ(one.piece_of, (std::vector<int>{0, 0}));
  EXPECT_NEAR(surface_area(cut_joint_piece(c.mesh, one, 0, 0.5F), rest.positions), 2.0, 1e-5);
}

// Nothing of a body is left out, wherever its pieces end; what has fingers does not have more of them.
TEST(PerJointPieces, HoldTheWholeSurface) {
  for (const int joints : {20, 53}) {
    const scene::Character body = scene::make_mannequin({.triangles = 2200, .joints = joints});
    const RestPose rest = rest_pose(body, still(body));
    const JointPieces pieces = find_joint_pieces(body, rest, 0.006);
    EXPECT_GT(pieces.count(), 14) << joints;
    EXPECT_LE(pieces.count(), 24) << joints;
    PieceSurface whole;
    for (uint32_t v = 0; v < body.mesh.positions.size(); ++v) whole.corners.push_back({v, v, 0});
    whole.indices = body.mesh.indices;
    const double all = surface_area(whole, rest.positions);
    for (const float border : kBorders) {
      double sum = 0;
      for (int p = 0; p < pieces.count(); ++p)
        sum += surface_area(cut_joint_piece(body.mesh, pieces, p, border), rest.positions);
      EXPECT_GT(sum, 0.999 * all) << border;
      EXPECT_LT(sum, (border == 0.5F ? 1.1 : 2.0) * all) << border;
    }
  }
}

TEST(PerJointBorder, TearsLessThanCutsWhereSkinBends) {
  const scene::Cast& cast = walker();
  const scene::Character& c = *cast.characters[0];
  const RestPose rest = rest_pose(c, *cast.banks[0]);
  const JointPieces pieces = find_joint_pieces(c, rest, 0.006);
  const BorderChoice one = choose_borders(c, *cast.banks[0], rest, pieces, all_round("cube-5"), 1);
  ASSERT_EQ(one.borders.size(), static_cast<size_t>(pieces.count()));
  EXPECT_LT(one.holes, 0.8 * one.holes_cut);
  EXPECT_LT(2 * one.holes + one.strays, 2 * one.holes_cut + one.strays_cut);
  EXPECT_GT(std::count_if(one.borders.begin(), one.borders.end(), [](float b) { return b < 0.5F; }), 4);
  const BorderChoice two = choose_borders(c, *cast.banks[0], rest, pieces, all_round("cube-5"), 2);
  EXPECT_EQ(two.borders, one.borders) << "whatever the threads";
}

// Boxes that share no skin end where they end, whatever the border.
TEST(PerJointBorder, ChangesNothingOfRigidPieces) {
  const scene::Cast cast = cast_of(two_bones());
  const scene::Character& c = *cast.characters[0];
  const RestPose rest = rest_pose(c, *cast.banks[0]);
  const JointPieces pieces = find_joint_pieces(c, rest, 0.006);
  const BorderChoice choice = choose_borders(c, *cast.banks[0], rest, pieces, all_round("cube-5"), 1);
  EXPECT_EQ(choice.holes, choice.holes_cut);
  EXPECT_EQ(choice.strays, choice.strays_cut);
}

TEST(PerJointBake, ComesBackFromItsBytesOrNotAtAll) {
  PerJointBake bake;
  bake.texel = 0.5F;
  bake.pieces = bake.views = bake.levels = 1;
  bake.joints = {3};
  bake.inverse.resize(3);
  bake.centres.resize(1);
  bake.borders = {0.25F};
  bake.tiles.resize(2);
  bake.outlines.resize(CB_PERJOINT_CORNERS);
  bake.width = bake.height = bake.layers = 1;
  bake.albedo = {1, 2, 3, 4};
  bake.surface = {5, 6, 7, 8};
  std::vector<uint8_t> bytes = serialise(bake);
  const auto back = deserialise_perjoint(bytes);
  ASSERT_TRUE(back.has_value());
  EXPECT_EQ(back->joints, bake.joints);
  EXPECT_EQ(back->surface, bake.surface);
  bytes.pop_back();
  EXPECT_FALSE(deserialise_perjoint(bytes).has_value());
  bake.tiles.resize(1);
  EXPECT_FALSE(deserialise_perjoint(serialise(bake)).has_value());
}

TEST(PerJointOptions, AreRefusedWhereTheyAreNone) {
  for (const char* bad : {"border=0.6", "border=0", "border=wide", "views=hemi-12", "views=sphere-8x4-mirrored",
                          "views=cube-0", "least=21", "texels=8", "depth=flat"})
    EXPECT_THROW((void)parse_spec(std::string("perjoint:") + bad), Error) << bad;
  EXPECT_NO_THROW((void)parse_spec("perjoint:border=0.25,views=sphere-12x7,least=0,depth=plane"));
}

class PerJointGl : public GlTest {};

TEST_F(PerJointGl, BytesDoNotDependOnTheClips) {
  const scene::Cast& one = walker();
  scene::Cast four = one;
  std::vector<int> clips(one.characters[0]->clips.size());
  std::iota(clips.begin(), clips.end(), 0);
  ASSERT_GE(clips.size(), 3U);
  four.banks = {std::make_shared<const scene::PoseBank>(*one.characters[0], clips)};
  const auto a = make(one, "perjoint:views=cube-2,texels=48");
  const auto b = make(four, "perjoint:views=cube-2,texels=48");
  EXPECT_EQ(a->footprint().texture_bytes, b->footprint().texture_bytes);
  EXPECT_EQ(a->footprint().buffer_bytes, b->footprint().buffer_bytes);
  EXPECT_GT(a->footprint().texture_bytes, 100'000U);
  // Their borders may differ, so bakes of other clips are other entries.
  const PerJointOptions options{.grid = all_round("cube-2")};
  EXPECT_NE(perjoint_cache_key(*one.characters[0], *one.banks[0], options, "r", "v"),
            perjoint_cache_key(*four.characters[0], *four.banks[0], options, "r", "v"));
}

// A pose that no stored picture was taken in: what is shown follows the joints.
TEST_F(PerJointGl, FollowsEveryPoseFromEverySide) {
  const scene::Cast& cast = walker();
  const auto mesh = make(cast, "mesh");
  const auto joints = make(cast, "perjoint:views=cube-4,texels=64");
  Renderer renderer(context(), cast);
  for (const testing::Viewpoint& view : {testing::Viewpoint{.azimuth = 20, .elevation = 5, .phase = 0.13},
                                         testing::Viewpoint{.azimuth = 200, .elevation = 35, .phase = 0.61},
                                         testing::Viewpoint{.azimuth = 110, .elevation = 80, .phase = 0.37}}) {
    const scene::Frame frame = frame_from(cast, view);
    const Capture truth = renderer.capture(frame, *mesh);
    const Capture shown = renderer.capture(frame, *joints);
    EXPECT_GT(testing::iou(truth, shown), 0.92) << view.azimuth;
  }
}

TEST_F(PerJointGl, SaysWhatABudgetHolds) {
  try {
    (void)make(walker(), "perjoint:views=cube-2", {.budget = 200'000});
    FAIL() << "it fits";
  } catch (const Error& e) {
    EXPECT_NE(e.wrong.find("the budget is"), std::string::npos) << e.what();
    EXPECT_NE(e.advice.find("texels="), std::string::npos) << e.what();
  }
}

}  // namespace
}  // namespace crowdbench::renderers
