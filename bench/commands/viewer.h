// The viewer's state and what keys and mouse do to it, apart from any window, so that it can be tested without one.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "core/image.h"
#include "renderers/gl/window.h"
#include "scene/frame/camera.h"

namespace crowdbench::bench {

// A camera that circles a point. The field of view and the near plane are the start camera's; up is +Y.
struct Orbit {
  glm::dvec3 target{0.0, 1.0, 0.0};
  double azimuth = 0;      // radians; 0: the eye lies towards +Z, growing towards +X
  double elevation = 0.3;  // radians, -1.55 .. 1.55
  double distance = 9;     // metres, 0.2 .. 5000
};
Orbit orbit_of(const scene::Camera& camera);
scene::Camera camera_of(const Orbit& orbit, const scene::Camera& start);

struct ViewerState {
  Orbit orbit;
  uint64_t tick = 0;
  bool paused = false;
  size_t current = 0;  // of the representations on offer
  size_t beside = 0;   // the other half of side by side
  bool side_by_side = false;
  bool help = true;
  bool quit = false;
};

// Left drag orbits, right drag pans, the wheel zooms; space pauses, '.' pauses and steps one tick, 1..9 switch, s is
// side by side, h the help text, Escape or the window's close button quit. rows: of the picture, for panning as fast as
// the mouse; start: the camera whose field of view is in use.
void apply_input(ViewerState& state, const gl::WindowInput& input, size_t representations, int rows,
                 const scene::Camera& start);

// "crowdbench: mesh | 100 agents | tick 42 (paused)"; with two names they are "mesh, flat (left, right)".
std::string viewer_title(const ViewerState& state, const std::vector<std::string>& names, size_t agents);

// Two pictures of one height beside each other, a white line of two columns between them. RGBA.
Image8 beside_each_other(const Image8& left, const Image8& right);

// Writes the help text and the names of the representations over an RGBA picture.
void draw_help(Image8& picture, const std::vector<std::string>& names);

}  // namespace crowdbench::bench
