#version 450 core
// What was lit when the tile was drawn: nothing is reckoned here but its outline.
#include "renderers/dynamic/dynamic.shared.h"
#include "renderers/shaders/output.glsl"

layout(binding = CB_DYNAMIC_TEXTURE_PAGE) uniform sampler2D page;  // linear light, 0 where nothing was drawn; alpha 1

layout(location = 0) in vec2 v_texel;
#ifdef CB_IDS
layout(location = 1) flat in uint v_id;
#else
const uint v_id = 0u;
#endif

void main() {
  vec4 colour = textureLod(page, v_texel, 0.0);
  if (colour.a < 0.5) discard;
  write_output(colour.rgb / colour.a, v_id);
}
