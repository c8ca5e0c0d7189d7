#include "renderers/gl/context.h"

#include <dlfcn.h>
#include <epoxy/egl.h>
#include <epoxy/gl.h>

#include <cassert>
#include <charconv>
#include <cstdlib>
#include <string_view>
#include <utility>

#include "core/error.h"

namespace crowdbench::gl {
namespace {

thread_local const ContextState* current_state = nullptr;

std::string egl_error_name(EGLint error) {
  switch (error) {
    case EGL_SUCCESS: return "EGL_SUCCESS";
    case EGL_NOT_INITIALIZED: return "EGL_NOT_INITIALIZED";
    case EGL_BAD_ACCESS: return "EGL_BAD_ACCESS";
    case EGL_BAD_ALLOC: return "EGL_BAD_ALLOC";
    case EGL_BAD_ATTRIBUTE: return "EGL_BAD_ATTRIBUTE";
    case EGL_BAD_CONFIG: return "EGL_BAD_CONFIG";
    case EGL_BAD_CONTEXT: return "EGL_BAD_CONTEXT";
    case EGL_BAD_CURRENT_SURFACE: return "EGL_BAD_CURRENT_SURFACE";
    case EGL_BAD_DISPLAY: return "EGL_BAD_DISPLAY";
    case EGL_BAD_MATCH: return "EGL_BAD_MATCH";
    case EGL_BAD_NATIVE_PIXMAP: return "EGL_BAD_NATIVE_PIXMAP";
    case EGL_BAD_NATIVE_WINDOW: return "EGL_BAD_NATIVE_WINDOW";
    case EGL_BAD_PARAMETER: return "EGL_BAD_PARAMETER";
    case EGL_BAD_SURFACE: return "EGL_BAD_SURFACE";
    case EGL_CONTEXT_LOST: return "EGL_CONTEXT_LOST";
    case EGL_BAD_DEVICE_EXT: return "EGL_BAD_DEVICE_EXT";
    default: return fmt::format("EGL error {:#x}", error);
  }
}

// libepoxy ends the process when a library is missing; asking first turns that into a message.
void require_libraries() {
  static const bool present = [] {
    if (!dlopen("libEGL.so.1", RTLD_LAZY | RTLD_LOCAL))
      throw Error("OpenGL", "there is no libEGL.so.1 on this machine",
                  "install a driver that has it (Debian: apt-get install libegl1)");
    if (!dlopen("libOpenGL.so.0", RTLD_LAZY | RTLD_LOCAL) && !dlopen("libGL.so.1", RTLD_LAZY | RTLD_LOCAL))
      throw Error("OpenGL", "there is neither libOpenGL.so.0 nor libGL.so.1 on this machine",
                  "install one (Debian: apt-get install libopengl0)");
    return true;
  }();
  (void)present;
}

// llvmpipe's shader cache on disk is keyed by the shader and the processor, not by the vector width (Mesa 22.3.6): code
// compiled 8 lanes wide, run where LP_NATIVE_VECTOR_WIDTH asks for 4, writes 8 vertices at a time into room for a
// multiple of 4. Where the variable is set, nothing is taken from the cache nor left there; said before the driver
// starts.
void keep_vector_widths_apart() {
  if (std::getenv("LP_NATIVE_VECTOR_WIDTH")) setenv("MESA_SHADER_CACHE_DISABLE", "true", 0);
}

bool has_word(const char* list, std::string_view word) {
  if (!list) return false;
  std::string_view rest(list);
  while (!rest.empty()) {
    const size_t space = rest.find(' ');
    if (rest.substr(0, space) == word) return true;
    if (space == std::string_view::npos) break;
    rest.remove_prefix(space + 1);
  }
  return false;
}

const char* client_extensions() { return eglQueryString(EGL_NO_DISPLAY, EGL_EXTENSIONS); }

std::vector<EGLDeviceEXT> query_devices() {
  const char* client = client_extensions();
  const bool enumerates = has_word(client, "EGL_EXT_device_base") || has_word(client, "EGL_EXT_device_enumeration");
  if (!enumerates || !has_word(client, "EGL_EXT_platform_device")) return {};
  const auto query = reinterpret_cast<PFNEGLQUERYDEVICESEXTPROC>(eglGetProcAddress("eglQueryDevicesEXT"));
  EGLint count = 0;
  if (!query || !query(0, nullptr, &count) || count <= 0) return {};
  std::vector<EGLDeviceEXT> devices(static_cast<size_t>(count));
  if (!query(count, devices.data(), &count)) return {};
  devices.resize(static_cast<size_t>(count));
  return devices;
}

const char* device_string(EGLDeviceEXT device, EGLint what) {
  const auto query = reinterpret_cast<PFNEGLQUERYDEVICESTRINGEXTPROC>(eglGetProcAddress("eglQueryDeviceStringEXT"));
  return query ? query(device, what) : nullptr;
}

Device describe(EGLDeviceEXT device, int index) {
  Device out;
  out.index = index;
  const char* extensions = device_string(device, EGL_EXTENSIONS);
  out.software = has_word(extensions, "EGL_MESA_device_software");
  const char* name = nullptr;
  constexpr EGLint kRendererExt = 0x335F;  // EGL_RENDERER_EXT of EGL_EXT_device_query_name
  if (has_word(extensions, "EGL_EXT_device_query_name")) name = device_string(device, kRendererExt);
  if (!name && has_word(extensions, "EGL_EXT_device_drm")) name = device_string(device, EGL_DRM_DEVICE_FILE_EXT);
  out.name = name ? printable(name) : out.software ? "software rasteriser" : "unnamed";
  return out;
}

// One kind of device that a context was asked of, and why it failed.
struct Attempt {
  EGLDisplay display = EGL_NO_DISPLAY;
  EGLContext context = EGL_NO_CONTEXT;
  std::string failure;
};

Attempt open_display(EGLDisplay display, bool debug) {
  Attempt out;
  const auto failed = [&out](const char* step) {
    out.failure = fmt::format("{} failed with {}", step, egl_error_name(eglGetError()));
    return out;
  };
  if (display == EGL_NO_DISPLAY) return failed("eglGetPlatformDisplay");
  EGLint major = 0;
  EGLint minor = 0;
  if (!eglInitialize(display, &major, &minor)) return failed("eglInitialize");
  const char* extensions = eglQueryString(display, EGL_EXTENSIONS);
  if (!has_word(extensions, "EGL_KHR_surfaceless_context")) {
    out.failure = "the display lacks EGL_KHR_surfaceless_context";
    return out;
  }
  if (!eglBindAPI(EGL_OPENGL_API)) return failed("eglBindAPI(EGL_OPENGL_API)");
  EGLConfig config = nullptr;  // EGL_NO_CONFIG_KHR
  if (!has_word(extensions, "EGL_KHR_no_config_context")) {
    const EGLint want[] = {EGL_SURFACE_TYPE, EGL_PBUFFER_BIT, EGL_RENDERABLE_TYPE, EGL_OPENGL_BIT, EGL_NONE};
    EGLint count = 0;
    if (!eglChooseConfig(display, want, &config, 1, &count) || count < 1) return failed("eglChooseConfig");
  }
  const EGLint want[] = {EGL_CONTEXT_MAJOR_VERSION,
                         4,
                         EGL_CONTEXT_MINOR_VERSION,
                         5,
                         EGL_CONTEXT_OPENGL_PROFILE_MASK,
                         EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT,
                         EGL_CONTEXT_OPENGL_DEBUG,
                         debug ? EGL_TRUE : EGL_FALSE,
                         EGL_NONE};
  const EGLContext context = eglCreateContext(display, config, EGL_NO_CONTEXT, want);
  if (context == EGL_NO_CONTEXT) return failed("eglCreateContext (OpenGL 4.5 core)");
  if (!eglMakeCurrent(display, EGL_NO_SURFACE, EGL_NO_SURFACE, context)) {
    Attempt result = failed("eglMakeCurrent");
    eglDestroyContext(display, context);
    return result;
  }
  out.display = display;
  out.context = context;
  return out;
}

EGLDisplay platform_display(EGLenum platform, void* native) {
  const auto get = reinterpret_cast<PFNEGLGETPLATFORMDISPLAYEXTPROC>(eglGetProcAddress("eglGetPlatformDisplayEXT"));
  return get ? get(platform, native, nullptr) : EGL_NO_DISPLAY;
}

void GLAPIENTRY on_debug_message(GLenum, GLenum type, GLuint, GLenum severity, GLsizei length, const GLchar* message,
                                 const void* user) {
  const bool wrong = type == GL_DEBUG_TYPE_ERROR || type == GL_DEBUG_TYPE_UNDEFINED_BEHAVIOR;
  if (!wrong && severity != GL_DEBUG_SEVERITY_HIGH) return;
  auto* messages = static_cast<std::vector<std::string>*>(const_cast<void*>(user));
  const std::string_view text =
      length < 0 ? std::string_view(message) : std::string_view(message, static_cast<size_t>(length));
  if (messages->size() < 100) messages->push_back(printable(text, 500));
}

std::string gl_string(GLenum what) {
  const auto* text = reinterpret_cast<const char*>(glGetString(what));
  return text ? printable(text) : "unknown";
}

int get_integer(GLenum what) {
  GLint value = 0;
  glGetIntegerv(what, &value);
  return value;
}

}  // namespace

CurrentScope::CurrentScope(const ContextState& state) {
  if (current_state == &state) return;
  before_ = current_state;
  state.make_current();
  current_state = &state;
}

CurrentScope::~CurrentScope() {
  if (!before_) return;
  before_->make_current();
  current_state = before_;
}

NoCurrentScope::NoCurrentScope() : before_(current_state) {
  if (!before_) return;
  eglMakeCurrent(eglGetCurrentDisplay(), EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
  current_state = nullptr;
}

NoCurrentScope::~NoCurrentScope() {
  if (!before_) return;
  before_->make_current();
  current_state = before_;
}

struct Context::Egl {
  EGLDisplay display = EGL_NO_DISPLAY;
  EGLContext context = EGL_NO_CONTEXT;
};

std::vector<Device> list_devices() {
  require_libraries();
  const std::vector<EGLDeviceEXT> devices = query_devices();
  std::vector<Device> out;
  for (size_t i = 0; i < devices.size(); ++i) out.push_back(describe(devices[i], static_cast<int>(i)));
  return out;
}

namespace {

// Which device is asked for, and by what.
struct DeviceWish {
  std::string name;   // empty: any
  std::string where;  // for messages
};

DeviceWish device_wish(const ContextOptions& options) {
  if (!options.device.empty()) return {options.device, "--device"};
  if (const char* variable = std::getenv("CROWDBENCH_DEVICE")) return {variable, "CROWDBENCH_DEVICE"};
  return {"", "--device"};
}

// The devices to try, best first: hardware before software unless one is named.
std::vector<Device> devices_to_try(const DeviceWish& wish, const std::vector<Device>& devices) {
  std::vector<Device> order;
  const auto append = [&](bool software) {
    for (const Device& d : devices)
      if (d.software == software) order.push_back(d);
  };
  if (wish.name == "surfaceless") return order;
  if (wish.name.empty()) append(false);
  if (wish.name.empty() || wish.name == "software") {
    append(true);
    return order;
  }
  size_t index = 0;
  const auto [end, fault] = std::from_chars(wish.name.data(), wish.name.data() + wish.name.size(), index);
  if (fault != std::errc{} || end != wish.name.data() + wish.name.size())
    throw Error(wish.where, fmt::format("'{}' is not a device", printable(wish.name)),
                "give an index, software or surfaceless; crowdbench info lists the devices");
  if (index >= devices.size())
    throw Error(wish.where, fmt::format("there is no EGL device {}: {} found", index, devices.size()),
                "crowdbench info lists the devices");
  return {devices[index]};
}

}  // namespace

Context::Context(const ContextOptions& options) {
  require_libraries();
  keep_vector_widths_apart();
  const DeviceWish wish = device_wish(options);
  const std::vector<EGLDeviceEXT> handles = query_devices();
  std::vector<Device> devices;
  for (size_t i = 0; i < handles.size(); ++i) devices.push_back(describe(handles[i], static_cast<int>(i)));
  const std::vector<Device> order = devices_to_try(wish, devices);

  std::vector<std::string> failures;
  Attempt attempt;
  for (const Device& device : order) {
    attempt = open_display(platform_display(EGL_PLATFORM_DEVICE_EXT, handles[static_cast<size_t>(device.index)]),
                           options.debug);
    if (attempt.context != EGL_NO_CONTEXT) {
      platform_ = fmt::format("EGL device {}{}", device.index, device.software ? " (software)" : "");
      break;
    }
    failures.push_back(fmt::format("EGL device {} ({}): {}", device.index, device.name, attempt.failure));
  }
  const bool surfaceless_allowed =
      wish.name.empty() || wish.name == "surfaceless" || (wish.name == "software" && order.empty());
  if (attempt.context == EGL_NO_CONTEXT && surfaceless_allowed) {
    if (has_word(client_extensions(), "EGL_MESA_platform_surfaceless")) {
      attempt = open_display(platform_display(EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY), options.debug);
      platform_ = "EGL surfaceless";
      if (attempt.context == EGL_NO_CONTEXT) failures.push_back("EGL surfaceless: " + attempt.failure);
    } else {
      failures.emplace_back("EGL surfaceless: the driver lacks EGL_MESA_platform_surfaceless");
    }
  }
  if (attempt.context == EGL_NO_CONTEXT)
    throw Error("OpenGL",
                fmt::format("no context ({} EGL device(s)): {}", handles.size(),
                            failures.empty() ? "no device of that kind" : fmt::format("{}", fmt::join(failures, "; "))),
                "a driver with OpenGL 4.5 core is needed (Debian: apt-get install libegl1 libgl1-mesa-dri)");
  for (const std::string& f : failures) warnings_.push_back(f + "; drawing on " + platform_ + " instead");

  egl_ = std::make_unique<Egl>(Egl{attempt.display, attempt.context});
  state_->make_current = [display = attempt.display, context = attempt.context] {
    const EGLBoolean fine = eglMakeCurrent(display, EGL_NO_SURFACE, EGL_NO_SURFACE, context);
    assert(fine);
    (void)fine;
  };
  state_->alive = true;
  current_state = state_.get();
  read_capabilities(options.debug);
}

Context::~Context() {
  state_->alive = false;
  if (current_state == state_.get()) {
    current_state = nullptr;
    eglMakeCurrent(egl_->display, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
  }
  // The display stays initialised: EGL counts no references, and another context may share it.
  eglDestroyContext(egl_->display, egl_->context);
}

void Context::make_current() const {
  if (current_state == state_.get()) return;
  state_->make_current();
  current_state = state_.get();
}

void Context::read_capabilities(bool debug) {
  vendor_ = gl_string(GL_VENDOR);
  renderer_ = gl_string(GL_RENDERER);
  version_ = gl_string(GL_VERSION);
  for (const char* name : {"llvmpipe", "softpipe", "swrast", "SwiftShader", "Software Rasterizer"})
    software_ = software_ || renderer_.find(name) != std::string::npos;
  if (epoxy_gl_version() < 45)
    throw Error("OpenGL", fmt::format("{} offers {}", renderer_, version_), "OpenGL 4.5 core is needed");
  limits_.texture_size = get_integer(GL_MAX_TEXTURE_SIZE);
  limits_.array_layers = get_integer(GL_MAX_ARRAY_TEXTURE_LAYERS);
  glGetInteger64v(GL_MAX_SHADER_STORAGE_BLOCK_SIZE, &limits_.storage_block);
  limits_.storage_alignment = get_integer(GL_SHADER_STORAGE_BUFFER_OFFSET_ALIGNMENT);
  limits_.texel_buffer = get_integer(GL_MAX_TEXTURE_BUFFER_SIZE);
  limits_.uniform_block = get_integer(GL_MAX_UNIFORM_BLOCK_SIZE);
  limits_.samples = std::min(get_integer(GL_MAX_COLOR_TEXTURE_SAMPLES), get_integer(GL_MAX_DEPTH_TEXTURE_SAMPLES));
  GLint viewport[2] = {0, 0};
  glGetIntegerv(GL_MAX_VIEWPORT_DIMS, viewport);
  limits_.viewport_size = viewport[0] < viewport[1] ? viewport[0] : viewport[1];
  if (debug) {
    glEnable(GL_DEBUG_OUTPUT);
    glEnable(GL_DEBUG_OUTPUT_SYNCHRONOUS);
    glDebugMessageCallback(on_debug_message, &debug_messages_);
  }
}

bool Context::has_extension(const std::string& name) const {
  make_current();
  return epoxy_has_gl_extension(name.c_str());
}

std::vector<std::string> Context::take_debug_messages() { return std::exchange(debug_messages_, {}); }

void Context::finish() const {
  make_current();
  glFinish();
}

}  // namespace crowdbench::gl
