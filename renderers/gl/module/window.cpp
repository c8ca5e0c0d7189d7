// GLFW behind the interface of window_api.h.
//
// The window has an OpenGL 3.3 context of its own on a thread of its own: the thread of the caller keeps its headless
// context current, and pictures come across as bytes. So a GPU without a display can draw for a display without a GPU.
#define GLFW_INCLUDE_GLCOREARB
#include <GLFW/glfw3.h>

#include <algorithm>
#include <condition_variable>
#include <cstdio>
#include <functional>
#include <mutex>
#include <string>
#include <thread>

#include "renderers/gl/module/window_api.h"

namespace crowdbench::gl::window {
namespace {

// The functions of the window's context, by glfwGetProcAddress: the program's own loader belongs to another context.
struct Functions {
  PFNGLBINDFRAMEBUFFERPROC bind_framebuffer = nullptr;
  PFNGLBINDTEXTUREPROC bind_texture = nullptr;
  PFNGLBLITFRAMEBUFFERPROC blit_framebuffer = nullptr;
  PFNGLCLEARCOLORPROC clear_color = nullptr;
  PFNGLCLEARPROC clear = nullptr;
  PFNGLFRAMEBUFFERTEXTURE2DPROC framebuffer_texture = nullptr;
  PFNGLGENFRAMEBUFFERSPROC make_framebuffers = nullptr;
  PFNGLGENTEXTURESPROC make_textures = nullptr;
  PFNGLGETERRORPROC get_error = nullptr;
  PFNGLPIXELSTOREIPROC pixel_store = nullptr;
  PFNGLREADPIXELSPROC read_pixels = nullptr;
  PFNGLTEXIMAGE2DPROC tex_image = nullptr;

  template <typename F>
  static bool get(F& function, const char* name) {
    function = reinterpret_cast<F>(glfwGetProcAddress(name));
    return function != nullptr;
  }
  bool load() {
    return get(bind_framebuffer, "glBindFramebuffer") && get(bind_texture, "glBindTexture") &&
           get(blit_framebuffer, "glBlitFramebuffer") && get(clear_color, "glClearColor") && get(clear, "glClear") &&
           get(framebuffer_texture, "glFramebufferTexture2D") && get(make_framebuffers, "glGenFramebuffers") &&
           get(make_textures, "glGenTextures") && get(get_error, "glGetError") && get(pixel_store, "glPixelStorei") &&
           get(read_pixels, "glReadPixels") && get(tex_image, "glTexImage2D");
  }
};

std::string& last_error() {
  static std::string text;
  return text;
}

}  // namespace

struct Window {
  GLFWwindow* handle = nullptr;
  Input input;
  double cursor_x = 0, cursor_y = 0;

  // One job at a time for the thread that owns the context; the caller waits.
  std::thread thread;
  std::mutex mutex;
  std::condition_variable changed;
  std::function<void()> job;
  bool stop = false;
  Functions gl;
  GLuint texture = 0, framebuffer = 0;

  void run(std::function<void()> work) {
    std::unique_lock lock(mutex);
    job = std::move(work);
    changed.notify_all();
    changed.wait(lock, [this] { return !job; });
  }

