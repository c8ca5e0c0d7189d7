// Triangles as the mesh draws them.
#include "truth/posed_agent.h"

#include <gtest/gtest.h>

#include "scene/mannequin/mannequin.h"

namespace crowdbench::truth {
namespace {

TEST(PosedAgent, MirroredPrimitivesAreTurnedRound) {
  scene::Character character = scene::make_mannequin({});
  const std::vector<uint32_t> usual = drawn_indices(character.mesh);
  ASSERT_EQ(usual, character.mesh.indices);
  for (scene::Primitive& primitive : character.mesh.primitives) primitive.mirrored = true;
  const std::vector<uint32_t> turned = drawn_indices(character.mesh);
  ASSERT_EQ(turned.size(), usual.size());
  // One corner stays, the other two are exchanged: the sense in which they run is the other one.
  for (size_t i = 0; i < usual.size(); i += 3) {
    int moved = 0;
    for (size_t k = 0; k < 3; ++k) moved += turned[i + k] != usual[i + k] ? 1 : 0;
    ASSERT_EQ(moved, 2) << i;
  }
}

}  // namespace
}  // namespace crowdbench::truth
