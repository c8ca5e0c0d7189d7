#version 450 core
// A draw whose cost grows with `loops` and that no compiler can fold: for the self-test of the GPU timer.
#include "renderers/shaders/bindings.shared.h"

layout(location = 0) in vec2 v_ndc;
layout(location = CB_LOCATION_COUNT) uniform uint loops;
layout(location = 0) out vec4 out_colour;

void main() {
  vec2 z = v_ndc;
  for (uint i = 0u; i < loops; ++i) z = vec2(z.x * z.x - z.y * z.y, 2.0 * z.x * z.y) * 0.5 + v_ndc * 0.5;
  out_colour = vec4(z, 0.0, 1.0);
}
