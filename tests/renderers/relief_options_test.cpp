// What the options of bone-relief impostors promise: resolution by joint, the published sizes, triangle rules.
#include <gtest/gtest.h>

#include <algorithm>
#include <string>

#include "core/error.h"
#include "gl_test_support.h"
#include "solids.h"

namespace crowdbench::renderers {
namespace {

using testing::cast_of;
using testing::context;
using testing::GlTest;

class ReliefOptionsGl : public GlTest {};

std::unique_ptr<Representation> make(const scene::Cast& cast, const std::string& spec) {
  return make_representation({.context = context(), .cast = cast, .use_cache = false}, parse_spec(spec));
}

double number(const std::vector<std::pair<std::string, double>>& facts, const std::string& name) {
  for (const auto& [key, value] : facts)
    if (key == name) return value;
  ADD_FAILURE() << "no fact " << name;
  return 0;
}

// By name or by number, over what map and size say; the rest keep theirs.
TEST_F(ReliefOptionsGl, ResolutionOfSingleJoints) {
  const scene::Cast cast = cast_of(testing::two_bones());  // joints "lower" and "upper"
  const auto texels = [&](const std::string& options) {
    std::vector<double> out;
    for (const BakePart& part : make(cast, "relief:map=64,merge=0,capture=bind" + options)->bake_info().parts)
      out.push_back(number(part.facts, "texels"));
    return out;
  };
  EXPECT_EQ(texels(""), (std::vector<double>{64, 64}));
  EXPECT_EQ(texels(",resolution=upper@256"), (std::vector<double>{64, 256}));
  EXPECT_EQ(texels(",resolution=0@16+upper@32"), (std::vector<double>{16, 32}));
  EXPECT_EQ(texels(",size=by_area,resolution=lower@256"), (std::vector<double>{256, 64}));
  // Finer maps on one joint are seen in the bytes: 4.5 n x n texels of 20.5 bytes each.
  const auto plain = make(cast, "relief:map=64,merge=0,capture=bind");
  const auto fine = make(cast, "relief:map=64,merge=0,capture=bind,resolution=upper@128");
  EXPECT_EQ(number(fine->bake_info().parts[1].facts, "bytes"), 4.5 * 128 * 128 * 20.5);
  EXPECT_EQ(number(plain->bake_info().parts[1].facts, "bytes"), 4.5 * 64 * 64 * 20.5);
  EXPECT_GT(number(fine->bake_info().facts, "actual_bytes"), number(plain->bake_info().facts, "actual_bytes"));
}

// Under a budget all sizes are halved alike, so that what was worth more stays so.
TEST_F(ReliefOptionsGl, ABudgetKeepsTheProportions) {
  const scene::Cast cast = cast_of(testing::two_bones());
  const auto fits = make(cast, "relief:map=64,merge=0,capture=bind,resolution=upper@256,budget=2.2");
  // Whole: 4.5 x 20.5 x (64^2 + 256^2) = 6.4 MB and the shelf's rest; halved: a quarter.
  EXPECT_EQ(number(fits->bake_info().parts[0].facts, "texels"), 32);
  EXPECT_EQ(number(fits->bake_info().parts[1].facts, "texels"), 128);
  EXPECT_LE(number(fits->bake_info().facts, "actual_bytes"), 2.2 * 1048576);
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
    EXPECT_NE(said(wrong).find("relief: resolution"), std::string::npos) << wrong << ": " << said(wrong);
}

// The kinds add up to what the textures take.
TEST_F(ReliefOptionsGl, BytesByKindAddUp) {
  const scene::Cast cast = cast_of(testing::two_bones());
  for (const char* spec : {"relief:map=64,search=cone", "relief:map=64,depth=8,merge=16"}) {
    const auto relief = make(cast, spec);
    const auto& facts = relief->bake_info().facts;
    double sum = 0;
    for (const char* kind :
         {"depth_bytes", "colour_bytes", "normal_bytes", "bounds_bytes", "cone_bytes", "merged_bytes"})
      sum += number(facts, kind);
    EXPECT_EQ(sum, number(facts, "actual_bytes")) << spec;
    EXPECT_EQ(sum, static_cast<double>(relief->footprint().texture_bytes)) << spec;
    EXPECT_LT(number(facts, "level_bytes"), sum);
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
  EXPECT_EQ(number(relief->bake_info().facts, "nominal_bytes"), 7'864'320);
  EXPECT_EQ(number(relief->bake_info().facts, "boxes"), 1) << "joints without triangles have none";
  EXPECT_EQ(relief->bake_info().parts.size(), 40U);
  EXPECT_EQ(number(relief->bake_info().parts[39].facts, "bytes"), 0);
}

}  // namespace
}  // namespace crowdbench::renderers
