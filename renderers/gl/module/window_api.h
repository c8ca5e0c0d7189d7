// The interface of crowdbench_window.so, which brings GLFW: plain functions and structs. renderers/gl/window.h is what
// to use.
#pragma once
#include <cstdint>

namespace crowdbench::gl::window {

inline constexpr uint32_t kApiVersion = 1;
inline constexpr int kMessageBytes = 512;
inline constexpr int kKeys = 32;

// What the user did since the last poll. Dragging is in screen coordinates, y down.
struct Input {
  double left_x = 0, left_y = 0;    // dragged with the left button
  double right_x = 0, right_y = 0;  // dragged with the right or the middle button
  double wheel = 0;                 // steps, away from the user is positive
  uint32_t keys[kKeys] = {};        // characters typed (Unicode), 27 for Escape
  int32_t key_count = 0;
  int32_t close = 0;              // the window's close button
  int32_t width = 0, height = 0;  // pixels that can be drawn to
};

struct Window;

// Every failure leaves a one-line reason in `message` (kMessageBytes long).
struct Api {
  uint32_t version;
  // A window whose drawable part is width x height. Null on failure (no display).
  Window* (*open)(int32_t width, int32_t height, const char* title, char* message);
  void (*poll)(Window* window, Input* input);
  void (*set_title)(Window* window, const char* title);
  // Shows an RGBA picture, row 0 on top, as large as fits, the rest black. shown: null, or room for 4 bytes of each
  // pixel of the size that the last poll told: what stands in the window, row 0 on top.
  bool (*show)(Window* window, const uint8_t* rgba, int32_t width, int32_t height, uint8_t* shown, char* message);
  void (*close)(Window* window);
};

inline constexpr char kApiSymbol[] = "crowdbench_window_api";
using ApiFunction = const Api* (*)();

}  // namespace crowdbench::gl::window
