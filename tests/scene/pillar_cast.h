// A cast that needs no loader: one box of 0.5 x 1.75 x 0.3 m on one joint, with a clip that walks and one that stands.
#pragma once
#include <memory>

#include "scene/crowd/crowd.h"

namespace crowdbench::scene {

inline Cast pillar_cast(double ground_speed = 1.4, int kinds = 1) {
  Cast cast;
  for (int kind = 0; kind < kinds; ++kind) {
    Character pillar;
    pillar.name = "pillar";
    pillar.skeleton.nodes.resize(1);
    pillar.skeleton.joints.resize(1);
    for (int corner = 0; corner < 8; ++corner) {
      pillar.mesh.positions.push_back(
          {corner & 1 ? 0.25F : -0.25F, corner & 2 ? 1.75F : 0.0F, corner & 4 ? 0.15F : -0.15F});
      pillar.mesh.normals.push_back({0.0F, 1.0F, 0.0F});
      pillar.mesh.joints.push_back({0, 0, 0, 0});
      pillar.mesh.weights.push_back({1.0F, 0.0F, 0.0F, 0.0F});
    }
    const auto still = [](const char* name, double seconds) {
      Clip clip;
      clip.name = name;
      clip.end = seconds;
      clip.channels.push_back({0, Target::translation, Interpolation::linear, {0.0, seconds}, {0, 0, 0, 0, 0, 0}});
      return clip;
    };
    pillar.clips = {still("walk", 1.0), still("idle", 2.0)};
    pillar.motion.resize(2);
    pillar.motion[0].ground_speed = ground_speed * (1 + kind);
    pillar.placement.height = 1.75;
    pillar.placement.default_clip = 0;
    auto shared = std::make_shared<const Character>(pillar);
    cast.banks.push_back(std::make_shared<const PoseBank>(*shared, std::vector<int>{0, 1}, 30.0));
    cast.characters.push_back(shared);
    cast.shares.push_back(1.0 / kinds);
  }
  return cast;
}

}  // namespace crowdbench::scene
