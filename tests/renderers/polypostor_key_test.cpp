#include "renderers/polypostor/polypostor_key.h"

#include <gtest/gtest.h>

#include <numbers>

#include "tests/renderers/gl_test_support.h"
#include "tests/renderers/polygons.h"

namespace crowdbench::renderers {
namespace {

using testing::card;
using testing::turned;

// A square of 8 x 8 texels around the origin, turned in the plane; half of it leans towards +x.
struct LookedAt {
  std::vector<glm::dvec3> positions;
  std::vector<glm::vec3> normals;
};
LookedAt square_turned(double angle, const glm::vec3& normal) {
  LookedAt out;
  for (const glm::dvec2& p : turned(Polyline{{-4, -4}, {4, -4}, {4, 4}, {-4, 4}}, angle))
    out.positions.emplace_back(p, 0.0);
  const glm::dvec2 n = turned(glm::dvec2(normal), angle);
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

}  // namespace
}  // namespace crowdbench::renderers
