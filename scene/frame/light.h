// Light: one direction and an ambient term, fixed to the scene.
#pragma once
#include <glm/glm.hpp>

namespace crowdbench::scene {

// linear = albedo * (ambient + diffuse * max(0, N.L)) + emissive, in linear light.
struct Light {
  glm::vec3 direction{0.40814F, 0.81628F,
                      0.45916F};  // towards the light; the user normalises it: (.4, .8, .45) of length 1.02
  float ambient = 0.25F;
  float diffuse = 0.75F;
  bool operator==(const Light&) const = default;
};

}  // namespace crowdbench::scene
