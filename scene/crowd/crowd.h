// Crowd: agents as structure of arrays; its state is a pure function of (scenario, seed, tick).
#pragma once
#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include "scene/cast/cast.h"
#include "scene/frame/frame.h"
#include "scene/scenario/scenario.h"

namespace crowdbench::scene {

// What does not change with time: integers, hashes, + - * / and sqrt only, so the same bytes on any x86-64 machine.
// What an agent is (character, clip, phase, speed, scale, heading, outfit) does not depend on how many there are; where
// it stands does, except on a grid and with jitter, whose cells are counted outwards from the middle. In lanes, an
// agent's clip, speed and heading are those that its lane's ground speed and direction ask for.
//
// How near two agents' pivots come at tick 0, and with motion `treadmill` or `lanes` at any tick: on a grid one
// spacing, jittered 0.49 m (a person's breadth), in lanes 0.7 and as Poisson disks 0.75 spacings; so never nearer than
// 0.49 m. Stage `frustum` and motion `free` promise nothing.
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
  double period = 0;  // metres: `lanes` wrap over this length of their axis, `free` over a square of this side
  double wrap_x = 0, wrap_z = 0;  // metres: the middle of what they wrap over
  std::vector<Outfit> palette;    // the frame's outfits
  size_t size() const { return x.size(); }
};

// The view whose ground the stages `view` and `frustum` fill, and beyond which lanes wrap.
struct StageView {
  Camera camera;
  double aspect = 4.0 / 3.0;
  double near_depth = 4;  // metres: agents stand between these eye-space depths
  double far_depth = 60;
};

// The first view of the scenario with its stage depths: the view for make_crowd wherever no other is meant.
StageView stage_view(const Scenario& scenario);

// Throws Error when motion is `lanes` and one of the characters has no clip that moves.
Crowd make_crowd(const Scenario& scenario, const Cast& cast, const StageView& view);

// The frame of one tick, whatever was computed before. Agents wholly outside the view frustum (by bounding sphere) are
// left out when `cull`. seconds = tick / scenario.tick_rate.
Frame make_frame(const Scenario& scenario, const Cast& cast, const Crowd& crowd, const Camera& camera, uint64_t tick,
                 bool cull = true);

// Colour factors by slot for `count` outfits: row 0 white, the rest from the seed. Slots are those of the mannequin
// (skin, hair, shirt, trousers, shoes); higher ones get cloth. Loaded characters number slots by material, so every
// factor is mild enough for any of them: luminance 0.3 to 1.3.
std::vector<Outfit> make_outfits(uint64_t seed, uint32_t count);

}  // namespace crowdbench::scene
