// Context: one headless OpenGL 4.5 core context through EGL, and what it can do.
#pragma once
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace crowdbench::gl {

struct ContextOptions {
  // Which device draws: "" = $CROWDBENCH_DEVICE, and when that is unset too the first device that is not a software
  // rasteriser, else the software one; "N" = that index in the list of EGL devices; "software"; "surfaceless" = the
  // platform without devices (Mesa's).
  std::string device;
  // Asks for a debug context, so that every error of a GL call is kept in debug_messages().
  bool debug = false;
};

// One EGL device, in the driver's order.
struct Device {
  int index = 0;
  bool software = false;
  std::string name;  // EGL_EXT_device_query_name's renderer, else the device file, else "unnamed"
};
// Devices of the EGL device platform; empty when the platform is missing. Throws Error when there is no EGL library.
std::vector<Device> list_devices();

struct Limits {
  int texture_size = 0;       // side of a 2D texture
  int array_layers = 0;       // layers of an array texture
  int64_t storage_block = 0;  // bytes of one shader storage block
  int storage_alignment = 1;  // bytes, of a range bound as shader storage
  int texel_buffer = 0;       // texels of a buffer texture
  int uniform_block = 0;      // bytes of one uniform block
  int viewport_size = 0;      // pixels, the smaller side
  int samples = 0;            // most samples a pixel of a multisampled colour and depth texture
};

// Bytes of the objects alive on a context, counted when storage is allocated; every mip level and layer is counted.
struct Allocated {
  uint64_t buffer_bytes = 0;
  uint64_t texture_bytes = 0;
};

// What outlives a context: objects hold it, so that one that is destroyed after its context calls no GL.
struct ContextState {
  bool alive = false;
  std::function<void()> make_current;
  Allocated allocated;
};

// Makes a context current for a scope, and the one before it afterwards. The state must be alive.
class CurrentScope {
 public:
  explicit CurrentScope(const ContextState& state);
  ~CurrentScope();
  CurrentScope(const CurrentScope&) = delete;
  CurrentScope& operator=(const CurrentScope&) = delete;

 private:
  const ContextState* before_ = nullptr;
};

// No context is current on this thread for a scope, and the one before it afterwards: a window system that makes its
// own context current refuses to while another interface's is.
class NoCurrentScope {
 public:
  NoCurrentScope();
  ~NoCurrentScope();
  NoCurrentScope(const NoCurrentScope&) = delete;
  NoCurrentScope& operator=(const NoCurrentScope&) = delete;

 private:
  const ContextState* before_ = nullptr;
};

// While alive, its thread's current context. Neither copied nor moved: everything drawn holds a reference to it.
// Several may live in one process; objects make their own context current when they are destroyed.
class Context {
 public:
  // Headless. Throws Error that names the step that failed, the EGL error and the number of devices.
  explicit Context(const ContextOptions& options = {});
  ~Context();
  Context(const Context&) = delete;
  Context& operator=(const Context&) = delete;

  void make_current() const;

  const std::string& vendor() const { return vendor_; }
  const std::string& renderer() const { return renderer_; }
  const std::string& version() const { return version_; }
  // "EGL device 0 (software)", "EGL surfaceless": how the context was made.
  const std::string& platform() const { return platform_; }
  // True for a software rasteriser: its frame times say nothing of a GPU.
  bool is_software() const { return software_; }
  // What went wrong on the way to this context (a GPU that would not start); one line each.
  const std::vector<std::string>& warnings() const { return warnings_; }
  const Limits& limits() const { return limits_; }
  bool has_extension(const std::string& name) const;

  // Bytes allocated by live objects of this context.
  const Allocated& allocated() const { return state_->allocated; }
  // Errors and undefined behaviour that the driver reported since the last call; only a debug context collects them.
  std::vector<std::string> take_debug_messages();
  // Waits until everything submitted is done.
  void finish() const;

  const std::shared_ptr<ContextState>& state() const { return state_; }

 private:
  void read_capabilities(bool debug);

  struct Egl;
  std::unique_ptr<Egl> egl_;
  std::shared_ptr<ContextState> state_ = std::make_shared<ContextState>();
  std::string vendor_, renderer_, version_, platform_;
  bool software_ = false;
  std::vector<std::string> warnings_;
  Limits limits_;
  std::vector<std::string> debug_messages_;
};

}  // namespace crowdbench::gl
