// What the OpenGL tests share: one debug context for the whole program, and small characters made by hand.
#pragma once
#include <gtest/gtest.h>

#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "renderers/frame/capture.h"
#include "renderers/gl/context.h"
#include "renderers/representation.h"
#include "scene/cast/cast.h"

namespace crowdbench::renderers::testing {

// The program's context; made at first use. Every error that the driver reports fails the test in which it happens.
gl::Context& context();

// A fixture that fails on any message of the driver.
class GlTest : public ::testing::Test {
 protected:
  void SetUp() override;
  void TearDown() override;
};

// A card of width x height metres in the plane z = 0, its lower edge's middle at the origin, facing +Z, one joint.
scene::Character card(float width, float height, const glm::vec4& colour = glm::vec4(1.0F));

// A card of 2 x 1 on two joints in one place: the upper joint's weight is the height.
scene::Character card_of_two_joints();

// Two boxes on two joints, one on the other; the upper joint turns about X by a quarter turn in clip "bend" (one
// second).
scene::Character two_bones();

// A cast of one character with the bank of its first clip (or its bind pose).
scene::Cast cast_of(scene::Character character, double rate = 30.0);

// The small mannequin with its walk: asymmetric enough that a wrong view or frame shows.
const scene::Cast& walker();
// Walkers side by side in 480 x 96 pixels, one a phase, each larger and turned further than the one before.
scene::Frame row_of_walkers(const std::vector<double>& phases);

// A representation of the cast, silently.
struct MakeOptions {
  bool use_cache = false;
  uint64_t budget = uint64_t{512} << 20;  // bytes
};
std::unique_ptr<Representation> make(const scene::Cast& cast, const std::string& spec, const MakeOptions& how = {});

// One of BakeInfo's or BakeItem's facts; a failure when there is none of the name.
double fact(const std::vector<std::pair<std::string, double>>& facts, const std::string& name);

// A frame looking along -Z from (0, eye_height, distance), without agents.
scene::Frame frame_of_one(double distance, double eye_height, int width, int height, double fov_y_deg = 40.0);
void add_agent(scene::Frame& frame, const scene::Cast& cast, const glm::dvec3& place, uint32_t id, double phase = 0.0,
               float heading_turns = 0.0F, float scale = 1.0F);

// One agent at the origin in a frame of 200 x 200, 1.75 metres to 120 pixels at the point that the eye turns around.
struct Viewpoint {
  double azimuth = 0, elevation = 0;  // degrees
  double phase = 0;
  float heading = 0;                 // turns
  double fov = 15;                   // degrees
  std::optional<glm::dvec3> around;  // the middle of the bank's bounds
};
scene::Frame frame_from(const scene::Cast& cast, const Viewpoint& view);

}  // namespace crowdbench::renderers::testing
