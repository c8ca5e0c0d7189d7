// Crowd: agents as structure of arrays; its state is a pure function of (scenario, seed, tick).
#pragma once
#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include "scene/frame.h"
#include "scene/gltf.h"
#include "scene/scenario.h"

namespace crowdbench::scene {

// A scenario's characters, loaded, with the banks that pose them.
struct Cast {
  std::vector<std::shared_ptr<const Character>> characters;
  std::vector<std::shared_ptr<const PoseBank>> banks;
  std::vector<double> shares;  // sum 1
};
// Loads every character of the scenario; `folder` resolves relative paths. Throws Error.
Cast load_cast(const Scenario& scenario, const std::filesystem::path& folder = {});

// What does not change with time: integers, hashes, + - * / and sqrt only, so the same bytes on any x86-64 machine.
struct Crowd {
  uint64_t seed = 0;
  std::vector<double> x, z;  // metres, world, at tick 0
  std::vector<double> heading_sin, heading_cos;
  std::vector<uint16_t> character;  // into the cast
  std::vector<uint16_t> bank_clip;  // into that character's bank
  std::vector<double> phase;        // [0, 1) at tick 0
  std::vector<double> speed;        // playback factor
  std::vector<double> scale;
  std::vector<uint32_t> outfit;
  MotionKind motion = MotionKind::treadmill;
  double period = 0;  // metres: `lanes` and `free` wrap over this length
  size_t size() const { return x.size(); }
};

// The view for which `stage = frustum` places agents.
struct StageView {
  Camera camera;
  double aspect = 4.0 / 3.0;
  double near_depth = 4;  // metres: agents stand between these eye-space depths
  double far_depth = 60;
};

Crowd make_crowd(const Scenario& scenario, const Cast& cast, const StageView& view);

// The frame of one tick, whatever was computed before. Agents wholly outside the view frustum (by bounding sphere) are
// left out when `cull`. seconds = tick / scenario.tick_rate.
Frame make_frame(const Scenario& scenario, const Cast& cast, const Crowd& crowd, const Camera& camera, uint64_t tick,
                 bool cull = true);

// Colour factors by part for `count` outfits: row 0 white, the rest from the seed.
std::vector<Outfit> make_outfits(uint64_t seed, uint32_t count);

}  // namespace crowdbench::scene
