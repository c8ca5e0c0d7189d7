#version 450 core
#include "renderers/flat/flat_maps.glsl"
#include "renderers/flat/flat_table.glsl"
#if CB_PARALLAX > 0
#include "renderers/flat/flat_parallax.glsl"
#endif
#include "renderers/shaders/output.glsl"
#include "renderers/shaders/shading.glsl"

layout(location = 0) in vec2 v_texel;
layout(location = 1) flat in uvec4 v_agent;
#ifdef CB_IDS
layout(location = 2) flat in uint v_id;
#else
const uint v_id = 0u;
#endif
#ifdef CB_NAILBOARD
layout(location = 3) in float v_depth;
layout(location = 4) flat in float v_depth_range;
layout(location = 5) flat in float v_texel_height;
#endif
#if CB_CORNERS == 3 || CB_PARALLAX > 0
layout(location = 6) flat in vec4 v_bounds;
#endif
#if CB_PARALLAX > 0
layout(location = 7) flat in vec3 v_parallax[2];
#endif
#ifdef CB_SLICES
layout(location = 9) flat in vec2 v_interval;
layout(location = 10) in float v_plane;
#endif

void main() {
  vec2 at = v_texel;
  float layer = float(v_agent.w & ((1u << CB_FLAT_LAYER_BITS) - 1u));
#if CB_PARALLAX > 0
  ParallaxView view = ParallaxView(v_parallax[0], v_parallax[1]);
  float rise;
  at = met_at(at, layer, view, v_bounds, table.centre.w, rise);
#endif
#if CB_CORNERS == 3 || CB_PARALLAX > 0
  at = clamp(at, v_bounds.xy, v_bounds.zw);  // a triangle reaches beyond its tile; the gutter is empty
#endif
  vec3 texel = vec3(at, layer);
  vec4 albedo = texture(albedo_map, texel);
  if (albedo.a < 0.5) discard;
#ifdef CB_LIST
  write_output(albedo.rgb * albedo.rgb, v_id);
#else
  vec4 surface = surface_at(texel);
#ifdef CB_SLICES
  float over = (surface.a * 255.0 - 128.0) / 127.0 * table.centre.w - v_plane;
  if (over < v_interval.x || over >= v_interval.y) discard;
#endif
  vec2 n = surface.rg * (255.0 / 127.0) - 128.0 / 127.0;
  float n_z = sqrt(max(0.0, 1.0 - dot(n, n)));
#if defined(CB_NAILBOARD) && CB_PARALLAX > 0
  // What rises from the polygon to the eye's height is at the eye.
  float toward = rise / max(view.eye.z - dot(view.plane, vec3(v_texel, 1.0)), 1e-3);
  float depth = max((1.0 - toward) / gl_FragCoord.w, frame.lens.x);
  gl_FragDepth = frame.projection[3][2] / depth - frame.projection[2][2];
#elif defined(CB_NAILBOARD)
  // The point of the capture plane moved along the view's axis by the stored depth, through the projection in force.
  // Within a texel the surface slopes as its normal says; silhouettes would slope without end.
  vec2 within = fract(v_texel * vec2(textureSize(surface_map, 0).xy)) - 0.5;
  float height = (surface.a * 255.0 - 128.0) / 127.0 - v_texel_height * dot(n, within) / max(n_z, 0.35);
  float depth = max(v_depth + v_depth_range * height, frame.lens.x);
  gl_FragDepth = frame.projection[3][2] / depth - frame.projection[2][2];
#endif
#if defined(CB_TEXELS)
#if CB_PARALLAX > 0
  vec2 place = at * vec2(textureSize(albedo_map, 0).xy);
#else
  vec2 place = v_texel * vec2(textureSize(albedo_map, 0).xy);
#endif
  write_output(vec3(place * exp2(table.scale.w), table.scale.w), v_id);
#elif defined(CB_FLOOR)
  write_output(albedo.rgb + surface.rgb + emission_at(texel), v_id);
#else
  uint slot = uint(surface.b * 255.0 + 0.5);
  float lambert = max(0.0, dot(vec3(n, n_z), uintBitsToFloat(v_agent.xyz)));
  uint outfit = v_agent.w >> CB_FLAT_LAYER_BITS;
  vec3 lit = shade_lit(albedo.rgb * albedo.rgb, lambert, slot & 0x7fu, outfit, slot > 0x7fu, vec3(0.0));
  // Added here, since what an unlit texel holds is the part of it that glows.
  write_output(lit + emission_at(texel) * uintBitsToFloat(table.layers.z), v_id);
#endif
#endif
}
