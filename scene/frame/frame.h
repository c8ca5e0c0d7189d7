// Frame: all that a renderer is given of one tick.
#pragma once
#include <array>
#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

#include "scene/frame/camera.h"
#include "scene/frame/light.h"
#include "scene/pose/pose_bank.h"

namespace crowdbench::scene {

// One agent, ready to draw. Positions are relative to the eye and in float: doubles never reach the GPU.
struct FrameAgent {
  glm::vec3 position{0.0F};  // metres, world axes, relative to Frame::origin: the agent's pivot on the ground
  float scale = 1.0F;        // uniform
  glm::vec2 heading{0.0F,
                    1.0F};  // (sin, cos) of the heading: model +Z maps to world (sin, 0, cos); (0, 1) is untouched
  PoseSample pose;          // into the character's PoseBank
  float phase = 0;          // of the clip, [0, 1)
  int bank_clip = 0;        // into PoseBank::clips()
  uint32_t outfit = 0;      // row of Frame::outfits
  uint32_t id = 1;          // agent index + 1
};

// Slots (Material::slot) that an outfit can colour; materials with a higher one stay as they are.
inline constexpr int kOutfitSlots = 16;

// Colour factors by slot, linear light, multiplied with the albedo; white leaves it alone.
struct Outfit {
  std::array<glm::vec4, kOutfitSlots> colours;
};

// How many samples a pixel's colour is the mean of, in linear light. What a pixel shows (id, depth, coverage) is that
// of its centre, and what is drawn is chosen for the picture's own size, whatever stands here.
struct Antialiasing {
  int samples = 1;      // multisampling, as the hardware does it: 1, 2, 4 or 8
  int supersample = 1;  // odd k: pictures k times as wide and high, k x k of whose pixels are averaged
  bool operator==(const Antialiasing&) const = default;
};

struct Frame {
  uint64_t tick = 0;       // of the scenario
  glm::dvec3 origin{0.0};  // the eye in world space; everything else is relative to it
  Camera camera;
  int width = 640;
  int height = 480;
  Antialiasing antialiasing;
  Light light;
  glm::vec4 background{0.2158605F, 0.2158605F, 0.2158605F, 1.0F};  // linear; the default is sRGB (128,128,128)
  bool ground = false;                                             // draw the grey grid
  double ground_height = 0;                                        // metres, world y: where it lies
  std::vector<Outfit> outfits;                                     // at least one; row 0 is white
  // agents[c] are those of character type c (the order of the scene's characters), sorted by agent index.
  std::vector<std::vector<FrameAgent>> agents;
};

}  // namespace crowdbench::scene
