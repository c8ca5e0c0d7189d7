#version 450 core
// Lines over a picture (debug=wire, debug=lines): places are computed already.
layout(location = 0) in vec4 in_clip;
layout(location = 1) in vec4 in_colour;  // linear; a: the id's bits
layout(location = 0) flat out vec3 v_colour;
layout(location = 1) flat out uint v_id;
void main() {
  gl_Position = in_clip;
  v_colour = in_colour.rgb;
  v_id = floatBitsToUint(in_colour.a);
}
