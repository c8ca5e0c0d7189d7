// Shading by sample, for what finds its outline in the fragment shader: with one fragment a pixel, a discard would cut
// whole pixels, however many samples a pixel has.
#pragma once
#include <epoxy/gl.h>

namespace crowdbench::gl {

// While alive, each sample of a multisampled target runs the fragment shader for itself, at its own place. Does nothing
// for one sample a pixel.
class PerSampleScope {
 public:
  explicit PerSampleScope(int samples) : on_(samples > 1) {
    if (!on_) return;
    glEnable(GL_SAMPLE_SHADING);
    glMinSampleShading(1.0F);
  }
  ~PerSampleScope() {
    if (on_) glDisable(GL_SAMPLE_SHADING);
  }
  PerSampleScope(const PerSampleScope&) = delete;
  PerSampleScope& operator=(const PerSampleScope&) = delete;

 private:
  bool on_;
};

}  // namespace crowdbench::gl
