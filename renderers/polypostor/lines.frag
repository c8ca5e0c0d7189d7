#version 450 core
#include "renderers/shaders/output.glsl"
layout(location = 0) flat in vec3 v_colour;
layout(location = 1) flat in uint v_id;
void main() { write_output(v_colour, v_id); }
