#version 450 core
// Three tiles, each lit with its own normals and coloured by its own material ids; what they show is averaged by weight
// and coverage, and drawn where at least half of the weight covers.
#include "renderers/flat/flat_maps.glsl"
#include "renderers/flat/flat_table.glsl"
#if CB_PARALLAX > 0
#include "renderers/flat/flat_parallax.glsl"
#endif
#include "renderers/shaders/output.glsl"
#include "renderers/shaders/shading.glsl"

layout(location = 0) in vec3 v_texel[3];
layout(location = 3) flat in vec4 v_bounds[3];
layout(location = 6) flat in vec4 v_light[3];
layout(location = 9) flat in vec3 v_weights;
layout(location = 10) flat in uvec2 v_outfit_id;
#ifdef CB_NAILBOARD
layout(location = 11) flat in vec4 v_depth[3];
layout(location = 14) flat in float v_texel_height;
#endif
#if CB_PARALLAX > 0
layout(location = 15) flat in vec3 v_parallax[6];
#endif

void main() {
  float coverage = 0.0;
  float total = 0.0;
  float depth = 0.0;
  vec3 colour = vec3(0.0);
#ifdef CB_TEXELS
  vec2 read_at[3];
#endif
  for (int i = 0; i < 3; ++i) {
    vec2 at = v_texel[i].xy / v_texel[i].z;
#if CB_PARALLAX > 0
    float rise;
    at = met_at(at, v_light[i].w, ParallaxView(v_parallax[2 * i], v_parallax[2 * i + 1]), v_bounds[i], table.centre.w, rise);
#endif
#ifdef CB_TEXELS
    read_at[i] = at;
#endif
    vec3 texel = vec3(clamp(at, v_bounds[i].xy, v_bounds[i].zw), v_light[i].w);
    vec4 albedo = texture(albedo_map, texel);
    vec4 surface = surface_at(texel);
    float weight = texel.xy == at ? v_weights[i] : 0.0;
    coverage += weight * albedo.a;
    weight *= albedo.a < 0.5 ? 0.0 : 1.0;
    total += weight;
#ifdef CB_FLOOR
    colour += weight * (albedo.rgb + surface.rgb + emission_at(texel));
#else
    uint slot = uint(surface.b * 255.0 + 0.5);
    vec2 n = (surface.rg * 255.0 - 128.0) / 127.0;
    float n_z = sqrt(max(0.0, 1.0 - dot(n, n)));
    float lambert = max(0.0, dot(vec3(n, n_z), v_light[i].xyz));
    vec3 lit = shade_lit(albedo.rgb * albedo.rgb, lambert, slot & 0x7fu, v_outfit_id.x, slot > 0x7fu, vec3(0.0));
    colour += weight * (lit + emission_at(texel) * uintBitsToFloat(table.layers.z));
#endif
#ifdef CB_NAILBOARD
    vec2 s = (surface.rg * 255.0 - 128.0) / 127.0;
    vec2 within = fract(at * vec2(textureSize(surface_map, 0).xy)) - 0.5;
    float height = (surface.a * 255.0 - 128.0) / 127.0 -
                   v_texel_height * dot(s, within) / max(sqrt(max(0.0, 1.0 - dot(s, s))), 0.35);
    depth += weight * dot(v_depth[i], vec4(at, 1.0, height));
#endif
  }
  if (coverage < 0.5 || total == 0.0) discard;
#ifdef CB_NAILBOARD
  gl_FragDepth = frame.projection[3][2] / max(depth / total, frame.lens.x) - frame.projection[2][2];
#endif
#ifdef CB_TEXELS
  // Of the view that counts for most.
  int most = v_weights.x >= max(v_weights.y, v_weights.z) ? 0 : v_weights.y >= v_weights.z ? 1 : 2;
  vec2 there = read_at[most] * vec2(textureSize(albedo_map, 0).xy);
  write_output(vec3(there * exp2(table.scale.w), table.scale.w), v_outfit_id.y);
#else
  write_output(colour / total, v_outfit_id.y);
#endif
}
