// Stage: a crowd in front of a camera, posed tick by tick for whatever draws it.
#pragma once
#include <cstdint>
#include <optional>

#include "bench/stage/stage_scenario.h"
#include "renderers/frame/capture.h"
#include "renderers/gl/context.h"

namespace crowdbench::bench {

// One cast with its renderer, a crowd and a camera, and the posed frame of the latest tick asked for. What it refers to
// must outlive it.
class Stage {
 public:
  Stage(gl::Context& context, const scene::Cast& cast);
  // What frames show from now on, from its camera and without a ground. `staged` must stay where it is.
  void show(const Staged& staged);
  const scene::Frame& frame(uint64_t tick);  // posed anew when another tick was the latest
  const scene::Frame& latest() const { return frame_; }
  renderers::Renderer& renderer() { return renderer_; }
  gl::Context& context() { return context_; }
  const scene::Cast& cast() const { return cast_; }

 private:
  gl::Context& context_;
  const scene::Cast& cast_;
  const Staged* staged_ = nullptr;
  renderers::Renderer renderer_;
  scene::Frame frame_;
  std::optional<uint64_t> tick_;
};

}  // namespace crowdbench::bench
