#include "bench/commands/viewer.h"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "core/counted.h"

namespace crowdbench::bench {
namespace {

constexpr double kSteepest = 1.55;           // radians, short of the pole where up has no meaning
constexpr double kRadiansPerPixel = 0.0065;  // about half a turn over a picture of 480 rows
constexpr double kZoomPerStep = 0.88;

glm::dvec3 direction(const Orbit& orbit) {
  return {std::sin(orbit.azimuth) * std::cos(orbit.elevation), std::sin(orbit.elevation),
          std::cos(orbit.azimuth) * std::cos(orbit.elevation)};
}

}  // namespace

Orbit orbit_of(const scene::Camera& camera) {
  const glm::dvec3 back = camera.eye - camera.target;
  Orbit orbit;
  orbit.target = camera.target;
  orbit.distance = std::max(0.2, glm::length(back));
  orbit.azimuth = std::atan2(back.x, back.z);
  orbit.elevation = std::clamp(std::asin(std::clamp(back.y / orbit.distance, -1.0, 1.0)), -kSteepest, kSteepest);
  return orbit;
}

scene::Camera camera_of(const Orbit& orbit, const scene::Camera& start) {
  scene::Camera camera = start;
  camera.target = orbit.target;
  camera.eye = orbit.target + direction(orbit) * orbit.distance;
  camera.up = {0.0, 1.0, 0.0};
  return camera;
}

void apply_input(ViewerState& state, const gl::WindowInput& input, size_t representations, int rows,
                 const scene::Camera& start) {
  assert(representations > 0);
  Orbit& orbit = state.orbit;
  orbit.azimuth = std::remainder(orbit.azimuth - input.left_x * kRadiansPerPixel, 2 * 3.141592653589793);
  orbit.elevation = std::clamp(orbit.elevation + input.left_y * kRadiansPerPixel, -kSteepest, kSteepest);
  orbit.distance = std::clamp(orbit.distance * std::pow(kZoomPerStep, input.wheel), 0.2, 5000.0);
  if (input.right_x != 0 || input.right_y != 0) {
    // The point under the cursor, at the target's depth, follows it. Rows of the rotation: right, up, backward.
    const glm::dmat3 to_eye = scene::view_rotation(camera_of(orbit, start));
    const glm::dvec3 right{to_eye[0][0], to_eye[1][0], to_eye[2][0]};
    const glm::dvec3 up{to_eye[0][1], to_eye[1][1], to_eye[2][1]};
    const double metres = scene::pixel_size_at(start, orbit.distance, rows);
    orbit.target += (up * input.right_y - right * input.right_x) * metres;
  }
  for (const char32_t key : input.keys) {
    if (key >= U'1' && key <= U'9') {
      const size_t wanted = key - U'1';
      if (wanted < representations && wanted != state.current) {
        state.beside = state.current;  // side by side compares the last two that were chosen
        state.current = wanted;
      }
    } else if (key == U' ') {
      state.paused = !state.paused;
    } else if (key == U'.') {
      state.paused = true;
      ++state.tick;
    } else if (key == U's' || key == U'S') {
      state.side_by_side = !state.side_by_side;
    } else if (key == U'h' || key == U'H' || key == U'?') {
      state.help = !state.help;
    } else if (key == U'\x1b') {
      state.quit = true;
    }
  }
  if (input.close) state.quit = true;
}

std::string viewer_title(const ViewerState& state, const std::vector<std::string>& names, size_t agents) {
  const std::string what = state.side_by_side
                               ? fmt::format("{}, {} (left, right)", names[state.beside], names[state.current])
                               : names[state.current];
  return fmt::format("crowdbench: {} | {} | tick {}{}", what, counted(agents, "agent", "agents"), state.tick,
                     state.paused ? " (paused)" : "");
}

Image8 beside_each_other(const Image8& left, const Image8& right) {
  assert(left.height == right.height && left.channels == 4 && right.channels == 4);
  constexpr int kLine = 2;
  Image8 out(left.width + kLine + right.width, left.height, 4);
  std::fill(out.data.begin(), out.data.end(), uint8_t{255});
  for (int y = 0; y < out.height; ++y) {
    std::copy_n(left.at(0, y), static_cast<size_t>(left.width) * 4, out.at(0, y));
    std::copy_n(right.at(0, y), static_cast<size_t>(right.width) * 4, out.at(left.width + kLine, y));
  }
  return out;
}

void draw_help(Image8& picture, const std::vector<std::string>& names) {
  std::vector<std::string> lines = {"left drag: orbit   right drag: pan   wheel: zoom",
                                    "space: pause   .: step   s: side by side   h: hide this   Esc: quit"};
  for (size_t i = 0; i < std::min<size_t>(names.size(), 9); ++i)
    lines.push_back(fmt::format("{}: {}", i + 1, names[i]));
  constexpr double kSize = 0.42;
  constexpr int kLineHeight = 18;
  constexpr int kMargin = 8;
  int width = 0;
  for (const std::string& line : lines) {
    width = std::max(width, cv::getTextSize(line, cv::FONT_HERSHEY_SIMPLEX, kSize, 1, nullptr).width);
  }
  cv::Mat canvas(picture.height, picture.width, CV_8UC4, picture.data.data());
  const cv::Rect box = cv::Rect(0, 0, width + 2 * kMargin, static_cast<int>(lines.size()) * kLineHeight + kMargin) &
                       cv::Rect(0, 0, picture.width, picture.height);
  canvas(box).convertTo(canvas(box), -1, 0.35);
  for (size_t i = 0; i < lines.size(); ++i) {
    cv::putText(canvas, lines[i], {kMargin, static_cast<int>(i + 1) * kLineHeight - 3}, cv::FONT_HERSHEY_SIMPLEX, kSize,
                {255, 255, 255, 255}, 1, cv::LINE_AA);
  }
}

}  // namespace crowdbench::bench
