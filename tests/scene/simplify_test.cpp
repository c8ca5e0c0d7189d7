#include "scene/character/simplify.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <map>
#include <set>

#include "scene/character/flat_normals.h"
#include "scene/character/surface_distance.h"
#include "scene/character/surface_gauge.h"
#include "scene/character/weld.h"
#include "scene/mannequin/mannequin.h"

namespace crowdbench::scene {
namespace {

using Poses = std::vector<std::vector<glm::vec3>>;

Poses bind_pose(const Character& character) { return {character.mesh.positions}; }

// A grid of side x side squares, one unit wide, bent by `shape`; two charts that meet at the middle column where
// `seam` asks for it.
struct Sheet {
  Character character;
  template <typename Shape>
  Sheet(int side, bool seam, const Shape& shape) {
    Mesh& mesh = character.mesh;
    character.materials.resize(1);
    character.materials[0].base_colour_image = 0;
    const auto add_part = [&](int from, int to, float u_offset) {
      const auto first = static_cast<uint32_t>(mesh.positions.size());
      const auto columns = static_cast<uint32_t>(to - from + 1);
      for (int y = 0; y <= side; ++y)
        for (int x = from; x <= to; ++x) {
          const glm::vec2 at = glm::vec2(x, y) / static_cast<float>(side);
          mesh.positions.push_back(shape(at));
          mesh.normals.emplace_back(0.0F, 0.0F, 1.0F);
          mesh.uvs.push_back(at + glm::vec2(u_offset, 0));
        }
      for (uint32_t y = 0; y < static_cast<uint32_t>(side); ++y)
        for (uint32_t x = 0; x + 1 < columns; ++x) {
          const uint32_t a = first + y * columns + x;
          mesh.indices.insert(mesh.indices.end(), {a, a + 1, a + columns, a + 1, a + columns + 1, a + columns});
        }
    };
    if (seam) {
      add_part(0, side / 2, 0);
      add_part(side / 2, side, 3);
    } else {
      add_part(0, side, 0);
    }
    mesh.joints.resize(mesh.positions.size());
    mesh.weights.assign(mesh.positions.size(), glm::vec4(1, 0, 0, 0));
    Primitive primitive;
    primitive.index_count = static_cast<uint32_t>(mesh.indices.size());
    primitive.vertex_count = static_cast<uint32_t>(mesh.positions.size());
    mesh.primitives = {primitive};
  }
};
glm::vec3 flat(glm::vec2 at) { return {at, 0}; }

double area(const Mesh& mesh) {
  double sum = 0;
  for (size_t i = 0; i < mesh.indices.size(); i += 3) {
    const glm::dvec3 a = mesh.positions[mesh.indices[i]];
    const glm::dvec3 b = mesh.positions[mesh.indices[i + 1]];
    const glm::dvec3 c = mesh.positions[mesh.indices[i + 2]];
    sum += glm::length(glm::cross(b - a, c - a)) / 2;
  }
  return sum;
}

// Length of the edges that one triangle alone has, vertices of one place taken as one.
double open_length(const Mesh& mesh) {
  const std::vector<uint32_t> point = weld(Poses{mesh.positions}, 1e-6F);
  std::map<std::pair<uint32_t, uint32_t>, int> edges;
  for (size_t i = 0; i < mesh.indices.size(); i += 3)
    for (size_t k = 0; k < 3; ++k) {
      const uint32_t a = point[mesh.indices[i + k]];
      const uint32_t b = point[mesh.indices[i + (k + 1) % 3]];
      ++edges[{std::min(a, b), std::max(a, b)}];
    }
  double sum = 0;
  for (const auto& [edge, count] : edges)
    if (count == 1) sum += static_cast<double>(glm::length(mesh.positions[edge.first] - mesh.positions[edge.second]));
  return sum;
}

std::set<int> materials_of(const Mesh& mesh) {
  std::set<int> out;
  for (const Primitive& p : mesh.primitives)
    if (p.index_count > 0) out.insert(p.material);
  return out;
}

TEST(Simplify, AFlatSheetIsTwoTriangles) {
  const Sheet sheet(8, false, flat);
  const SimplifiedMesh out = simplify(sheet.character, bind_pose(sheet.character), 2);
  EXPECT_EQ(out.mesh.indices.size(), 6U);
  EXPECT_TRUE(out.why_more.empty());
  EXPECT_NEAR(area(out.mesh), 1.0, 1e-6) << "its four corners are left";
}

TEST(Simplify, ATextureSeamStaysOnItsLineAndClosed) {
  const Sheet sheet(8, true, flat);
  const SimplifiedMesh out = simplify(sheet.character, bind_pose(sheet.character), 4);
  EXPECT_EQ(out.mesh.indices.size(), 12U);
  EXPECT_NEAR(area(out.mesh), 1.0, 1e-6);
  EXPECT_NEAR(open_length(out.mesh), 4.0, 1e-6) << "open around the sheet, and not along the seam";
  for (size_t i = 0; i < out.mesh.indices.size(); i += 3) {
    const float u = out.mesh.uvs[out.mesh.indices[i]].x;
    for (size_t k = 1; k < 3; ++k)
      EXPECT_LT(std::abs(out.mesh.uvs[out.mesh.indices[i + k]].x - u), 1.01F)
          << "no triangle has corners of two charts";
  }
}

TEST(Simplify, TwoMaterialsMeetWhereTheyMet) {
  Sheet sheet(8, true, flat);
  Mesh& mesh = sheet.character.mesh;
  sheet.character.materials.resize(2);
  Primitive right = mesh.primitives[0];
  mesh.primitives[0].index_count /= 2;
  mesh.primitives[0].vertex_count /= 2;
  right.first_index = right.index_count = mesh.primitives[0].index_count;
  right.first_vertex = right.vertex_count = mesh.primitives[0].vertex_count;
  right.material = 1;
  mesh.primitives.push_back(right);
  for (const size_t budget : {4U, 1U, 0U}) {
    const SimplifiedMesh out = simplify(sheet.character, bind_pose(sheet.character), budget);
    EXPECT_EQ(materials_of(out.mesh), (std::set<int>{0, 1})) << budget;
    EXPECT_EQ(out.why_more.empty(), out.mesh.indices.size() <= 3 * budget) << budget;
    for (const Primitive& p : out.mesh.primitives)
      for (uint32_t i = p.first_index; i < p.first_index + p.index_count; ++i)
        EXPECT_EQ(out.mesh.indices[i] / p.vertex_count, p.first_vertex / p.vertex_count) << "vertices of its own";
  }
  EXPECT_NEAR(open_length(simplify(sheet.character, bind_pose(sheet.character), 4).mesh), 4.0, 1e-6);
}

// Flat as it is bound, a roof in a clip: the ridge goes where only the bind pose is looked at.
TEST(Simplify, GoesByThePosesAndNotByTheBindPose) {
  const Sheet sheet(8, false, flat);
  const Sheet roof(8, false, [](glm::vec2 at) { return glm::vec3(at, 0.5F - std::abs(at.x - 0.5F)); });
  const Poses both = {sheet.character.mesh.positions, roof.character.mesh.positions};
  const auto error_of = [&](const SimplifiedMesh& out) {
    const auto& p = roof.character.mesh.positions;
    return surface_distance({p, sheet.character.mesh.indices}, {p, out.mesh.indices}, {.by_area = 500}).max;
  };
  EXPECT_GT(error_of(simplify(sheet.character, bind_pose(sheet.character), 4)), 0.2);
  EXPECT_LT(error_of(simplify(sheet.character, both, 4)), 1e-5);
}

TEST(Simplify, KeepsTheBodyWithATenthOfItsTriangles) {
  const Character full = make_mannequin();
  const Mesh draft = simplify(full, bind_pose(full), 500).mesh;
  EXPECT_LE(draft.indices.size() / 3, 500U);
  EXPECT_GE(draft.indices.size() / 3, 490U);
  EXPECT_NEAR(area(draft) / area(full.mesh), 1.0, 0.10);
  EXPECT_LE(open_length(draft), open_length(full.mesh) + 1e-6) << "no cracks";
  ASSERT_EQ(draft.primitives.size(), full.mesh.primitives.size());
  uint32_t next = 0;
  for (const Primitive& primitive : draft.primitives) {
    EXPECT_EQ(primitive.first_index, next);
    EXPECT_GT(primitive.index_count, 0U);
    EXPECT_EQ(primitive.index_count % 3, 0U);
    next += primitive.index_count;
  }
  EXPECT_EQ(next, draft.indices.size());
  EXPECT_EQ(draft.positions, full.mesh.positions);
  EXPECT_EQ(draft.weights, full.mesh.weights) << "no vertex gets new weights";
  EXPECT_EQ(simplify(full, bind_pose(full), 500).mesh.indices, draft.indices) << "the same every time";
}

TEST(Simplification, HasWhatSimplifyMakesOfEveryNumber) {
  const Character full = make_mannequin({.triangles = 500});
  const Poses poses = bind_pose(full);
  const Simplification all(full, poses, 4);
  for (const size_t triangles : {1000U, 499U, 300U, 120U, 40U, 4U}) {
    const SimplifiedMesh alone = simplify(full, poses, triangles);
    const SimplifiedMesh moment = all.at(triangles);
    EXPECT_EQ(moment.mesh.indices, alone.mesh.indices) << triangles;
    EXPECT_EQ(moment.why_more, alone.why_more) << triangles;
    ASSERT_EQ(moment.mesh.primitives.size(), alone.mesh.primitives.size());
    for (size_t p = 0; p < alone.mesh.primitives.size(); ++p)
      EXPECT_EQ(moment.mesh.primitives[p].index_count, alone.mesh.primitives[p].index_count) << triangles;
  }
}

TEST(Simplify, LeavesAloneWhatIsSmallEnough) {
  const Character small = make_mannequin({.triangles = 500});
  EXPECT_EQ(simplify(small, bind_pose(small), 5000).mesh.indices, small.mesh.indices);
}

TEST(Simplify, TakesACharacterWithoutTriangles) {
  Character empty;
  EXPECT_TRUE(simplify(empty, Poses(1), 500).mesh.indices.empty());
  EXPECT_TRUE(simplify(empty, Poses(1), 0).mesh.indices.empty());
}

TEST(Weld, TakesTogetherWhatIsNearInEveryPose) {
  const Poses one = {{{0, 0, 0}, {1, 0, 0}, {0, 0, 1e-7F}, {-1e-7F, 0, 0}, {1, 0, 0.1F}}};
  EXPECT_EQ(weld(one, 1e-6F), (std::vector<uint32_t>{0, 1, 0, 0, 4}));
  Poses two = one;
  two.push_back({{0, 0, 0}, {1, 0, 0}, {0, 0.5F, 0}, {0, 0, 0}, {1, 0, 0}});
  EXPECT_EQ(weld(two, 1e-6F), (std::vector<uint32_t>{0, 1, 2, 0, 4})) << "the third goes its own way";
  EXPECT_EQ(weld(one, 0), (std::vector<uint32_t>{0, 1, 2, 3, 4})) << "cells of no size, farther than integers count";
}

TEST(SurfaceDistance, IsThatOfParallelSquaresAndOfASpike) {
  const std::vector<glm::vec3> low = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
  std::vector<glm::vec3> high = low;
  for (glm::vec3& p : high) p.z = 0.25F;
  const std::vector<uint32_t> square = {0, 1, 2, 0, 2, 3};
  const SurfaceDistance apart = surface_distance({low, square}, {high, square}, {.by_area = 100});
  EXPECT_NEAR(apart.max, 0.25, 1e-6);
  EXPECT_NEAR(apart.rms, 0.25, 1e-6);
  EXPECT_LT(surface_distance({low, square}, {low, square}, {.by_area = 100}).max, 1e-6)
      << "rounding of the samples' places";
  EXPECT_EQ(surface_distance({low, square}, {low, {}}, {.by_area = 100}).max, 0) << "nothing to be away from";
  // A square with a spike of height 2 in its middle, against the square: from one side alone it would be 0.
  const std::vector<glm::vec3> spike = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0.5F, 0.5F, 2}};
  const std::vector<uint32_t> tent = {0, 1, 4, 1, 2, 4, 2, 3, 4, 3, 0, 4};
  EXPECT_NEAR(surface_distance({spike, tent}, {low, square}, {.by_area = 100}).max, 2, 1e-6);
  EXPECT_NEAR(surface_distance({low, square}, {spike, tent}, {.by_area = 100}).max, 2, 1e-6);
}

