#version 450 core
#include "renderers/shaders/output.glsl"

layout(location = 0) flat in vec3 v_colour;
layout(location = 1) flat in vec4 v_ellipse;
layout(location = 2) flat in vec2 v_centre;
#ifdef CB_IDS
layout(location = 3) flat in uint v_id;
#endif

void main() {
  // Not gl_PointCoord, which some drivers give of the pixel's centre for all of its samples.
  vec2 at = gl_FragCoord.xy - v_centre;
  vec2 circle = vec2(dot(v_ellipse.xy, at), dot(v_ellipse.zw, at));
  if (dot(circle, circle) > 1.0) discard;
#ifdef CB_IDS
  uint id = v_id;
#else
  uint id = 0u;
#endif
  write_output(v_colour, id);
}