  void work() {
    std::unique_lock lock(mutex);
    while (true) {
      changed.wait(lock, [this] { return job || stop; });
      if (!job) return;
      job();
      job = nullptr;
      changed.notify_all();
    }
  }
};

namespace {

bool fail(char* message, const char* what) {
  std::snprintf(message, kMessageBytes, "%s%s%s", what, last_error().empty() ? "" : ": ", last_error().c_str());
  return false;
}

Window* of(GLFWwindow* handle) { return static_cast<Window*>(glfwGetWindowUserPointer(handle)); }

void type_key(Window& window, uint32_t character) {
  if (window.input.key_count < kKeys) window.input.keys[window.input.key_count++] = character;
}

void on_cursor(GLFWwindow* handle, double x, double y) {
  Window& window = *of(handle);
  const double dx = x - window.cursor_x;
  const double dy = y - window.cursor_y;
  window.cursor_x = x;
  window.cursor_y = y;
  const auto held = [handle](int button) { return glfwGetMouseButton(handle, button) == GLFW_PRESS; };
  if (held(GLFW_MOUSE_BUTTON_LEFT)) {
    window.input.left_x += dx;
    window.input.left_y += dy;
  } else if (held(GLFW_MOUSE_BUTTON_RIGHT) || held(GLFW_MOUSE_BUTTON_MIDDLE)) {
    window.input.right_x += dx;
    window.input.right_y += dy;
  }
}

void close(Window* window) {
  if (!window) return;
  if (window->thread.joinable()) {
    window->run([] { glfwMakeContextCurrent(nullptr); });
    {
      const std::scoped_lock lock(window->mutex);
      window->stop = true;
    }
    window->changed.notify_all();
    window->thread.join();
  }
  if (window->handle) glfwDestroyWindow(window->handle);
  glfwTerminate();
  delete window;
}

Window* open(int32_t width, int32_t height, const char* title, char* message) {
  last_error().clear();
  glfwSetErrorCallback([](int, const char* text) { last_error() = text; });
  if (!glfwInit()) {
    fail(message, "no window can be opened");
    return nullptr;
  }
  auto* window = new Window;
  glfwWindowHint(GLFW_CONTEXT_VERSION_MAJOR, 3);
  glfwWindowHint(GLFW_CONTEXT_VERSION_MINOR, 3);
  glfwWindowHint(GLFW_OPENGL_PROFILE, GLFW_OPENGL_CORE_PROFILE);
  window->handle = glfwCreateWindow(width, height, title, nullptr, nullptr);
  bool fine = window->handle != nullptr;
  if (fine) {
    glfwSetWindowUserPointer(window->handle, window);
    glfwGetCursorPos(window->handle, &window->cursor_x, &window->cursor_y);
    glfwSetCursorPosCallback(window->handle, on_cursor);
    glfwSetScrollCallback(window->handle, [](GLFWwindow* handle, double, double y) { of(handle)->input.wheel += y; });
    glfwSetCharCallback(window->handle,
                        [](GLFWwindow* handle, unsigned character) { type_key(*of(handle), character); });
    glfwSetKeyCallback(window->handle, [](GLFWwindow* handle, int key, int, int action, int) {
      if (key == GLFW_KEY_ESCAPE && action == GLFW_PRESS) type_key(*of(handle), 27);
    });
    window->thread = std::thread([window] { window->work(); });
    window->run([window, &fine] {
      glfwMakeContextCurrent(window->handle);
      fine = window->gl.load();
      if (!fine) return;
      glfwSwapInterval(1);
      window->gl.make_textures(1, &window->texture);
      window->gl.make_framebuffers(1, &window->framebuffer);
      window->gl.bind_texture(GL_TEXTURE_2D, window->texture);
      window->gl.bind_framebuffer(GL_READ_FRAMEBUFFER, window->framebuffer);
    });
  }
  if (!fine) {
    fail(message, "no OpenGL 3.3 window can be opened");
    close(window);
    return nullptr;
  }
  return window;
}

void poll(Window* window, Input* input) {
  glfwPollEvents();
  glfwGetFramebufferSize(window->handle, &window->input.width, &window->input.height);
  window->input.close = glfwWindowShouldClose(window->handle);
  *input = window->input;
  window->input = {};
  window->input.width = input->width;
  window->input.height = input->height;
}

void set_title(Window* window, const char* title) { glfwSetWindowTitle(window->handle, title); }

bool show(Window* window, const uint8_t* rgba, int32_t width, int32_t height, uint8_t* shown, char* message) {
  const int full_width = window->input.width;
  const int full_height = window->input.height;
  if (full_width < 1 || full_height < 1) return true;  // minimised
  const double scale = std::min(double(full_width) / width, double(full_height) / height);
  const int to_width = std::max(1, static_cast<int>(width * scale + 0.5));
  const int to_height = std::max(1, static_cast<int>(height * scale + 0.5));
  const int x = (full_width - to_width) / 2;
  const int y = (full_height - to_height) / 2;
  GLenum error = GL_NO_ERROR;
  window->run([&] {
    const Functions& gl = window->gl;
    gl.pixel_store(GL_UNPACK_ALIGNMENT, 4);
    gl.tex_image(GL_TEXTURE_2D, 0, GL_RGBA8, width, height, 0, GL_RGBA, GL_UNSIGNED_BYTE, rgba);
    gl.framebuffer_texture(GL_READ_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, window->texture, 0);
    gl.bind_framebuffer(GL_DRAW_FRAMEBUFFER, 0);
    gl.clear_color(0, 0, 0, 1);
    gl.clear(GL_COLOR_BUFFER_BIT);
    // The picture's first row is its top, OpenGL's first row is the bottom.
    gl.blit_framebuffer(0, 0, width, height, x, y + to_height, x + to_width, y, GL_COLOR_BUFFER_BIT,
                        to_width % width == 0 && to_height % height == 0 ? GL_NEAREST : GL_LINEAR);
    if (shown) {
      gl.bind_framebuffer(GL_READ_FRAMEBUFFER, 0);
      gl.pixel_store(GL_PACK_ALIGNMENT, 4);
      gl.read_pixels(0, 0, full_width, full_height, GL_RGBA, GL_UNSIGNED_BYTE, shown);
      gl.bind_framebuffer(GL_READ_FRAMEBUFFER, window->framebuffer);
    }
    error = gl.get_error();
    glfwSwapBuffers(window->handle);
  });
  if (error != GL_NO_ERROR) {
    std::snprintf(message, kMessageBytes, "OpenGL error 0x%x while showing a picture", error);
    return false;
  }
  if (shown) {
    const size_t row = static_cast<size_t>(full_width) * 4;
    for (int top = 0, bottom = full_height - 1; top < bottom; ++top, --bottom) {
      std::swap_ranges(shown + static_cast<size_t>(top) * row, shown + static_cast<size_t>(top + 1) * row,
                       shown + static_cast<size_t>(bottom) * row);
    }
  }
  return true;
}

}  // namespace
}  // namespace crowdbench::gl::window

extern "C" __attribute__((visibility("default"))) const crowdbench::gl::window::Api* crowdbench_window_api() {
  using namespace crowdbench::gl::window;
  static const Api api = {kApiVersion, open, poll, set_title, show, close};
  return &api;
}