// The distance, either way, and a hair less.
TEST(SurfaceGauge, SaysWhatTheMeasuredDistanceSays) {
  const Character body = make_mannequin({.triangles = 500});
  const Mesh coarse = simplify(body, bind_pose(body), 200).mesh;
  const Surface whole{body.mesh.positions, body.mesh.indices};
  const Surface level{coarse.positions, coarse.indices};
  for (const auto& [a, b] : {std::pair(whole, level), std::pair(level, whole)}) {
    const SurfacePlaces places{.by_area = 300, .most_corners = 100, .turn = 1};
    const double far = surface_distance(a, b, places).max;
    ASSERT_GT(far, 0.01);
    SurfaceGauge gauge(a, places);
    EXPECT_TRUE(gauge.is_within(b, far));
    EXPECT_FALSE(gauge.is_within(b, far * (1 - 1e-6)));
    EXPECT_FALSE(gauge.is_within(b, far / 2)) << "the place that was too far is known";
    EXPECT_TRUE(gauge.is_within(b, far));
    EXPECT_TRUE(gauge.is_within(a, 1e-5));
  }
  SurfaceGauge nothing(Surface{body.mesh.positions, {}});
  EXPECT_TRUE(nothing.is_within(whole, 0)) << "as the distance to it is 0";
}

