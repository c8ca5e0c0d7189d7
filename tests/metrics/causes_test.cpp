// Error by cause: pictures made by hand, each with exactly one cause.
#include "metrics/causes.h"

#include <gtest/gtest.h>

#include <functional>
#include <limits>
#include <set>
#include <string>

#include "core/colour.h"
#include "core/error.h"
#include "core/random.h"
#include "metrics/agent_motion.h"
#include "metrics/picture_causes.h"
#include "metrics/surface_causes.h"

namespace crowdbench::metrics {
namespace {

constexpr double kAmbient = 0.25;
constexpr double kDiffuse = 0.75;

// The causes that have an amount.
std::set<std::string> named(const CauseRow& row) {
  std::set<std::string> out;
  for (const CauseDoc& doc : causes())
    if (row.amount(doc.cause) != 0) out.emplace(doc.name);
  return out;
}
std::set<std::string> only(const char* name) { return {name}; }

void expect_sum(const CauseErrors& errors) {
  const auto sum_of = [](const CauseRow& row) {
    int64_t sum = row.residue;
    for (const int64_t amount : row.amounts) sum += amount;
    return sum;
  };
  EXPECT_EQ(sum_of(errors.whole), errors.whole.total);
  int64_t agents = 0;
  for (const CauseRow& row : errors.agents) {
    EXPECT_EQ(sum_of(row), row.total) << row.id;
    agents += row.total;
  }
  EXPECT_LE(agents, errors.whole.total);
}

// ---- the chain itself

Image8 noise(uint64_t seed) {
  Image8 out(7, 5, 3);
  for (size_t i = 0; i < out.data.size(); ++i) out.data[i] = static_cast<uint8_t>(random_below(seed, i, 1, 256));
  return out;
}

TEST(Causes, WhatTheChainAddsIsEachCausesAmount) {
  Image8 reference(2, 1, 3);
  Image8 shaded = reference;
  shaded.data = {3, 0, 0, 0, 0, 0};
  Image8 textured = shaded;
  textured.data = {3, 4, 0, 1, 1, 1};
  ImageU32 owners(2, 1, 1);
  owners.data = {8, 0};
  const std::vector<CauseStep> steps = {{Cause::shading, shaded}, {std::nullopt, shaded}, {Cause::texture, textured}};
  const CauseErrors errors = error_by_cause(reference, steps, owners);
  EXPECT_EQ(errors.whole.amount(Cause::shading), 9);
  EXPECT_EQ(errors.whole.amount(Cause::texture), 16 + 3);
  EXPECT_EQ(errors.whole.residue, 0);
  EXPECT_EQ(errors.whole.total, 28);
  EXPECT_EQ(errors.whole.pixels, 2U);
  ASSERT_EQ(errors.agents.size(), 1U);
  EXPECT_EQ(errors.agents[0].id, 8U);
  EXPECT_EQ(errors.agents[0].total, 25);
  EXPECT_EQ(errors.agents[0].largest(), Cause::texture);
  EXPECT_EQ(errors.agent(8), errors.agents.data());
  EXPECT_EQ(errors.agent(9), nullptr);
}

TEST(Causes, AmountsAndResidueAddUpExactlyWhateverTheChain) {
  const Image8 reference = noise(1);
  std::vector<CauseStep> steps;
  for (const CauseDoc& doc : causes()) steps.push_back({doc.cause, noise(10 + static_cast<uint64_t>(doc.cause))});
  steps.insert(steps.begin() + 4, {std::nullopt, noise(99)});
  ImageU32 owners(7, 5, 1);
  for (size_t i = 0; i < owners.data.size(); ++i) owners.data[i] = static_cast<uint32_t>(i % 3);
  const CauseErrors errors = error_by_cause(reference, steps, owners);
  expect_sum(errors);
  int64_t squared = 0;
  for (size_t i = 0; i < reference.data.size(); ++i) {
    const int d = int{reference.data[i]} - int{steps.back().codes.data[i]};
    squared += d * d;
  }
  EXPECT_EQ(errors.whole.total, squared);
  EXPECT_THROW(error_by_cause(Image8(3, 3, 3), steps, owners), Error);
}

TEST(Causes, DocumentationNamesEveryCause) {
  const std::string text = causes_markdown();
  ASSERT_EQ(causes().size(), kCauses);
  for (size_t i = 0; i < kCauses; ++i) {
    EXPECT_EQ(static_cast<size_t>(causes()[i].cause), i);
    EXPECT_NE(text.find("`" + std::string(causes()[i].name) + "`"), std::string::npos);
    EXPECT_FALSE(causes()[i].drawn.empty() && causes()[i].read.empty());
  }
}

// ---- of surfaces

// Agent 1 stands before agent 2, which it hides partly, on 20 x 12 pixels.
struct Scene {
  Surfaces surfaces;
  Scene() {
    Surfaces& s = surfaces;
    s.codes = Image8(20, 12, 4);
    s.ids = ImageU32(20, 12, 1);
    s.depth = ImageF(20, 12, 1);
    s.base = s.emissive = ImageF(20, 12, 3);
    s.lambert = ImageF(20, 12, 1);
    std::fill(s.depth.data.begin(), s.depth.data.end(), std::numeric_limits<float>::infinity());
    std::fill(s.lambert.data.begin(), s.lambert.data.end(), -1.0F);
    paint(2, 8, 2, 16, 10, 6, {0.7F, 0.2F, 0.1F});
    paint(1, 3, 1, 11, 11, 5, {0.1F, 0.3F, 0.6F});
    light();
  }
  void paint(uint32_t id, int left, int top, int right, int bottom, float depth, std::array<float, 3> base) {
    for (int y = top; y < bottom; ++y)
      for (int x = left; x < right; ++x) {
        *surfaces.ids.at(x, y) = id;
        *surfaces.depth.at(x, y) = depth;
        std::copy(base.begin(), base.end(), surfaces.base.at(x, y));
        *surfaces.lambert.at(x, y) = 0.2F + 0.05F * static_cast<float>(y);
      }
  }
  void erase(int x, int y) {
    *surfaces.ids.at(x, y) = 0;
    *surfaces.depth.at(x, y) = std::numeric_limits<float>::infinity();
    *surfaces.lambert.at(x, y) = -1;
    std::fill_n(surfaces.base.at(x, y), 3, 0.0F);
  }
  void light() {
    for (size_t i = 0; i < surfaces.ids.pixels(); ++i)
      for (size_t c = 0; c < 3; ++c)
        surfaces.codes.data[4 * i + c] =
            surfaces.ids.data[i] == 0
                ? 128
                : linear_to_srgb8(static_cast<double>(surfaces.base.data[3 * i + c]) *
                                      (kAmbient + kDiffuse * static_cast<double>(surfaces.lambert.data[i])) +
                                  static_cast<double>(surfaces.emissive.data[3 * i + c]));
  }
  void each(uint32_t id, const std::function<void(int, int)>& change) {
    const ImageU32 ids = surfaces.ids;
    for (int y = 0; y < ids.height; ++y)
      for (int x = 0; x < ids.width; ++x)
        if (*ids.at(x, y) == id) change(x, y);
    light();
  }
};

CauseErrors told(const Surfaces& a, const Surfaces& b, const Image8& both = {}) {
  const SurfaceSubstitution of{a, b, kAmbient, kDiffuse, 0.02, both};
  const ImageU32* ids[] = {&a.ids, &b.ids};
  return error_by_cause(a.codes, substitute_surfaces(of), owners_of(ids));
}

void expect_only(const CauseErrors& errors, const char* name, uint32_t id) {
  expect_sum(errors);
  EXPECT_GT(errors.whole.total, 0);
  EXPECT_EQ(errors.whole.residue, 0);
  EXPECT_EQ(named(errors.whole), only(name));
  for (const CauseRow& row : errors.agents) EXPECT_EQ(row.total, row.id == id ? errors.whole.total : 0) << row.id;
}

TEST(SurfaceCauses, EqualPicturesHaveNone) {
  const Scene a;
  const CauseErrors errors = told(a.surfaces, a.surfaces);
  EXPECT_EQ(errors.whole.total, 0);
  EXPECT_TRUE(named(errors.whole).empty());
  EXPECT_FALSE(errors.whole.largest());
}

TEST(SurfaceCauses, EachIsFoundAndNothingElse) {
  const Scene a;
  {
    Scene b;
    b.each(2, [&](int x, int y) {
      if (x == 15) b.erase(x, y);
    });
    expect_only(told(a.surfaces, b.surfaces), "silhouette", 2);
  }
  {
    Scene b;  // something of the same agent that lies behind: another depth, another colour
    b.each(1, [&](int x, int y) {
      if (y < 4) b.paint(1, x, y, x + 1, y + 1, 5.3F, {0.9F, 0.9F, 0.1F});
    });
    expect_only(told(a.surfaces, b.surfaces), "surface", 1);
  }
  {
    Scene b;
    b.each(2, [&](int x, int y) { *b.surfaces.lambert.at(x, y) *= 0.6F; });
    expect_only(told(a.surfaces, b.surfaces), "shading", 2);
  }
  {
    Scene b;
    b.each(1, [&](int x, int y) { b.surfaces.base.at(x, y)[0] = 0.5F; });
    expect_only(told(a.surfaces, b.surfaces), "texture", 1);
  }
  {
    Scene b;
    b.each(1, [&](int x, int y) { b.surfaces.emissive.at(x, y)[1] = 0.2F; });
    expect_only(told(a.surfaces, b.surfaces), "texture", 1);
  }
  {
    Scene b;
    b.paint(2, 8, 2, 11, 10, 4.0F, {0.7F, 0.2F, 0.1F});  // now before agent 1
    b.light();
    Image8 both(20, 12, 1);
    std::fill(both.data.begin(), both.data.end(), uint8_t{255});
    expect_only(told(a.surfaces, b.surfaces, both), "order", 1);
    expect_only(told(a.surfaces, b.surfaces), "silhouette", 1);
  }
}

// Black shows no shading, so that a pixel that becomes black is a matter of texture alone.
TEST(SurfaceCauses, TheLightOnBlackIsTakenFromTheOtherSide) {
  const Scene a;
  Scene b;
  b.each(1, [&](int x, int y) {
    std::fill_n(b.surfaces.base.at(x, y), 3, 0.0F);
    *b.surfaces.lambert.at(x, y) = -1;
  });
  expect_only(told(a.surfaces, b.surfaces), "texture", 1);
  expect_only(told(b.surfaces, a.surfaces), "texture", 1);
}

TEST(SurfaceCauses, WhatIsNotLitByTheFormulaIsResidue) {
  const Scene a;
  Scene b;
  b.each(1, [](int, int) {});
  b.surfaces.codes.at(4, 4)[0] ^= 8;
  const CauseErrors errors = told(a.surfaces, b.surfaces);
  expect_sum(errors);
  EXPECT_EQ(errors.whole.residue, 64);
  EXPECT_EQ(errors.whole.total, 64);
}

// ---- of pictures alone

// Four agents beside each other, two more of which 5 stands before 6.
struct Pictures {
  Image8 codes{90, 40, 3};
  ImageU32 ids{90, 40, 1};
  ImageF depth{90, 40, 1};
  Pictures() {
    std::fill(codes.data.begin(), codes.data.end(), uint8_t{128});
    std::fill(depth.data.begin(), depth.data.end(), std::numeric_limits<float>::infinity());
  }
  // A figure that no shift brings onto itself: rows of changing colour, a head and an arm.
  void figure(uint32_t id, int left, int top, float metres, bool arm_up = false, int red = 0, double light = 1) {
    const auto put = [&](int x, int y) {
      *ids.at(x, y) = id;
      *depth.at(x, y) = metres;
      const int own[] = {90 + 3 * (y - top) + 10 * static_cast<int>(id) + red, 70 + 5 * (x - left), 60 + 2 * (y - top)};
      for (int c = 0; c < 3; ++c) codes.at(x, y)[c] = linear_to_srgb8(light * srgb_to_linear(own[c] / 255.0));
    };
    for (int y = 4; y < 24; ++y)
      for (int x = 2; x < 9; ++x) put(left + x, top + y);
    for (int y = 0; y < 4; ++y)
      for (int x = 4; x < 7; ++x) put(left + x, top + y);
    for (int i = 0; i < 6; ++i)
      for (int k = 0; k < 3; ++k) put(left + 9 + i / 2, top + (arm_up ? 8 - i : 8 + i) + k);
  }
  struct Changes {
    int moved_right = 0, moved_down = 0;
    bool arm_up = false, front_arm_up = false, swapped = false;
    int red = 0;
    double light = 1;
    float farther = 0;
  };
  static Pictures of(const Changes& changes) {
    Pictures out;
    out.figure(1, 2 + changes.moved_right, 6 + changes.moved_down, 5);
    out.figure(2, 18, 5, 5, changes.arm_up);
    out.figure(3, 33, 5, 5, false, changes.red);
    out.figure(4, 48, 5, 5 + changes.farther, false, 0, changes.light);
    for (const bool first : {true, false}) {
      if (first != changes.swapped)
        out.figure(6, 68, 6, changes.swapped ? 4.0F : 6.0F);
      else
        out.figure(5, 64, 5, 5, changes.front_arm_up);
    }
    return out;
  }
};

PictureCauses told(const Pictures& a, const Pictures& b, bool depths = false, const Pictures* posed = nullptr) {
  PicturesWithIds of{a.codes, b.codes, a.ids, b.ids};
  if (depths) {
    of.reference_depth = &a.depth;
    of.test_depth = &b.depth;
  }
  if (posed) {
    of.posed = &posed->codes;
    of.posed_ids = &posed->ids;
  }
  return causes_of_pictures(of);
}

const AgentChange& change(const PictureCauses& causes, uint32_t id) {
  for (const AgentChange& one : causes.changes)
    if (one.id == id) return one;
  throw std::logic_error("no such agent");
}

TEST(PictureCauses, EachIsFoundAndNothingElse) {
  const Pictures a = Pictures::of({});
  struct Case {
    Pictures::Changes changes;
    const char* cause;
    uint32_t id;
  };
  const Case cases[] = {{{.moved_right = 3, .moved_down = -2}, "place", 1},
                        {{.moved_right = -1}, "place", 1},
                        {{.arm_up = true}, "pose", 2},
                        {{.red = 60}, "texture", 3},
                        {{.light = 0.6}, "shading", 4},
                        {{.swapped = true}, "order", 5}};
  const Pictures posed = Pictures::of({.arm_up = true});
  for (const Case& one : cases) {
    SCOPED_TRACE(one.cause);
    for (const bool depths : {false, true}) {
      const Pictures b = Pictures::of(one.changes);
      const PictureCauses causes = told(a, b, depths, &posed);
      expect_only(causes.errors, one.cause, one.id);
      for (const AgentChange& of : causes.changes) {
        EXPECT_EQ(of.dx, of.id == 1 ? one.changes.moved_right : 0) << of.id;
        EXPECT_EQ(of.dy, of.id == 1 ? one.changes.moved_down : 0) << of.id;
        EXPECT_EQ(of.posed, of.id == 2 && one.changes.arm_up) << of.id;
        EXPECT_EQ(of.changed_places_with,
                  of.id == 5 && one.changes.swapped ? std::vector<uint32_t>{6} : std::vector<uint32_t>{})
            << of.id;
      }
    }
  }
}

TEST(PictureCauses, AllAtOnceAreTheirAgentsOwn) {
  const Pictures a = Pictures::of({});
  const Pictures posed = Pictures::of({.arm_up = true});
  const Pictures b =
      Pictures::of({.moved_right = 4, .moved_down = 1, .arm_up = true, .swapped = true, .red = 60, .light = 0.6});
  const PictureCauses causes = told(a, b, true, &posed);
  expect_sum(causes.errors);
  EXPECT_EQ(causes.errors.whole.residue, 0);
  const char* expected[] = {"place", "pose", "texture", "shading", "order"};
  for (uint32_t id = 1; id <= 5; ++id) EXPECT_EQ(named(*causes.errors.agent(id)), only(expected[id - 1])) << id;
  EXPECT_EQ(causes.errors.agent(6)->total, 0);
  EXPECT_EQ(change(causes, 1).dx, 4);
  EXPECT_EQ(change(causes, 1).dy, 1);
}

// An agent that went farther away and shows something else: the depths say so, and without them it is its texture.
TEST(PictureCauses, DepthsTellSurfacesFromTextures) {
  const Pictures a = Pictures::of({});
  Pictures b = Pictures::of({.farther = 0.5F});
  for (size_t i = 0; i < b.ids.pixels(); ++i)
    if (b.ids.data[i] == 4) b.codes.data[3 * i] = 30;
  EXPECT_EQ(named(told(a, b).errors.whole), only("texture"));
  EXPECT_FALSE(told(a, b).errors.available(Cause::surface));
  const PictureCauses causes = told(a, b, true);
  expect_only(causes.errors, "surface", 4);
  EXPECT_FALSE(change(causes, 4).farther) << "as large as before: not the same body farther away";
  EXPECT_NEAR(change(causes, 4).surface_farther.value(), 0.5, 1e-6);
  EXPECT_EQ(change(causes, 4).thickness, 0);
}

// A flat card at the place of a round body, in its plane: behind most of the surface that it shows, by less than the
// body is thick, and nowhere else than the body.
TEST(PictureCauses, AFlatCardAtItsPlaceIsNotFartherAway) {
  Pictures a = Pictures::of({});
  Pictures b = a;
  constexpr float kNearest = 5;
  constexpr float kRadius = 0.3F;
  for (int y = 0; y < a.ids.height; ++y)
    for (int x = 0; x < a.ids.width; ++x) {
      if (*a.ids.at(x, y) != 1) continue;
      const float across = std::min(1.0F, std::abs(static_cast<float>(x) - 7.5F) / 6);  // a cylinder
      *a.depth.at(x, y) = kNearest + kRadius * (1 - std::sqrt(1 - across * across));
      *b.depth.at(x, y) = kNearest + kRadius;
      for (int c = 0; c < 3; ++c) b.codes.at(x, y)[c] = static_cast<uint8_t>(b.codes.at(x, y)[c] / 2);
    }
  const AgentChange card = change(told(a, b, true), 1);
  EXPECT_EQ(card.dx, 0);
  EXPECT_FALSE(card.farther) << "its depths are a plane's, not a body's that moved";
  EXPECT_GT(card.surface_farther.value(), 0.15);
  EXPECT_GT(card.thickness, 0);
  EXPECT_EQ(change(told(a, a, true), 1).farther, 0) << "where it was";
  // A body of two planes, most of it the nearer: three quarters of the card are behind by the same.
  for (int y = 0; y < a.ids.height; ++y)
    for (int x = 0; x < a.ids.width; ++x) {
      if (*a.ids.at(x, y) != 1) continue;
      *a.depth.at(x, y) = y < 24 ? kNearest : kNearest + 0.15F;
      *b.depth.at(x, y) = kNearest + 0.15F;
    }
  const AgentChange block = change(told(a, b, true), 1);
  EXPECT_FALSE(block.farther) << "the relief of a body that moved would be there";
  EXPECT_NEAR(block.surface_farther.value(), 0.15, 1e-6);
  EXPECT_NEAR(block.thickness, 0.15, 1e-6);
}

// What is painted on a card is told from what stands behind or before its plane.
TEST(PictureCauses, APaintedCardIsTexture) {
  Pictures a = Pictures::of({});
  Pictures b = Pictures::of({.red = 60});
  for (int y = 0; y < a.ids.height; ++y)
    for (int x = 0; x < a.ids.width; ++x) {
      if (*a.ids.at(x, y) != 3) continue;
      const float across = std::min(1.0F, std::abs(static_cast<float>(x) - 38.5F) / 6);  // a cylinder
      *a.depth.at(x, y) = 5 + 0.3F * (1 - std::sqrt(1 - across * across));
      // A plane that leans and turns, seen through a lens: the reciprocal of its depth is linear.
      *b.depth.at(x, y) = 1 / (0.19F + 2e-4F * static_cast<float>(x) - 1e-4F * static_cast<float>(y));
    }
  const PictureCauses causes = told(a, b, true);
  expect_only(causes.errors, "texture", 3);
  EXPECT_TRUE(change(causes, 3).card);
  for (const uint32_t id : {1U, 2U, 4U}) EXPECT_FALSE(change(causes, id).card) << "as flat in the reference";
  // One pixel beside the plane, and it is no card: what is painted on it is still no colour of the agent near by.
  for (int y = 0; y < a.ids.height; ++y)
    for (int x = 0; x < a.ids.width; ++x)
      if (*a.ids.at(x, y) == 3 && y > 25) *b.depth.at(x, y) += 0.01F;
  const PictureCauses bent = told(a, b, true);
  EXPECT_FALSE(change(bent, 3).card);
  EXPECT_EQ(bent.errors.agent(3)->largest(), Cause::texture);
  // As far away as no point of the body is, it shows something else.
  for (int y = 0; y < a.ids.height; ++y)
    for (int x = 0; x < a.ids.width; ++x)
      if (*a.ids.at(x, y) == 3) *b.depth.at(x, y) += 1;
  EXPECT_EQ(told(a, b, true).errors.agent(3)->largest(), Cause::surface);
}

// A body of two halves, of which the test shows the one where the other was, in its colour: a wrong surface. In a
// colour that neither has it is painted, whatever its depth.
TEST(PictureCauses, AnotherSurfaceHasAColourOfTheBody) {
  const Pictures a = [] {
    Pictures out = Pictures::of({});
    for (size_t i = 0; i < out.ids.pixels(); ++i) {
      if (out.ids.data[i] != 1) continue;
      const bool lower = i / 90 > 20;
      out.depth.data[i] = lower ? 5.0F : 5.3F;
      const uint8_t codes[] = {static_cast<uint8_t>(lower ? 200 : 60), 90, static_cast<uint8_t>(lower ? 60 : 200)};
      std::copy_n(codes, 3, &out.codes.data[3 * i]);
    }
    return out;
  }();
  for (const bool painted : {false, true}) {
    SCOPED_TRACE(painted);
    Pictures b = a;
    for (size_t i = 0; i < b.ids.pixels(); ++i)
      if (b.ids.data[i] == 1 && i / 90 >= 20 && i / 90 < 23) {
        const uint8_t codes[] = {60, static_cast<uint8_t>(painted ? 200 : 90),
                                 static_cast<uint8_t>(painted ? 60 : 200)};
        std::copy_n(codes, 3, &b.codes.data[3 * i]);
        b.depth.data[i] = 5.2F;
      }
    expect_only(told(a, b, true).errors, painted ? "texture" : "surface", 1);
  }
}

// A repainting by any colour is told by the mean; what is darker, moved or late is not one.
TEST(PictureCauses, ARecolouredAgentIsSaidToBe) {
  const Pictures a = Pictures::of({});
  const Pictures posed = Pictures::of({.arm_up = true});
  const PictureCauses causes =
      told(a, Pictures::of({.moved_right = 4, .arm_up = true, .swapped = true, .red = 60, .light = 0.6}), true, &posed);
  for (const AgentChange& of : causes.changes) EXPECT_EQ(of.recoloured, of.id == 3) << of.id;
}

// A column less on the one side and one more on the other of ten rows: as much as a shift of the figure by a bit, of
// which no shift makes anything.
TEST(PictureCauses, AnOutlineThatIsWrongSaysHowWellThePlaceIsTold) {
  const Pictures a = Pictures::of({});
  Pictures b = a;
  size_t changed = 0;
  for (int y = 9; y < 29; ++y) {
    const int x = y % 2 == 0 ? 20 : 26;  // teeth on both sides of agent 2
    if (*b.ids.at(x, y) != 2) continue;
    *b.ids.at(x, y) = 0;
    ++changed;
  }
  ASSERT_GT(changed, 15U);
  const PictureCauses causes = told(a, b);
  EXPECT_EQ(change(causes, 2).dx, 0);
  const Extents extents = extents_of(a.ids);
  const double length = outline_length(a.ids, 2, extents.at(2));
  EXPECT_NEAR(change(causes, 2).told_px, static_cast<double>(changed) / length, 1e-9);
  for (const uint32_t id : {1U, 3U, 4U}) EXPECT_EQ(change(causes, id).told_px, 0);
  // What a shift by one pixel makes differ, along rows and down columns, in the mean.
  size_t across = 0, down = 0;
  for (int y = 1; y < a.ids.height; ++y)
    for (int x = 1; x < a.ids.width; ++x) {
      across += (*a.ids.at(x, y) == 2) != (*a.ids.at(x - 1, y) == 2) ? 1 : 0;
      down += (*a.ids.at(x, y) == 2) != (*a.ids.at(x, y - 1) == 2) ? 1 : 0;
    }
  EXPECT_EQ(length, 0.5 * static_cast<double>(across + down));
}

// Nothing is known of what another agent hides, so that a motion which fetches all of the agent from behind it
// contradicts nothing: it is no evidence. Here the reference shows a foot below the wall, the test does not, and the
// heads differ.
TEST(PictureCauses, AnAgentBehindAnotherDidNotMoveBecauseNothingSaysOtherwise) {
  Pictures a;
  a.figure(1, 10, 4, 6);
  Pictures b;
  b.figure(1, 10, 4, 6, false, 20);
  // A head that is less high and wider on both sides, which no shift explains.
  for (const int x : {14, 15, 16}) {
    *b.ids.at(x, 4) = 0;
    for (int c = 0; c < 3; ++c) b.codes.at(x, 4)[c] = 128;
  }
  for (const int x : {13, 17})
    for (const int y : {5, 6}) {
      *b.ids.at(x, y) = 1;
      *b.depth.at(x, y) = 6;
      std::copy_n(b.codes.at(15, y), 3, b.codes.at(x, y));
    }
  for (Pictures* of : {&a, &b})
    for (int y = 12; y < 30; ++y)
      for (int x = 2; x < 40; ++x) {
        if (of == &a && y == 27 && x == 14) continue;  // the foot
        *of->ids.at(x, y) = 9;
        *of->depth.at(x, y) = 4;
        for (int c = 0; c < 3; ++c) of->codes.at(x, y)[c] = static_cast<uint8_t>(60 + y);
      }
  for (const bool depths : {false, true}) {
    const PictureCauses causes = told(a, b, depths);
    EXPECT_EQ(change(causes, 1).dx, 0);
    EXPECT_EQ(change(causes, 1).dy, 0);
    EXPECT_EQ(causes.errors.agent(1)->amount(Cause::place), 0);
    EXPECT_GT(causes.errors.agent(1)->amount(Cause::silhouette), 0);
  }
}

// A slanted body that only moved in the picture is as far away as it was, point by point.
TEST(PictureCauses, AMovedAgentsDepthIsThatOfItsOwnPoints) {
  Pictures a = Pictures::of({});
  Pictures b = Pictures::of({.moved_right = 4, .moved_down = 1});
  for (auto& [pictures, left] : {std::pair<Pictures&, int>{a, 2}, std::pair<Pictures&, int>{b, 6}})
    for (int y = 0; y < pictures.ids.height; ++y)
      for (int x = 0; x < pictures.ids.width; ++x)
        if (*pictures.ids.at(x, y) == 1) *pictures.depth.at(x, y) = 5 + 0.05F * static_cast<float>(x - left);
  const PictureCauses causes = told(a, b, true);
  expect_only(causes.errors, "place", 1);
  EXPECT_EQ(change(causes, 1).dx, 4);
  EXPECT_NEAR(change(causes, 1).farther.value(), 0, 1e-6);
}

TEST(PictureCauses, WithoutThePosesALateAgentsOutlineIsWrong) {
  const PictureCauses causes = told(Pictures::of({}), Pictures::of({.arm_up = true}));
  EXPECT_FALSE(causes.errors.available(Cause::pose));
  EXPECT_EQ(causes.errors.agent(2)->largest(), Cause::silhouette);
  for (const Cause cause : {Cause::view, Cause::level}) EXPECT_FALSE(causes.errors.available(cause));
  EXPECT_THROW(causes_of_pictures({Image8(3, 3, 3), Image8(3, 3, 3), ImageU32(4, 3, 1), ImageU32(3, 3, 1)}), Error);
}

// The arm lies over the one behind before and after.
TEST(PictureCauses, AnArmThatMovesOverAnotherAgentIsNoChangeOfOrder) {
  for (const bool depths : {false, true}) {
    const PictureCauses causes = told(Pictures::of({}), Pictures::of({.front_arm_up = true}), depths);
    EXPECT_EQ(causes.errors.agent(5)->largest(), Cause::silhouette);
    for (const AgentChange& of : causes.changes) EXPECT_TRUE(of.changed_places_with.empty()) << of.id;
  }
}

TEST(PictureCauses, WhatNoAgentCoversIsResidue) {
  const Pictures a = Pictures::of({});
  Pictures b = a;
  b.codes.at(0, 0)[1] += 3;
  const PictureCauses causes = told(a, b);
  EXPECT_EQ(causes.errors.whole.residue, 9);
  EXPECT_EQ(causes.errors.whole.total, 9);
}

}  // namespace
}  // namespace crowdbench::metrics
