// Other depth buffers than the one that every picture is drawn with (Target: 32-bit float, reversed): what a format and
// a direction keep of depths, and a frame drawn with them.
#pragma once
#include "renderers/frame/capture.h"

namespace crowdbench::renderers {

enum class DepthFormat { fixed16, fixed24, float32 };

struct DepthStorage {
  DepthFormat format = DepthFormat::float32;
  bool reversed = true;  // near is 1 and far 0; else near is 0 and far 1
};

// z = offset + slope / d, for d in metres along the view axis; z in [0, 1] between the planes.
struct StoredDepth {
  double offset = 0;
  double slope = 0;
  double at(double depth) const { return offset + slope / depth; }
  double metres(double z) const { return slope / (z - offset); }  // infinite or below 0: beyond all depths
};
StoredDepth stored_depth(const scene::Camera& camera, const DepthStorage& storage);
// How far apart neighbouring values about z are. fixed: 1 / (2^bits - 1) (OpenGL 4.5, 2.3.5); float: 2^(e - 23) for
// 2^e <= z < 2^(e + 1) (IEEE 754).
double stored_step(const DepthStorage& storage, double z);

// As Renderer::capture, one sample a pixel and without the ground; no `linear`. Depths are infinite where nothing is
// drawn, and where what is drawn is stored as infinitely far. Throws Error where the representation sets a depth
// function of its own, which knows one direction alone.
Capture capture_stored(gl::Context& context, Renderer& renderer, const scene::Frame& frame,
                       Representation& representation, const DepthStorage& storage);

}  // namespace crowdbench::renderers