// 100 corners in a row, the 38th of them raised: of every third corner only one turn in three meets it.
TEST(SurfaceDistance, LooksAtEveryCornerInOneOfTheTurns) {
  std::vector<glm::vec3> row;
  std::vector<uint32_t> indices;
  for (uint32_t i = 0; i < 50; ++i) {
    row.emplace_back(i, 0, 0);
    row.emplace_back(i, 1, 0);
    if (i > 0) indices.insert(indices.end(), {2 * i - 2, 2 * i, 2 * i - 1, 2 * i, 2 * i + 1, 2 * i - 1});
  }
  std::vector<glm::vec3> raised = row;
  raised[37].z = 1;
  size_t met = 0;
  for (size_t turn = 0; turn < 3; ++turn) {
    const SurfaceDistance found =
        surface_distance({raised, indices}, {row, indices}, {.by_area = 0, .most_corners = 34, .turn = turn});
    EXPECT_LE(found.places, 2U * 34U);
    EXPECT_EQ(found.rms, 0) << "of places by area alone";
    if (found.max > 0.9) ++met;
  }
  EXPECT_EQ(met, 1U);
  EXPECT_EQ(surface_distance({raised, indices}, {row, indices}, {.by_area = 7}).places, 2U * (7U + 100U));
}

// ---- normals of faces

