// What stands where before the cameras of the depth cases: pairs of walkers, one exactly behind the other, and every
// front-facing surface of theirs at the centre of every pixel, in double.
#pragma once
#include <cstdint>
#include <vector>

#include "scene/frame/frame.h"

namespace crowdbench::bench {

class Fixture;

// One surface at the centre of a pixel.
struct Layer {
  double depth = 0;  // metres along the view axis
  uint32_t id = 0;   // FrameAgent::id
  double along = 0;  // metres by which it may be off along the axis in single precision
};

struct DepthScene {
  scene::Frame frame;
  std::vector<std::vector<Layer>> layers;  // by pixel, nearest first
  std::vector<bool> inner;                 // by pixel
};

struct DepthTruth {
  std::vector<DepthScene> scenes;
};

// Made once a fixture. 2 m to 10 km away, 1 mm to 10 m apart; planes are the caller's.
const DepthTruth& depth_truth(Fixture& fixture);

}  // namespace crowdbench::bench
