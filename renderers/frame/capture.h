// Capture: one frame drawn and read back, the input of everything that is compared.
#pragma once
#include <memory>

#include "core/image.h"
#include "renderers/representation.h"
#include "scene/cast/cast.h"

namespace crowdbench::renderers {

// All width x height, row 0 on top.
struct Capture {
  Image8 colour;  // RGBA, sRGB-encoded, alpha 255
  ImageF linear;  // RGBA, linear light; empty unless asked for
  ImageF depth;   // metres along the view axis (eye space), +inf where empty
  ImageU32 ids;   // agent index + 1, 0 = nothing
  bool operator==(const Capture&) const = default;
};

struct CaptureOptions {
  bool linear = false;  // also fill Capture::linear
};

// A target of fixed size: RGBA8 sRGB colour (or RGBA32F), optional R32UI ids, 32-bit float depth. With Pass::samples
// above 1 it has no ids, and reads back no depth: a Renderer averages its colours when it has drawn there.
class Target {
 public:
  Target(gl::Context& context, int width, int height, Pass pass);
  ~Target();
  Target(Target&&) noexcept;
  Target& operator=(Target&&) noexcept;
  int width() const;
  int height() const;
  const Pass& pass() const;
  void bind() const;
  unsigned framebuffer() const;  // GL name, for blits: one sample a pixel
  Capture read() const;  // waits for the GPU; depth in metres holds for the last frame that a Renderer drew here

 private:
  friend class Renderer;
  void resolve() const;
  struct State;
  std::unique_ptr<State> state_;
};

// Draws frames of one cast: uploads the frame, clears, draws ground where asked, and the representation.
class Renderer {
 public:
  Renderer(gl::Context& context, const scene::Cast& cast);
  ~Renderer();
  Renderer(const Renderer&) = delete;
  Renderer& operator=(const Renderer&) = delete;
  // From a frame in hand to submitted commands: per-frame CPU choice, upload, clear, draw. Does not wait; `finish`
  // does. target: frame.width x frame.height pixels, or a whole number of samples a pixel along both.
  void draw(const scene::Frame& frame, Representation& representation, const Target& target);
  void finish();
  // Colours as Frame::antialiasing says. Throws Error where the driver has no such samples.
  Capture capture(const scene::Frame& frame, Representation& representation, const CaptureOptions& options = {});
  // Bytes of the pose banks and frame buffers that all representations share.
  uint64_t shared_bytes() const;
  // The same frame's resources, for a representation drawn outside of draw() (bakes, tests).
  FrameResources& resources();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace crowdbench::renderers