Mesh folded(const glm::vec3& last) {
  Mesh mesh;
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, last};
  mesh.uvs = {{0, 0}, {1, 0}, {0, 1}, {1, 1}};
  mesh.joints.resize(4);
  mesh.weights.resize(4, glm::vec4(1, 0, 0, 0));
  mesh.indices = {0, 1, 2, 0, 2, 3};
  return mesh;
}

TEST(FlatNormals, VerticesOfAFoldAreDoubled) {
  // The first face looks along +z; the second, whose third corner stands up, along +x.
  Mesh mesh = folded({0, 0, 1});
  ASSERT_TRUE(add_flat_normals(mesh, Primitive{}, 6));
  EXPECT_EQ(mesh.indices, (std::vector<uint32_t>{0, 1, 2, 4, 5, 3}));
  ASSERT_EQ(mesh.positions.size(), 6U);
  EXPECT_EQ(mesh.positions[4], mesh.positions[0]);
  EXPECT_EQ(mesh.positions[5], mesh.positions[2]);
  EXPECT_EQ(mesh.uvs[5], glm::vec2(0, 1));
  for (const size_t v : {0U, 1U, 2U}) EXPECT_EQ(mesh.normals[v], glm::vec3(0, 0, 1)) << v;
  for (const size_t v : {3U, 4U, 5U}) EXPECT_EQ(mesh.normals[v], glm::vec3(1, 0, 0)) << v;
  Mesh small = folded({0, 0, 1});
  EXPECT_FALSE(add_flat_normals(small, Primitive{}, 5)) << "two more than four";
}

TEST(FlatNormals, FacesOfOnePlaneShareTheirVertices) {
  Mesh mesh = folded({-1, 0, 0});
  ASSERT_TRUE(add_flat_normals(mesh, Primitive{}, 4));
  EXPECT_EQ(mesh.positions.size(), 4U);
  EXPECT_EQ(mesh.indices, folded({}).indices);
  for (const glm::vec3& normal : mesh.normals) EXPECT_EQ(normal, glm::vec3(0, 0, 1));
}

TEST(FlatNormals, WhatHasNoFaceLooksUpAndWhatIsBeforeStays) {
  Mesh mesh = folded({0, 0, 1});
  mesh.normals = {{0, -1, 0}, {0, -1, 0}};
  mesh.indices = {3, 3, 3};  // without area
  Primitive last;
  last.first_vertex = 2;
  ASSERT_TRUE(add_flat_normals(mesh, last, 4));
  const std::vector<glm::vec3> wanted = {{0, -1, 0}, {0, -1, 0}, {0, 1, 0}, {0, 1, 0}};
  EXPECT_EQ(mesh.normals, wanted);
}

}  // namespace
}  // namespace crowdbench::scene
