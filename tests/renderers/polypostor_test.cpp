#include <gtest/gtest.h>
#include <stdlib.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <functional>
#include <limits>
#include <numbers>
#include <numeric>
#include <set>

#include "core/error.h"
#include "core/files.h"
#include "core/random.h"
#include "renderers/bake_cache.h"
#include "renderers/polypostor/polypostor_bake.h"
#include "renderers/polypostor/polypostor_fit.h"
#include "renderers/polypostor/polypostor_key.h"
#include "scene/gltf.h"
#include "scene/mannequin.h"
#include "tests/renderers/gl_test_support.h"
#include "tests/support/scratch_folder.h"

namespace crowdbench::renderers {
namespace {

namespace fs = std::filesystem;
using testing::add_agent;
using testing::card;
using testing::cast_of;
using testing::context;
using testing::frame_of_one;
using testing::GlTest;

// ---- outlines
// ---------------------------------------------------------------------------------------------------------

// Rows as one reads them, the top one first; '#' is covered.
PartMask mask_of(const std::vector<std::string>& rows) {
  PartMask mask;
  mask.width = static_cast<int>(rows[0].size());
  mask.height = static_cast<int>(rows.size());
  for (size_t r = rows.size(); r-- > 0;)
    for (const char c : rows[r]) mask.on.push_back(c == '#' ? 3 : 0);
  return mask;
}
// In samples.
double area_of(const Polyline& contour) { return signed_area(contour) * kMaskSamples * kMaskSamples; }

TEST(PolypostorContour, OfOneSampleIsItsDiamond) {
  const Polyline c = trace_contour(mask_of({"...", ".#.", "..."}));
  ASSERT_EQ(c.size(), 4U);
  EXPECT_NEAR(area_of(c), 0.5, 1e-12) << "through the middles of its four sides, counter-clockwise";
  for (const glm::dvec2& p : c) EXPECT_NEAR(glm::distance(p * double{kMaskSamples}, glm::dvec2(1.5)), 0.5, 1e-12);
}

TEST(PolypostorContour, OfNothingIsNothing) {
  EXPECT_TRUE(trace_contour(mask_of({"...", "..."})).empty());
  EXPECT_TRUE(trace_contour(PartMask{}).empty());
}

TEST(PolypostorContour, PassesOverHoles) {
  const Polyline full = trace_contour(mask_of({"#####", "#####", "#####", "#####", "#####"}));
  const Polyline holed = trace_contour(mask_of({"#####", "#...#", "#...#", "#...#", "#####"}));
  EXPECT_EQ(full, holed);
  // A square of n samples: its corners are cut by a half times a half each.
  EXPECT_NEAR(area_of(full), 25 - 4 * 0.125, 1e-12);
  EXPECT_EQ(full.size(), 20U) << "the mask fills its border";
}

TEST(PolypostorContour, DiagonalNeighboursTouch) {
  const Polyline c = trace_contour(mask_of({"##..", "##..", "..##", "..##"}));
  EXPECT_EQ(c.size(), 16U) << "the borders of both squares, walked once";
}

TEST(PolypostorContour, BridgesTwoComponents) {
  const Polyline c = trace_contour(mask_of({"##....##", "##....##"}));
  double left = 1e9;
  double right = -1e9;
  for (const glm::dvec2& p : c) {
    left = std::min(left, p.x * kMaskSamples);
    right = std::max(right, p.x * kMaskSamples);
  }
  EXPECT_EQ(left, 0);
  EXPECT_EQ(right, 8) << "both are within one outline";
  EXPECT_NEAR(area_of(c), 4 + 4 + 4, 1.5) << "two squares and a bridge of four samples";
}

TEST(PolypostorContour, RasteriserCoversWhatLiesInside) {
  // A right triangle of legs 6 texels: half the square, give or take samples on the long side.
  const std::vector<glm::dvec2> t = {{0, 0}, {6, 0}, {0, 6}};
  const PartMask mask = rasterise(t);
  EXPECT_NEAR(covered_area(mask), 18, 1.1);
  EXPECT_EQ(facing_area(mask), covered_area(mask)) << "counter-clockwise faces the eye";
  const std::vector<glm::dvec2> back = {{0, 0}, {0, 6}, {6, 0}};
  EXPECT_EQ(facing_area(rasterise(back)), 0);
  EXPECT_EQ(covered_area(rasterise(back)), covered_area(mask));
}

TEST(PolypostorContour, OutwardPolygonsHoldTheirContour) {
  // Blobs of random discs, in all the budgets.
  for (uint64_t seed = 0; seed < 40; ++seed) {
    PartMask mask;
    mask.width = mask.height = 60;
    mask.on.assign(3600, 0);
    for (uint64_t disc = 0; disc < 3; ++disc) {
      const auto r = [&](uint64_t k) { return random_unit(seed, disc, k); };
      const double x = 10 + 40 * r(0);
      const double y = 10 + 40 * r(1);
      const double radius = 2 + 8 * r(2);
      for (int j = 0; j < 60; ++j)
        for (int i = 0; i < 60; ++i)
          if (std::hypot(i - x, j - y) < radius) mask.on[static_cast<size_t>(j * 60 + i)] = 3;
    }
    const Polyline contour = trace_contour(mask);
    for (const int corners : {4, 6, 8, 12}) {
      const Polyline polygon = outward_polygon(contour, corners, 0.5, 0.5);
      SCOPED_TRACE(::testing::Message() << seed << ", " << corners);
      EXPECT_LE(polygon.size(), static_cast<size_t>(corners));
      EXPECT_TRUE(is_simple(polygon));
      for (const glm::dvec2& p : contour) ASSERT_TRUE(contains(polygon, p));
    }
  }
}

TEST(PolypostorContour, OutwardPolygonsAreTight) {
  Polyline circle;
  for (int i = 0; i < 200; ++i) {
    const double angle = 2 * std::numbers::pi * i / 200;
    circle.push_back(10.0 * glm::dvec2(std::cos(angle), std::sin(angle)));
  }
  // The least polygon of n corners around a circle is regular, of n r^2 tan(pi / n).
  for (const int corners : {4, 6, 8, 12}) {
    const double least = corners * 100 * std::tan(std::numbers::pi / corners);
    EXPECT_LT(signed_area(outward_polygon(circle, corners, 0, 0.01)), 1.2 * least) << corners;
  }
}

TEST(PolypostorContour, SimplePolygonsAreToldFromKnots) {
  EXPECT_TRUE(is_simple({{0, 0}, {2, 0}, {2, 2}, {0, 2}}));
  EXPECT_FALSE(is_simple({{0, 0}, {2, 2}, {2, 0}, {0, 2}}));
}

// ---- correspondence
// ---------------------------------------------------------------------------------------------------

// All monotone cyclic choices, one after another.
double brute_force(const Polyline& samples, const Polyline& predicted) {
  const size_t m = samples.size();
  const size_t n = predicted.size();
  double best = std::numeric_limits<double>::infinity();
  std::vector<size_t> at(n);
  const std::function<void(size_t, size_t, size_t)> place = [&](size_t i, size_t start, size_t offset) {
    at[i] = (start + offset) % m;
    if (i + 1 == n) {
      best = std::min(best, correspondence_cost(samples, predicted, at));
      return;
    }
    for (size_t next = offset + 1; next < m; ++next) place(i + 1, start, next);
  };
  for (size_t start = 0; start < m; ++start) place(0, start, 0);
  return best;
}

Polyline wobbly_circle(uint64_t seed, size_t count, double turn) {
  Polyline out;
  for (size_t i = 0; i < count; ++i) {
    const double angle = 2 * std::numbers::pi * static_cast<double>(i) / static_cast<double>(count) + turn;
    const double radius = 5 + 2 * random_unit(seed, i, 7);
    out.push_back(radius * glm::dvec2(std::cos(angle), 0.6 * std::sin(angle)));
  }
  return out;
}

TEST(PolypostorCorrespondence, IsTheLeastOfAll) {
  for (uint64_t seed = 0; seed < 12; ++seed) {
    const Polyline samples = wobbly_circle(seed, 9, 0);
    const Polyline predicted = wobbly_circle(seed + 100, 4, 0.5 * static_cast<double>(seed));
    const Correspondence found = correspond(samples, predicted);
    EXPECT_NEAR(found.cost, brute_force(samples, predicted), 1e-9) << seed;
    EXPECT_NEAR(found.cost, correspondence_cost(samples, predicted, found.at), 1e-9)
        << "the cost is that of its choice";
  }
}

TEST(PolypostorCorrespondence, GoesRoundOnceInOrder) {
  for (uint64_t seed = 0; seed < 20; ++seed) {
    const Polyline samples = wobbly_circle(seed, 48, 0);
    const Correspondence found = correspond(samples, wobbly_circle(seed + 50, 8, 1.3 * static_cast<double>(seed)));
    size_t round = 0;
    for (size_t i = 0; i < found.at.size(); ++i) {
      const size_t step = (found.at[(i + 1) % 8] + 48 - found.at[i]) % 48;
      EXPECT_GT(step, 0U);
      round += step;
    }
    EXPECT_EQ(round, 48U) << "each later than the one before, and once round";
  }
}

TEST(PolypostorCorrespondence, StartsWhereverTheOutlineDoes) {
  const Polyline samples = wobbly_circle(3, 40, 0);
  const Polyline predicted = wobbly_circle(4, 7, 0.2);
  const Correspondence found = correspond(samples, predicted);
  for (const size_t shift : {1U, 13U, 39U}) {
    Polyline turned = samples;
    std::rotate(turned.begin(), turned.begin() + static_cast<std::ptrdiff_t>(shift), turned.end());
    const Correspondence again = correspond(turned, predicted);
    EXPECT_NEAR(again.cost, found.cost, 1e-9);
    for (size_t i = 0; i < 7; ++i) EXPECT_EQ((again.at[i] + shift) % 40, found.at[i]);
  }
}

// ---- triangulation and fit
// --------------------------------------------------------------------------------------------

TEST(PolypostorTriangulation, AvoidsWhatWouldFold) {
  // A square; in the second pose corner 1 is pushed past the diagonal 0-2, so that only the other diagonal works.
  const Polyline key = {{0, 0}, {4, 0}, {4, 4}, {0, 4}};
  const std::vector<Polyline> poses = {key, {{0, 0}, {1, 2.5}, {4, 4}, {0, 4}}};
  ASSERT_GT(signed_area(poses[1]), 0);
  const auto triangles = triangulate(key, poses);
  ASSERT_EQ(triangles.size(), 2U);
  for (const Polyline& pose : poses) EXPECT_EQ(inverted_triangles(pose, triangles), 0U);
  EXPECT_GT(inverted_triangles(poses[1], std::vector<Triangle>{{0, 1, 2}, {0, 2, 3}}), 0U)
      << "the other diagonal folds";
}

TEST(PolypostorTriangulation, CoversConcavePolygonsOnce) {
  const Polyline key = {{0, 0}, {6, 0}, {6, 6}, {3, 1}, {0, 6}};
  const auto triangles = triangulate(key, std::vector<Polyline>{key});
  ASSERT_EQ(triangles.size(), 3U);
  EXPECT_EQ(inverted_triangles(key, triangles), 0U);
  double area = 0;
  for (const Triangle& t : triangles) area += signed_area({key[t[0]], key[t[1]], key[t[2]]});
  EXPECT_NEAR(area, signed_area(key), 1e-12);
  EXPECT_TRUE(triangulate({{0, 0}, {1, 0}, {2, 0}}, {}).empty()) << "a line has none";
}

Polyline turned(const Polyline& line, double angle, const glm::dvec2& shift = glm::dvec2(0.0)) {
  Polyline out;
  for (const glm::dvec2& p : line)
    out.push_back(
        glm::dvec2(std::cos(angle) * p.x - std::sin(angle) * p.y, std::sin(angle) * p.x + std::cos(angle) * p.y) +
        shift);
  return out;
}

std::vector<glm::dvec2> triangles_of(const Polyline& quad) {
  return {quad[0], quad[1], quad[2], quad[0], quad[2], quad[3]};
}

TEST(PolypostorFit, ARigidSquareThatTurnsIsReproducedExactly) {
  const Polyline square = {{-9, -9}, {9, -9}, {9, 9}, {-9, 9}};
  constexpr size_t kFrames = 12;
  const auto angle = [](size_t f) { return 2 * std::numbers::pi * static_cast<double>(f) / kFrames; };
  std::vector<Polyline> contours;
  for (size_t f = 0; f < kFrames; ++f)
    contours.push_back(trace_contour(rasterise(triangles_of(turned(square, angle(f))))));
  const auto carry = [&](const glm::dvec2& p) {
    Polyline out;
    for (size_t f = 0; f < kFrames; ++f) out.push_back(turned({p}, angle(f))[0]);
    return out;
  };
  const Fit fit = fit_part(contours, 0, carry, {});
  ASSERT_GE(fit.polygon.size(), 4U);
  EXPECT_EQ(fit.repaired, 0U);
  for (size_t f = 0; f < kFrames; ++f) {
    const Polyline exact = turned(fit.polygon, angle(f));
    for (size_t i = 0; i < exact.size(); ++i) EXPECT_LT(glm::distance(fit.poses[f][i], exact[i]), 1e-9) << f;
    EXPECT_NEAR(fit.turns[f].x, std::cos(angle(f)), 1e-9);
    EXPECT_NEAR(fit.turns[f].y, std::sin(angle(f)), 1e-9);
  }
}

TEST(PolypostorFit, FollowsTheOutlineWhereTheMotionIsUnknown) {
  // A bar that grows longer, while its carried points stay: the polygon must take the length from the outline.
  std::vector<Polyline> contours;
  for (const double half : {8.0, 9.5, 11.0}) {
    const Polyline bar = {{-half, -4}, {half, -4}, {half, 4}, {-half, 4}};
    contours.push_back(trace_contour(rasterise(triangles_of(bar))));
  }
  const Fit fit = fit_part(contours, 0, [](const glm::dvec2& p) { return Polyline(3, p); }, {});
  for (size_t f = 0; f < 3; ++f) {
    EXPECT_LT(fit.errors[f], 0.25) << f;
    const auto [left, right] = std::minmax_element(fit.poses[f].begin(), fit.poses[f].end(),
                                                   [](const auto& a, const auto& b) { return a.x < b.x; });
    EXPECT_NEAR(right->x - left->x, 2 * (8 + 1.5 * static_cast<double>(f)), 2.5) << f;
    EXPECT_EQ(inverted_triangles(fit.poses[f], fit.triangles), 0U);
  }
}

TEST(PolypostorFit, NoTriangleIsInvertedWhateverTheOutlinesDo) {
  size_t repaired = 0;
  for (uint64_t seed = 0; seed < 25; ++seed) {
    std::vector<Polyline> contours;
    for (uint64_t f = 0; f < 6; ++f) contours.push_back(wobbly_circle(31 * seed + f, 30, 0));
    // The motion turns the wrong way, so that correspondences disagree with it.
    const auto carry = [&](const glm::dvec2& p) {
      Polyline out;
      for (size_t f = 0; f < 6; ++f) out.push_back(turned({p}, -1.1 * static_cast<double>(f))[0]);
      return out;
    };
    FitOptions options;
    options.corners = 10;
    options.quantum = 0.05;
    const Fit fit = fit_part(contours, seed % 6, carry, options);
    ASSERT_FALSE(fit.triangles.empty());
    EXPECT_EQ(fit.triangles.size(), fit.polygon.size() - 2);
    for (const Polyline& pose : fit.poses) EXPECT_EQ(inverted_triangles(pose, fit.triangles), 0U) << seed;
    repaired += fit.repaired;
  }
  EXPECT_GT(repaired, 0U) << "or nothing was put to the test";
}

TEST(PolypostorFit, PartsThatVanishAreOnePointThere) {
  const Polyline square = {{-6, -6}, {6, -6}, {6, 6}, {-6, 6}};
  const Polyline contour = trace_contour(rasterise(triangles_of(square)));
  const Fit fit = fit_part(std::vector<Polyline>{contour, {}, contour, {}}, 2,
                           [](const glm::dvec2& p) { return Polyline(4, p); }, {});
  ASSERT_GE(fit.polygon.size(), 4U);
  for (const size_t f : {1U, 3U})
    for (const glm::dvec2& p : fit.poses[f]) EXPECT_EQ(p, fit.poses[f][0]) << "draws nothing";
  EXPECT_LT(glm::length(fit.poses[1][0]), 1.0) << "in its middle";
  EXPECT_EQ(fit.poses[0], fit.poses[2]);
}

// ---- keys
// -------------------------------------------------------------------------------------------------------------

// A square of 8 x 8 texels around the origin, turned in the plane; half of it leans towards +x.
struct LookedAt {
  std::vector<glm::dvec3> positions;
  std::vector<glm::vec3> normals;
};
LookedAt square_turned(double angle, const glm::vec3& normal) {
  LookedAt out;
  for (const glm::dvec2& p : turned({{-4, -4}, {4, -4}, {4, 4}, {-4, 4}}, angle)) out.positions.emplace_back(p, 0.0);
  const glm::dvec2 n = turned({glm::dvec2(normal)}, angle)[0];
  out.normals.assign(4, glm::vec3(static_cast<float>(n.x), static_cast<float>(n.y), normal.z));
  return out;
}
const std::vector<uint32_t> kSquare = {0, 1, 2, 0, 2, 3};
PartLook look(const LookedAt& square, const glm::vec3& tone) {
  return look_at_part(kSquare, square.positions, square.normals, std::vector<glm::vec3>(4, tone));
}

TEST(PolypostorKey, LooksShowTheNearestSurfaceFromEitherSide) {
  // A white square, and behind it, seen from its back, a larger black one.
  std::vector<glm::dvec3> positions = {{-2, -2, 1}, {2, -2, 1}, {2, 2, 1}, {-2, 2, 1},
                                       {-4, -4, 0}, {4, -4, 0}, {4, 4, 0}, {-4, 4, 0}};
  std::vector<glm::vec3> normals(4, glm::vec3(0.6F, 0.0F, 0.8F));
  normals.insert(normals.end(), 4, glm::vec3(0.0F, 0.0F, -3.0F));
  std::vector<glm::vec3> tones(4, glm::vec3(1.0F));
  tones.insert(tones.end(), 4, glm::vec3(0.0F));
  const std::vector<uint32_t> corners = {0, 1, 2, 0, 2, 3, 4, 6, 5, 4, 7, 6};
  const PartLook seen = look_at_part(corners, positions, normals, tones);
  ASSERT_EQ(seen.samples.size(), 64U);
  EXPECT_EQ(seen.x, -4);
  size_t white = 0;
  for (size_t i = 0; i < 64; ++i) {
    const bool front = seen.samples[i].tone.x > 0.5F;
    white += front ? 1 : 0;
    const glm::vec3 normal = front ? glm::vec3(0.6F, 0.0F, 0.8F) : glm::vec3(0.0F, 0.0F, 1.0F);
    EXPECT_LT(glm::distance(seen.samples[i].normal, normal), 1e-6F) << i << ": of length one, towards the eye";
  }
  EXPECT_EQ(white, 16U);
}

TEST(PolypostorKey, ErrorsAreWhatTheyAreSaidToBe) {
  const glm::vec3 ahead(0.0F, 0.0F, 1.0F);
  const glm::vec3 leaning(0.6F, 0.0F, 0.8F);
  const auto error = [&](const LookedAt& from, const glm::vec3& tone_from, const LookedAt& to, const glm::vec3& tone) {
    return look_error(look(from, tone_from), look(to, tone), kSquare, from.positions, to.positions);
  };
  const glm::vec3 white(1.0F);
  const LookedAt still = square_turned(0, leaning);
  EXPECT_NEAR(error(still, white, still, white), 0, 1e-9);
  EXPECT_NEAR(error(still, white, square_turned(std::numbers::pi / 2, leaning), white), 0, 1e-3)
      << "normals turn with the image";
  // White to black: of every sample a third of the squared length, in three channels. Grey: a quarter.
  EXPECT_NEAR(error(still, white, still, glm::vec3(0.0F)), 64, 1e-3);
  EXPECT_NEAR(error(still, white, still, glm::vec3(0.5F)), 16, 1e-3);
  // Normals apart by (0.6, 0, -0.2).
  EXPECT_NEAR(error(still, white, square_turned(0, ahead), white), 64 * 0.4, 1e-3);
  // Nothing to show: half of what is sent.
  PartLook nothing = look(still, white);
  for (auto& s : nothing.samples) s = {};
  EXPECT_NEAR(look_error(nothing, look(still, white), kSquare, still.positions, still.positions), 64 * kUnseen, 1e-3);
}

TEST(PolypostorKey, TonesAreThoseOfMaterialsImagesAndVertices) {
  scene::Character c = card(1, 1, {0.25F, 1.0F, 1.0F, 1.0F});
  EXPECT_LT(glm::distance(vertex_tones(c)[0], glm::vec3(0.5F, 1.0F, 1.0F)), 1e-6F) << "square root of linear";
  scene::Texture texture;
  texture.image = Image8(2, 1, 4);
  texture.image.data = {255, 0, 0, 255, 0, 255, 0, 255};
  c.images.push_back(texture);
  c.materials[0].base_colour_image = 0;
  c.mesh.uvs[0] = {0.75F, 0.5F};
  c.mesh.uvs[1] = {1.25F, 0.5F};
  const auto tones = vertex_tones(c);
  EXPECT_LT(glm::distance(tones[0], glm::vec3(0.0F, 1.0F, 0.0F)), 1e-6F);
  EXPECT_LT(glm::distance(tones[1], glm::vec3(0.5F, 0.0F, 0.0F)), 1e-6F) << "images repeat";
  c.materials[0].emissive = {0.11F, 0.25F, 9.0F};
  EXPECT_LT(glm::distance(vertex_tones(c)[1], glm::vec3(0.6F, 0.5F, 1.0F)), 1e-6F) << "0.25 and 0.11 of linear light";
}

// ---- parts
// ------------------------------------------------------------------------------------------------------------

TEST(PolypostorParts, AreThoseOfABodyWithoutReadingANameOnce) {
  for (const int joints : {20, 53}) {
    scene::Character body = scene::make_mannequin({.triangles = 2200, .joints = joints});
    const BodyParts parts = find_parts(body);
    EXPECT_EQ(parts.fine.count, 14) << "trunk, head, three of each limb";
    EXPECT_EQ(parts.coarse.count, 10) << "hands and feet go with what carries them";
    for (scene::Joint& j : body.skeleton.joints) j.name = "x";
    for (scene::Node& n : body.skeleton.nodes) n.name = "x";
    const BodyParts nameless = find_parts(body);
    EXPECT_EQ(nameless.fine.part_of, parts.fine.part_of);
    EXPECT_EQ(nameless.coarse.part_of, parts.coarse.part_of);
    // All of the surface belongs somewhere, and what is around joints to two.
    const CutCharacter cut = cut_at_parts(body, parts.fine);
    const auto area = [](const scene::Mesh& mesh, const std::vector<uint32_t>& triangles) {
      double sum = 0;
      for (const uint32_t t : triangles) {
        const auto corner = [&](uint32_t k) { return glm::dvec3(mesh.positions[mesh.indices[3 * t + k]]); };
        sum += 0.5 * glm::length(glm::cross(corner(1) - corner(0), corner(2) - corner(0)));
      }
      return sum;
    };
    std::vector<uint32_t> all(body.triangles());
    std::iota(all.begin(), all.end(), 0U);
    const double whole = area(body.mesh, all);
    double sum = 0;
    for (const auto& of_part : cut.triangles) {
      EXPECT_FALSE(of_part.empty());
      EXPECT_TRUE(std::is_sorted(of_part.begin(), of_part.end()));
      sum += area(cut.character->mesh, of_part);
    }
    EXPECT_GT(sum, 1.03 * whole);
    EXPECT_LT(sum, 1.3 * whole);
  }
}

TEST(PolypostorParts, AreCutWhereTheirWeightEnds) {
  // A card of two joints: the upper one's weight is the height. Its part ends at 0.3, the lower one's at 0.7.
  scene::Character c = card(2, 1);
  c.skeleton.nodes.push_back(c.skeleton.nodes[0]);
  c.skeleton.nodes[1].parent = 0;
  c.skeleton.joints.push_back(c.skeleton.joints[0]);
  c.skeleton.joints[1].node = 1;
  for (size_t v = 0; v < 4; ++v) {
    const float h = c.mesh.positions[v].y;
    c.mesh.joints[v] = {0, 1, 0, 0};
    c.mesh.weights[v] = {1 - h, h, 0.0F, 0.0F};
    c.mesh.uvs[v] = {c.mesh.positions[v].x, 10 * h};
  }
  const CutCharacter cut = cut_at_parts(c, {{0, 1}, 2});
  const scene::Mesh& mesh = cut.character->mesh;
  for (size_t part = 0; part < 2; ++part) {
    float low = 1;
    float high = 0;
    double area = 0;
    for (const uint32_t t : cut.triangles[part]) {
      std::array<glm::vec3, 3> p;
      for (uint32_t k = 0; k < 3; ++k) {
        const uint32_t v = mesh.indices[3 * t + k];
        p[k] = mesh.positions[v];
        low = std::min(low, p[k].y);
        high = std::max(high, p[k].y);
        EXPECT_NEAR(mesh.uvs[v].y, 10 * p[k].y, 1e-5) << "everything is interpolated";
        float upper = 0;
        for (int i = 0; i < 4; ++i) upper += mesh.joints[v][i] == 1 ? mesh.weights[v][i] : 0.0F;
        EXPECT_NEAR(upper, p[k].y, 1e-6);
      }
      const float twice = glm::cross(p[1] - p[0], p[2] - p[0]).z;
      EXPECT_GT(twice, 0) << "faces the same way";
      area += 0.5 * static_cast<double>(twice);
    }
    EXPECT_NEAR(low, part == 0 ? 0 : kBorderWeight, 1e-6);
    EXPECT_NEAR(high, part == 0 ? 1 - kBorderWeight : 1, 1e-6);
    EXPECT_NEAR(area, 1.4, 1e-5);
  }
  ASSERT_EQ(mesh.primitives.size(), 1U);
  EXPECT_EQ(mesh.primitives[0].vertex_count, mesh.positions.size());
  EXPECT_EQ(mesh.primitives[0].index_count, mesh.indices.size());
}

TEST(PolypostorParts, ManyThatShareATriangleLeaveItToOne) {
  scene::Character c = card(1, 1);
  for (int j = 1; j < 4; ++j) {
    c.skeleton.nodes.push_back(c.skeleton.nodes[0]);
    c.skeleton.nodes.back().parent = 0;
    c.skeleton.joints.push_back(c.skeleton.joints[0]);
    c.skeleton.joints.back().node = j;
  }
  for (size_t v = 0; v < 4; ++v) {
    c.mesh.joints[v] = {0, 1, 2, 3};
    c.mesh.weights[v] = {0.24F, 0.24F, 0.28F, 0.24F};
  }
  const CutCharacter cut = cut_at_parts(c, {{0, 1, 2, 3}, 4});
  for (const size_t part : {0U, 1U, 3U}) EXPECT_TRUE(cut.triangles[part].empty());
  EXPECT_EQ(cut.triangles[2].size(), 2U);
}

TEST(PolypostorParts, AreFoundInForeignSkeletons) {
  const fs::path folder = fs::path(CROWDBENCH_SHARED_DIR) / "characters";
  if (!fs::exists(folder)) GTEST_SKIP() << "needs " << folder;
  for (const char* file : {"CesiumMan", "KayKitKnight", "Mannequiny", "QuaterniusKnight", "RiggedFigure", "Robot"}) {
    const scene::Character c = scene::load_character((folder / (std::string(file) + ".glb")).string());
    const BodyParts parts = find_parts(c);
    EXPECT_GE(parts.fine.count, 8) << file;
    EXPECT_LE(parts.fine.count, 20) << file;
    EXPECT_LE(parts.coarse.count, parts.fine.count) << file;
    std::set<int> used(parts.fine.part_of.begin(), parts.fine.part_of.end());
    EXPECT_EQ(*used.rbegin(), parts.fine.count - 1) << file;
  }
}

TEST(PolypostorParts, CanBeCutByHand) {
  scene::Character c = testing::two_bones();
  const std::string upper = c.skeleton.joints[1].name;
  for (const std::string& cut : {upper, std::string("1")}) {
    const BodyParts parts = cut_parts(c, cut, "here");
    EXPECT_EQ(parts.fine.count, 2);
    EXPECT_NE(parts.fine.part_of[0], parts.fine.part_of[1]);
  }
  EXPECT_EQ(cut_parts(c, "0", "here").fine.count, 1);
  EXPECT_THROW((void)cut_parts(c, upper + "y", "here"), Error);
  EXPECT_THROW((void)cut_parts(c, "2", "here"), Error);
}

// ---- bake and picture
// -------------------------------------------------------------------------------------------------

const scene::Cast& walker() {
  static const scene::Cast cast = cast_of(scene::make_mannequin({.triangles = 500}));
  return cast;
}

PolypostorBakeOptions small_bake() {
  PolypostorBakeOptions options;
  options.grid = parse_view_grid("sphere-4x1", 0, "test");
  options.frames = 4;
  options.texels = 64;
  return options;
}

class PolypostorGl : public GlTest {};

TEST_F(PolypostorGl, BytesDoNotDependOnThreads) {
  PolypostorBakeOptions options = small_bake();
  std::vector<std::vector<uint8_t>> bytes;
  for (const unsigned threads : {1U, 3U}) {
    options.threads = threads;
    bytes.push_back(
        serialise(bake_polypostor(context(), walker().characters[0], walker().banks[0], options, uint64_t{64} << 20)));
  }
  EXPECT_EQ(bytes[0], bytes[1]);
}

TEST_F(PolypostorGl, BytesSurviveARoundTripAndDamageDoesNot) {
  PolypostorBakeOptions options = small_bake();
  options.key = KeyChoice::two_keys;
  const PolypostorBake bake =
      bake_polypostor(context(), walker().characters[0], walker().banks[0], options, uint64_t{64} << 20);
  EXPECT_EQ(bake.parts, 14);
  EXPECT_EQ(bake.ranges_by_frame, 1U);
  const auto bytes = serialise(bake);
  const auto back = deserialise_polypostor(bytes);
  ASSERT_TRUE(back);
  EXPECT_EQ(serialise(*back), bytes);
  for (size_t n = 0; n < bytes.size(); n += bytes.size() / 97 + 1)
    EXPECT_FALSE(deserialise_polypostor(std::span(bytes).first(n))) << n;
  const auto damaged = [&](const std::function<void(PolypostorBake&)>& harm) {
    PolypostorBake b = bake;
    harm(b);
    return !deserialise_polypostor(serialise(b)).has_value();
  };
  EXPECT_TRUE(damaged([](PolypostorBake& b) { b.indices[5] = 60000; })) << "a corner that is not there";
  EXPECT_TRUE(damaged([](PolypostorBake& b) { b.ranges[0].indices += 1U << 30U; }));
  EXPECT_TRUE(damaged([](PolypostorBake& b) { b.sets.back().first_word += 1; })) << "a block past the end";
  EXPECT_TRUE(damaged([](PolypostorBake& b) { b.vertices[0].turn = 65535; }));
  EXPECT_TRUE(damaged([](PolypostorBake& b) { b.clips[0].frames = 400; }));
  EXPECT_TRUE(damaged([](PolypostorBake& b) { b.width *= 2; }));
  EXPECT_TRUE(bake.emission.empty());
  EXPECT_TRUE(damaged([](PolypostorBake& b) { b.emission_peak = 1.0F; })) << "a map that is not there";
  EXPECT_FALSE(damaged([](PolypostorBake& b) {
    b.emission_peak = 1.0F;
    b.emission = b.albedo;
  }));
}

// One agent at the origin, 120 pixels tall in 200 rows, level, from an azimuth.
scene::Frame frame_from(const scene::Cast& cast, double azimuth, double phase) {
  scene::Frame frame = frame_of_one(5, 1, 200, 200, 15);
  const double distance = 1.75 * 200 / 120 / (2 * std::tan(frame.camera.fov_y / 2));
  const glm::dvec3 middle = 0.5 * (glm::dvec3(cast.banks[0]->bounds_min()) + glm::dvec3(cast.banks[0]->bounds_max()));
  frame.camera.target = middle;
  frame.camera.eye = middle + distance * glm::dvec3(std::sin(azimuth), 0, std::cos(azimuth));
  frame.origin = frame.camera.eye;
  add_agent(frame, cast, {0, 0, 0}, 1, phase);
  return frame;
}

double iou(const Capture& a, const Capture& b) {
  int both = 0;
  int either = 0;
  for (size_t i = 0; i < a.ids.data.size(); ++i) {
    both += a.ids.data[i] != 0 && b.ids.data[i] != 0;
    either += a.ids.data[i] != 0 || b.ids.data[i] != 0;
  }
  return either == 0 ? 0 : static_cast<double>(both) / either;
}

std::unique_ptr<Representation> make(const scene::Cast& cast, const std::string& spec, bool use_cache = false) {
  MakeContext make{.context = context(), .cast = cast};
  make.use_cache = use_cache;
  make.progress = false;
  return make_representation(make, parse_spec(spec));
}

// Mean absolute difference of the colours where either shows somebody.
double colour_error(const Capture& a, const Capture& b) {
  double sum = 0;
  double count = 0;
  for (size_t i = 0; i < a.ids.data.size(); ++i) {
    if (a.ids.data[i] == 0 && b.ids.data[i] == 0) continue;
    for (size_t c = 0; c < 3; ++c) sum += std::abs(int{a.colour.data[4 * i + c]} - int{b.colour.data[4 * i + c]});
    count += 3;
  }
  return count == 0 ? 0 : sum / count;
}

TEST_F(PolypostorGl, LooksAsTheMeshInStoredFramesAndBetween) {
  const std::string common = ":views=sphere-4x1,frames=10";
  const auto polypostor = make(walker(), "polypostor" + common);
  const auto first = make(walker(), "polypostor" + common + ",key=first");
  const auto two = make(walker(), "polypostor" + common + ",key=two_keys");
  const auto flat = make(walker(), "flat" + common);
  const auto mesh = make(walker(), "mesh");
  Renderer renderer(context(), walker());
  struct Score {
    double overlap = 0, colour = 0;
    void add(const Capture& test, const Capture& reference) {
      overlap += iou(test, reference) / 40;
      colour += colour_error(test, reference) / 40;
    }
  };
  Score visible;
  Score of_first;
  Score of_two;
  double between = 0;
  double jumps = 0;
  for (int f = 0; f < 10; ++f)
    for (int a = 0; a < 4; ++a) {
      scene::Frame frame = frame_from(walker(), a * std::numbers::pi / 2, f / 10.0);
      const Capture stored = renderer.capture(frame, *mesh);
      const Capture shown = renderer.capture(frame, *polypostor);
      EXPECT_GE(iou(shown, stored), 0.85) << "frame " << f << ", view " << a;
      visible.add(shown, stored);
      of_first.add(renderer.capture(frame, *first), stored);
      of_two.add(renderer.capture(frame, *two), stored);
      frame = frame_from(walker(), a * std::numbers::pi / 2, (f + 0.5) / 10);
      const Capture reference = renderer.capture(frame, *mesh);
      between += iou(renderer.capture(frame, *polypostor), reference) / 40;
      jumps += iou(renderer.capture(frame, *flat), reference) / 40;
    }
  EXPECT_GE(visible.overlap, 0.95);
  EXPECT_GE(between, jumps + 0.05) << "half-way, moving corners beat showing a stored frame";
  // The key that looks best in all frames is worth its search, and two are better than one.
  EXPECT_GE(visible.overlap, of_first.overlap);
  EXPECT_LE(visible.colour, of_first.colour);
  EXPECT_GE(of_two.overlap, visible.overlap);
  EXPECT_LE(of_two.colour, visible.colour);
  RecordProperty("iou", std::to_string(visible.overlap) + " " + std::to_string(of_first.overlap) + " " +
                            std::to_string(of_two.overlap));
  RecordProperty("colour", std::to_string(visible.colour) + " " + std::to_string(of_first.colour) + " " +
                               std::to_string(of_two.colour));
}

TEST_F(PolypostorGl, ACardThatTurnsIsItsOwnPicture) {
  // A card of one joint that turns in its own plane, seen from the front.
  scene::Character c = card(0.8F, 0.8F, {0.9F, 0.4F, 0.2F, 1.0F});
  for (glm::vec3& p : c.mesh.positions) p.y -= 0.4F;
  scene::Clip clip;
  clip.name = "turn";
  clip.end = 1;
  scene::Channel turn;
  turn.target = scene::Target::rotation;
  for (int k = 0; k <= 8; ++k) {
    const double half = std::numbers::pi * k / 8;
    turn.times.push_back(k / 8.0);
    for (const double v : {0.0, 0.0, std::sin(half), std::cos(half)}) turn.values.push_back(v);
  }
  clip.channels = {turn};
  c.clips = {clip};
  scene::normalise(c, {.height = std::nullopt});
  const scene::Cast cast = cast_of(std::move(c));
  const auto polypostor = make(cast, "polypostor:views=sphere-4x1,frames=8,texels=256");
  const auto mesh = make(cast, "mesh");
  Renderer renderer(context(), cast);
  for (int f = 0; f < 8; ++f) {
    scene::Frame frame = frame_of_one(12, 0, 160, 160, 6);
    frame.camera.target = {0, 0, 0};
    frame.origin = frame.camera.eye;
    add_agent(frame, cast, {0, 0, 0}, 1, f / 8.0);
    const Capture test = renderer.capture(frame, *polypostor);
    const Capture reference = renderer.capture(frame, *mesh);
    EXPECT_GE(iou(test, reference), 0.975) << f;
    // Lit alike: the normal turns with the card.
    EXPECT_NEAR(test.colour.at(80, 80)[0], reference.colour.at(80, 80)[0], 3) << f;
  }
}

TEST_F(PolypostorGl, ADamagedCacheIsBakedAnew) {
  const support::ScratchFolder folder;
  setenv("CROWDBENCH_CACHE_DIR", folder.path().c_str(), 1);
  const std::string spec = "polypostor:views=sphere-4x1,frames=2,texels=32";
  const auto picture = [&](bool cached) {
    const auto one = make(walker(), spec, true);
    EXPECT_EQ(one->bake_info().cached, cached);
    EXPECT_GT(one->footprint().disk_bytes, 0U);
    return Renderer(context(), walker()).capture(frame_from(walker(), 0, 0.3), *one);
  };
  const Capture fresh = picture(false);
  EXPECT_EQ(picture(true), fresh) << "what was stored draws the same";
  size_t entries = 0;
  for (const auto& entry : fs::recursive_directory_iterator(folder.path())) {
    if (entry.path().extension() != ".bake") continue;
    ++entries;
    std::fstream file(entry.path(), std::ios::in | std::ios::out | std::ios::binary);
    file.seekp(static_cast<std::streamoff>(fs::file_size(entry.path()) / 2));
    file.put('\x5a');
    file.put('\xa5');
  }
  EXPECT_EQ(entries, 1U);
  EXPECT_EQ(picture(false), fresh) << "damage is seen, and baked over";
  EXPECT_EQ(picture(true), fresh);
  unsetenv("CROWDBENCH_CACHE_DIR");
}

TEST_F(PolypostorGl, DebugPicturesDiffer) {
  Renderer renderer(context(), walker());
  const scene::Frame frame = frame_from(walker(), 0, 0.3);
  std::vector<Capture> pictures;
  for (const char* debug : {"none", "wire", "lines", "parts", "stretch"}) {
    const auto one = make(walker(), std::string("polypostor:views=sphere-4x1,frames=4,texels=64,debug=") + debug);
    const Capture picture = renderer.capture(frame, *one);
    for (const Capture& before : pictures) EXPECT_NE(before.colour, picture.colour) << debug;
    pictures.push_back(picture);
  }
  EXPECT_EQ(pictures[3].ids, pictures[0].ids) << "paint does not change what is covered";
  std::set<std::array<bool, 3>> hues;
  for (size_t i = 0; i < pictures[3].ids.data.size(); ++i)
    if (pictures[3].ids.data[i] != 0) {
      const uint8_t* c = &pictures[3].colour.data[4 * i];
      hues.insert({c[0] > 150, c[1] > 150, c[2] > 150});
    }
  EXPECT_GE(hues.size(), 4U) << "parts are told apart by colour";
}

TEST_F(PolypostorGl, RefusesWhatItCannotHold) {
  MakeContext small{.context = context(), .cast = walker(), .bake_budget = 10'000};
  small.use_cache = false;
  small.progress = false;
  EXPECT_THROW((void)make_representation(small, parse_spec("polypostor:views=sphere-4x1,frames=2,texels=64")), Error);
  EXPECT_THROW((void)make(walker(), "polypostor:parts=nobody"), Error);
}

}  // namespace
}  // namespace crowdbench::renderers
