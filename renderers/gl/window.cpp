#include "renderers/gl/window.h"

#include <cassert>

#include "core/error.h"
#include "core/module.h"
#include "renderers/gl/context.h"
#include "renderers/gl/module/window_api.h"

namespace crowdbench::gl {
namespace {

const window::Api& api() {
  static const window::Api& loaded = [&]() -> const window::Api& {
    const auto function =
        reinterpret_cast<window::ApiFunction>(module_symbol("window", window::kApiSymbol, "opening a window"));
    const window::Api* found = function();
    if (found->version != window::kApiVersion) {
      throw Error("crowdbench_window.so", "is of another version than the program", "rebuild with ./run build");
    }
    return *found;
  }();
  return loaded;
}

}  // namespace

struct Window::State {
  window::Window* window = nullptr;
  int width = 0, height = 0;
  char message[window::kMessageBytes] = {};
  ~State() {
    if (window) api().close(window);
  }
  void show(const Image8& picture, uint8_t* shown) {
    assert(picture.channels == 4 && !picture.empty());
    if (!api().show(window, picture.data.data(), picture.width, picture.height, shown, message)) {
      throw Error("window", message, "check the display's OpenGL driver");
    }
  }
};

Window::Window(int width, int height, const std::string& title) : state_(std::make_unique<State>()) {
  const NoCurrentScope nothing_is_current;
  state_->window = api().open(width, height, title.c_str(), state_->message);
  if (!state_->window) {
    throw Error("window", state_->message,
                "set DISPLAY to a display that can be reached, or use a command that needs none (render, pair)");
  }
}

Window::~Window() = default;

WindowInput Window::poll() {
  window::Input raw;
  api().poll(state_->window, &raw);
  state_->width = raw.width;
  state_->height = raw.height;
  WindowInput input{raw.left_x, raw.left_y, raw.right_x, raw.right_y, raw.wheel, {}, raw.close != 0};
  for (int i = 0; i < raw.key_count; ++i) input.keys += static_cast<char32_t>(raw.keys[i]);
  return input;
}

void Window::set_title(const std::string& title) { api().set_title(state_->window, title.c_str()); }

void Window::show(const Image8& picture) { state_->show(picture, nullptr); }

Image8 Window::show_and_read(const Image8& picture) {
  Image8 shown(state_->width, state_->height, 4);
  state_->show(picture, shown.data.data());
  return shown;
}

}  // namespace crowdbench::gl
