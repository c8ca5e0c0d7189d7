#include "scene/character/simplify.h"

#include <gtest/gtest.h>

#include "scene/mannequin/mannequin.h"

namespace crowdbench::scene {
namespace {

double half_area(const Character& c) {  // of both sides, so about twice the outline for a closed body
  double sum = 0;
  for (size_t i = 0; i < c.mesh.indices.size(); i += 3) {
    const glm::dvec3 a = c.mesh.positions[c.mesh.indices[i]];
    const glm::dvec3 b = c.mesh.positions[c.mesh.indices[i + 1]];
    const glm::dvec3 d = c.mesh.positions[c.mesh.indices[i + 2]];
    sum += glm::length(glm::cross(b - a, d - a)) / 2;
  }
  return sum;
}

TEST(Simplify, KeepsTheBodyWithATenthOfItsTriangles) {
  const Character full = make_mannequin();
  const Character draft = simplified(full, 500);
  EXPECT_GT(draft.triangles(), 250U);
  EXPECT_LT(draft.triangles(), 800U);
  EXPECT_NEAR(half_area(draft) / half_area(full), 1.0, 0.15);
  ASSERT_EQ(draft.mesh.primitives.size(), full.mesh.primitives.size());
  uint32_t next = 0;
  for (const Primitive& primitive : draft.mesh.primitives) {
    EXPECT_EQ(primitive.first_index, next);
    EXPECT_GT(primitive.index_count, 0U);
    EXPECT_EQ(primitive.index_count % 3, 0U);
    next += primitive.index_count;
  }
  EXPECT_EQ(next, draft.mesh.indices.size());
  for (const uint32_t index : draft.mesh.indices) ASSERT_LT(index, full.mesh.positions.size());
  EXPECT_EQ(draft.mesh.positions, full.mesh.positions);
  EXPECT_EQ(draft.skeleton.joints.size(), full.skeleton.joints.size());
}

TEST(Simplify, LeavesAloneWhatIsSmallEnough) {
  MannequinOptions options;
  options.triangles = 500;
  const Character small = make_mannequin(options);
  EXPECT_EQ(simplified(small, 5000).mesh.indices, small.mesh.indices);
}

TEST(Simplify, TakesACharacterWithoutTriangles) {
  Character empty;
  EXPECT_EQ(simplified(empty, 500).triangles(), 0U);
}

}  // namespace
}  // namespace crowdbench::scene
