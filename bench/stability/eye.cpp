// The eye where nobody puts it: against the skin, inside of what is drawn, in the plane of a box's face, far away,
// behind very long and very short lenses.
#include <fmt/format.h>

#include <cmath>
#include <utility>

#include "bench/stability/fixture.h"
#include "bench/stability/surface.h"

namespace crowdbench::bench {
namespace {

using renderers::Capture;

// The walker at the origin in the pose of phase 0, which every representation stores.
scene::Frame walker_frame(Fixture& fixture, const glm::dvec3& eye, const glm::dvec3& target, double fov_deg,
                          double near) {
  scene::Frame frame = empty_frame(eye, target, fov_deg, fixture.side(240), fixture.side(240));
  frame.camera.near = near;
  add_agent(frame, fixture.walker(), {0, 0, 0});
  return frame;
}

// The foremost point of the chest.
glm::dvec3 chest(const scene::Cast& cast) {
  const scene::PoseBank& bank = *cast.banks[0];
  glm::dvec3 best(0, 0, -1e9);
  for (const glm::vec3& p : scene::skin_points(cast.characters[0]->mesh, bank.palette(bank.sample(0, 0))))
    if (p.y > 1.15F && p.y < 1.35F && std::abs(p.x) < 0.1F && static_cast<double>(p.z) > best.z) best = glm::dvec3(p);
  return best;
}

Found a_centimetre_off(Fixture& fixture) {
  const glm::dvec3 skin = chest(fixture.walker());
  return wrong_pixels(fixture, walker_frame(fixture, skin + glm::dvec3(0, 0, 0.01), skin, 60, 1e-3));
}

Found inside_the_body(Fixture& fixture) {
  scene::Frame frame = walker_frame(fixture, {0, 1.2, 0}, {0.3, 1.3, 1}, 60, 1e-3);
  const Capture drawn = fixture.draw(frame, true);
  const Insane insane = insane_pixels(drawn, frame);
  Found found;
  found.bound = 0;
  found.measured = static_cast<double>(insane.pixels);
  found.got = insane.what;
  found.note = "numbers alone: nobody claims the inside of a body";
  return found;
}

Found inside_the_box(Fixture& fixture) {
  const scene::PoseBank& bank = *fixture.walker().banks[0];
  const glm::dvec3 low(bank.bounds_min());
  const glm::dvec3 high(bank.bounds_max());
  const glm::dvec3 corner = glm::mix(low, high, glm::dvec3(0.97, 0.97, 0.97));
  return wrong_pixels(fixture, walker_frame(fixture, corner, (low + high) * 0.5, 90, 1e-3));
}

Found in_a_faces_plane(Fixture& fixture) {
  const glm::dvec3 high(fixture.walker().banks[0]->bounds_max());
  Found worst;
  worst.measured = -1;
  for (const glm::dvec3& eye : {glm::dvec3(3, 1, high.z), glm::dvec3(high.x, 1, 3), glm::dvec3(2, high.y, 2)}) {
    const glm::dvec3 along = eye.x == high.x ? glm::dvec3(0, 0, -1) : glm::dvec3(-1, 0, eye.z == high.z ? 0 : -1);
    Found found = wrong_pixels(fixture, walker_frame(fixture, eye, eye + along, 60, 0.1));
    if (found.measured > worst.measured) worst = std::move(found);
  }
  return worst;
}

Found straight_above(Fixture& fixture) {
  return wrong_pixels(fixture, walker_frame(fixture, {0, 5, 0}, {0, 0, 0}, 30, 0.1));
}
Found straight_below(Fixture& fixture) {
  return wrong_pixels(fixture, walker_frame(fixture, {0, -4, 0}, {0, 0, 0}, 30, 0.1));
}
// 1.75 m to two thirds of the picture's height.
Found ten_kilometres(Fixture& fixture) {
  return wrong_pixels(fixture, walker_frame(fixture, {0, 0.9, 1e4}, {0, 0.9, 0}, 0.015, 0.1));
}
Found one_degree(Fixture& fixture) {
  return wrong_pixels(fixture, walker_frame(fixture, {0, 0.9, 140}, {0, 0.9, 0}, 1, 0.1));
}
Found a_hundred_and_seventy_degrees(Fixture& fixture) {
  return wrong_pixels(fixture, walker_frame(fixture, {0.1, 0.9, 0.8}, {0, 0.9, 0}, 170, 0.01));
}

// Whether the pixels beside it show the same agent, no deeper or nearer than a sixty-fourth: where a surface is seen
// edge-on, a rasteriser's depth is its slope times where in the pixel it looks.
bool is_inner(const Capture& capture, int x, int y) {
  if (x == 0 || y == 0 || x + 1 == capture.ids.width || y + 1 == capture.ids.height) return false;
  const float here = *capture.depth.at(x, y);
  for (const auto& [i, j] : {std::pair{-1, 0}, std::pair{1, 0}, std::pair{0, -1}, std::pair{0, 1}})
    if (*capture.ids.at(x + i, y + j) != *capture.ids.at(x, y) ||
        std::abs(*capture.depth.at(x + i, y + j) - here) > here / 64)
      return false;
  return true;
}

// The planes choose how depths are stored, and nothing else.
Found other_planes(Fixture& fixture, double near, double far) {
  scene::Frame frame = walker_frame(fixture, {0.5, 1.4, 3}, {0, 0.9, 0}, 40, 0.1);
  const Capture usual = fixture.draw(frame);
  frame.camera.near = near;
  frame.camera.far = far;
  const Capture drawn = fixture.draw(frame, true);
  Found found;
  found.measured = static_cast<double>(insane_pixels(drawn, frame).pixels) > 0 ? INFINITY : 0;
  uint64_t others = 0;
  uint64_t inner = 0;
  for (int y = 0; y < frame.height; ++y)
    for (int x = 0; x < frame.width; ++x) {
      const auto a = static_cast<double>(*usual.depth.at(x, y));
      const auto b = static_cast<double>(*drawn.depth.at(x, y));
      others += *usual.ids.at(x, y) != *drawn.ids.at(x, y) ? 1U : 0U;
      if (!std::isfinite(a) || !std::isfinite(b) || !is_inner(usual, x, y)) continue;
      ++inner;
      const double apart = std::abs(a - b) / a;
      if (!(apart > found.measured)) continue;
      found.measured = apart;
      found.place = fmt::format("pixel ({}, {})", x, y);
      found.expected = fmt::format("{:.8g} m", a);
      found.got = fmt::format("{:.8g} m", b);
    }
  if (others > 0) found.measured = INFINITY;
  found.note = fmt::format("{} pixels inside of outlines compared, {} show another agent or none", inner, others);
  found.bound = 32 * 0x1p-24;
  return found;
}

}  // namespace

void add_eye_cases(std::vector<StabilityCase>& cases) {
  const auto add = [&](std::string_view name, std::string_view asked, Found (*measure)(Fixture&)) {
    cases.push_back({.name = name,
                     .group = "eye",
                     .asked = asked,
                     .unit = "wrong pixels",
                     .bound_from = kSurfaceBound,
                     .measure = measure});
  };
  add("eye_1cm", "1 cm before the chest", a_centimetre_off);
  add("eye_in_body", "inside of the body", inside_the_body);
  add("eye_in_box", "inside of the box around the body, in its corner", inside_the_box);
  add("eye_in_plane", "exactly in the plane of three faces of that box", in_a_faces_plane);
  add("eye_above", "straight above, looking down", straight_above);
  add("eye_below", "straight below, looking up", straight_below);
  add("eye_10km", "10 km away, the figure as tall as ever", ten_kilometres);
  add("eye_fov_1", "a field of view of 1 degree", one_degree);
  add("eye_fov_170", "a field of view of 170 degrees, 0.8 m away", a_hundred_and_seventy_degrees);
  const auto planes = [&](std::string_view name, std::string_view asked, Found (*measure)(Fixture&)) {
    cases.push_back({.name = name,
                     .group = "eye",
                     .asked = asked,
                     .unit = "of the depth",
                     .bound_from =
                         "32 roundings of a float: the transform, the interpolation and the division on the "
                         "way to a depth and back; no pixel of another agent. That depths are compared inside "
                         "of outlines alone was decided after they had differed at them",
                     .bound_seen = true,
                     .measure = measure});
  };
  planes("eye_near_far", "planes at 1e-3 and 1e6 m: the depths of 0.1 m and infinity",
         [](Fixture& fixture) { return other_planes(fixture, 1e-3, 1e6); });
  planes("eye_infinite_far", "planes at 1e-3 m and infinity: the same",
         [](Fixture& fixture) { return other_planes(fixture, 1e-3, 0); });
}

}  // namespace crowdbench::bench
