// Masked figures: the holes of the mesh are holes in everything that is baked from it.
#include <gtest/gtest.h>

#include "gl_test_support.h"

namespace crowdbench::renderers {
namespace {

using testing::add_agent;
using testing::card;
using testing::cast_of;
using testing::context;
using testing::frame_of_one;
using testing::GlTest;
using testing::make;

// A card of 1 m x 1.6 m with 3 x 4 round holes, seen from both sides.
scene::Character card_with_holes(float cutoff) {
  scene::Character character = card(1.0F, 1.6F, glm::vec4(0.8F, 0.5F, 0.3F, 1.0F));
  scene::Texture holes;
  holes.image = Image8(96, 128, 4);
  for (int y = 0; y < 128; ++y)
    for (int x = 0; x < 96; ++x) {
      const double dx = x % 32 - 15.5;
      const double dy = y % 32 - 15.5;
      uint8_t* texel = holes.image.at(x, y);
      texel[0] = texel[1] = texel[2] = 255;
      texel[3] = dx * dx + dy * dy < 100 ? 0 : 255;
    }
  character.images.push_back(holes);
  scene::Material& material = character.materials.front();
  material.base_colour_image = 0;
  material.alpha_cutoff = cutoff;
  material.double_sided = true;
  character.mesh.uvs.clear();
  for (const glm::vec3& p : character.mesh.positions) character.mesh.uvs.emplace_back(p.x + 0.5F, 1.0F - p.y / 1.6F);
  return character;
}

Capture draw(const scene::Cast& cast, const std::string& spec) {
  scene::Frame frame = frame_of_one(4.0, 0.8, 240, 240, 28.0);
  add_agent(frame, cast, {0, 0, 0}, 7);
  Renderer renderer(context(), cast);
  const auto representation = make(cast, spec);
  return renderer.capture(frame, *representation, {});
}

double overlap(const Capture& a, const Capture& b) {
  size_t both = 0;
  size_t any = 0;
  for (size_t i = 0; i < a.ids.data.size(); ++i) {
    both += a.ids.data[i] != 0 && b.ids.data[i] != 0 ? 1 : 0;
    any += a.ids.data[i] != 0 || b.ids.data[i] != 0 ? 1 : 0;
  }
  return double(both) / double(any);
}

struct Masked {
  const char* spec;
  double iou;  // with the mesh
};

class MaskGl : public GlTest, public ::testing::WithParamInterface<Masked> {};

// A third of the card is holes: a bake without them overlaps by two thirds.
TEST_P(MaskGl, SilhouetteHasTheHoles) {
  const scene::Cast cast = cast_of(card_with_holes(0.5F));
  const Capture mesh = draw(cast, "mesh");
  EXPECT_LT(overlap(mesh, draw(cast_of(card_with_holes(0.0F)), "mesh")), 0.72);
  EXPECT_GT(overlap(mesh, draw(cast, GetParam().spec)), GetParam().iou);
}

INSTANTIATE_TEST_SUITE_P(Bakes, MaskGl,
                         ::testing::Values(Masked{"rigid", 0.999}, Masked{"flat", 0.97}, Masked{"polypostor", 0.97},
                                           Masked{"relief", 0.97}),
                         [](const auto& test) { return std::string(test.param.spec); });

}  // namespace
}  // namespace crowdbench::renderers
