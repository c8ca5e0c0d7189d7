#version 450 core
#include "renderers/perjoint/perjoint_table.glsl"
#include "renderers/shaders/output.glsl"
#include "renderers/shaders/shading.glsl"

layout(binding = CB_PERJOINT_TEXTURE_ALBEDO) uniform sampler2DArray albedo_map;    // filtered
layout(binding = CB_PERJOINT_TEXTURE_SURFACE) uniform sampler2DArray surface_map;  // nearest: ids must not be mixed
#ifdef CB_EMISSIVE
layout(binding = CB_PERJOINT_TEXTURE_EMISSION) uniform sampler2DArray emission_map;  // filtered
#endif

layout(location = 0) in vec3 v_texel;
layout(location = 1) flat in vec4 v_light;
#ifdef CB_IDS
layout(location = 2) flat in uint v_id;
#else
const uint v_id = 0u;
#endif
#ifdef CB_STORED_DEPTH
layout(location = 3) in float v_depth;
layout(location = 4) flat in float v_depth_range;
layout(location = 5) flat in float v_texel_height;
#endif

vec3 colour_of(vec4 albedo, vec4 surface, vec3 emission) {
#ifdef CB_FLOOR
  return albedo.rgb + surface.rgb + emission;
#else
  vec2 n = surface.rg * (255.0 / 127.0) - 128.0 / 127.0;
  float n_z = sqrt(max(0.0, 1.0 - dot(n, n)));
  uint slot = uint(surface.b * 255.0 + 0.5);
  float lambert = max(0.0, dot(vec3(n, n_z), v_light.xyz));
  vec3 lit = shade_lit(albedo.rgb * albedo.rgb, lambert, slot & 0x7fu, uint(v_light.w), slot > 0x7fu, vec3(0.0));
  return lit + emission * table.scale.w;
#endif
}

void main() {
  vec4 albedo = texture(albedo_map, v_texel);
  if (albedo.a < 0.5) discard;
  // One level, and derivatives are undefined where a neighbour was discarded: hence textureLod.
  vec4 surface = textureLod(surface_map, v_texel, 0.0);
  vec3 emission = vec3(0.0);
#ifdef CB_EMISSIVE
  emission = textureLod(emission_map, v_texel, 0.0).rgb;
#endif
#ifdef CB_STORED_DEPTH
  // Within a texel the surface slopes as its normal says; silhouettes would slope without end.
  vec2 n = surface.rg * (255.0 / 127.0) - 128.0 / 127.0;
  vec2 within = fract(v_texel.xy * vec2(textureSize(surface_map, 0).xy)) - 0.5;
  float height = (surface.a * 255.0 - 128.0) / 127.0 -
                 v_texel_height * dot(n, within) / max(sqrt(max(0.0, 1.0 - dot(n, n))), 0.35);
  float depth = max(v_depth + v_depth_range * height, frame.lens.x);
  gl_FragDepth = frame.projection[3][2] / depth - frame.projection[2][2];
#endif
  write_output(colour_of(albedo, surface, emission), v_id);
}
