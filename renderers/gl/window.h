// Window: shows finished pictures on a display and tells what the user did.
//
// Everything is drawn off screen, by the headless context that measures too, and comes here as bytes: what the window
// shows is what a capture holds, and a GPU without a display can serve a display without a GPU. GLFW (and with it X11)
// comes as a module, loaded when the first window opens: nothing else needs it.
#pragma once
#include <memory>
#include <string>
#include <vector>

#include "core/image.h"

namespace crowdbench::gl {

// What the user did since the last poll. Dragging is in screen coordinates, y down.
struct WindowInput {
  double left_x = 0, left_y = 0;    // dragged with the left button
  double right_x = 0, right_y = 0;  // dragged with the right or the middle button
  double wheel = 0;                 // steps, away from the user is positive
  std::u32string keys;              // characters typed, in order; U'\x1b' is Escape
  bool close = false;               // the window's close button was pressed
};

class Window {
 public:
  // width, height: of the part that can be drawn to, pixels. Throws Error when there is no display, no OpenGL 3.3 on
  // it, or the module is absent. One window at a time.
  Window(int width, int height, const std::string& title);
  ~Window();
  Window(const Window&) = delete;
  Window& operator=(const Window&) = delete;

  // Handles what happened; call it at least once before show() and often.
  WindowInput poll();
  void set_title(const std::string& title);
  // An RGBA picture, row 0 on top, as large as fits with its shape kept, the rest black. Waits for the display's
  // refresh where the driver does. Throws Error.
  void show(const Image8& picture);
  // The same, and what then stood in the window: RGBA, of the window's size at the last poll().
  Image8 show_and_read(const Image8& picture);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace crowdbench::gl
