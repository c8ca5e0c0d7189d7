#include "renderers/frame/frame_state.h"

namespace crowdbench::renderers {

void begin_frame(const scene::Frame& frame, bool ids, bool reversed) {
  glClipControl(GL_LOWER_LEFT, GL_ZERO_TO_ONE);
  glEnable(GL_FRAMEBUFFER_SRGB);
  glEnable(GL_DEPTH_TEST);
  glDepthFunc(reversed ? GL_GREATER : GL_LESS);
  glDepthMask(GL_TRUE);
  glDisable(GL_BLEND);
  glDisable(GL_CULL_FACE);
  glFrontFace(GL_CCW);
  glCullFace(GL_BACK);
  glClearBufferfv(GL_COLOR, 0, &frame.background.x);
  if (ids) {
    const GLuint nobody[4] = {0, 0, 0, 0};
    glClearBufferuiv(GL_COLOR, 1, nobody);
  }
  const float farthest = reversed ? 0.0F : 1.0F;
  glClearBufferfv(GL_DEPTH, 0, &farthest);
}

}  // namespace crowdbench::renderers
