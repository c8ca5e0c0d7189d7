#version 450 core
#include "renderers/flat/flat.shared.h"
#include "renderers/shaders/output.glsl"
#include "renderers/shaders/shading.glsl"

layout(binding = CB_FLAT_TEXTURE_ALBEDO) uniform sampler2DArray albedo_map;    // filtered
layout(binding = CB_FLAT_TEXTURE_SURFACE) uniform sampler2DArray surface_map;  // nearest: ids must not be mixed

layout(location = 0) in vec3 v_texel;
layout(location = 1) flat in vec3 v_light;
layout(location = 2) flat in uint v_outfit;
#ifdef CB_IDS
layout(location = 3) flat in uint v_id;
#else
const uint v_id = 0u;
#endif

void main() {
  vec4 albedo = texture(albedo_map, v_texel);
  if (albedo.a < 0.5) discard;
  vec4 surface = texture(surface_map, v_texel);
#ifdef CB_FLOOR
  write_output(albedo.rgb + surface.rgb, v_id);
#else
  uint part = uint(surface.b * 255.0 + 0.5);
  vec2 n = (surface.rg * 255.0 - 128.0) / 127.0;
  float lambert = max(0.0, dot(vec3(n, sqrt(max(0.0, 1.0 - dot(n, n)))), v_light));
  write_output(shade_lit(albedo.rgb * albedo.rgb, lambert, part & 0x7fu, v_outfit, part > 0x7fu, vec3(0.0)), v_id);
#endif
}
