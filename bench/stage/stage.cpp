#include "bench/stage/stage.h"

#include <cassert>

namespace crowdbench::bench {

Stage::Stage(gl::Context& context, const scene::Cast& cast)
    : context_(context), cast_(cast), renderer_(context, cast) {}

void Stage::show(const Staged& staged) {
  staged_ = &staged;
  tick_.reset();
}

const scene::Frame& Stage::frame(uint64_t tick) {
  assert(staged_ != nullptr);
  if (tick_ != tick) {
    frame_ = scene::make_frame(staged_->scenario, cast_, staged_->crowd, staged_->camera, tick);
    frame_.ground = false;
    tick_ = tick;
  }
  return frame_;
}

}  // namespace crowdbench::bench
