#version 450 core
#include "renderers/flat/flat_maps.glsl"
#include "renderers/flat/flat_table.glsl"
#if CB_BETWEEN > 0
#include "renderers/flat/flat_between.glsl"
#endif
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
#if CB_CORNERS == 3 || CB_PARALLAX > 0 || CB_BETWEEN > 0
layout(location = 6) flat in vec4 v_bounds;
#endif
#if CB_PARALLAX > 0
layout(location = 7) flat in vec3 v_parallax[2];
#endif
#ifdef CB_SLICES
layout(location = 9) flat in vec2 v_interval;
layout(location = 10) in float v_plane;
#endif
#if CB_BETWEEN > 0
layout(location = 9) flat in vec4 v_between[4];
#endif

// What a texel shows: linear light.
vec3 colour_of(vec4 albedo, vec4 surface, vec3 texel) {
#ifdef CB_FLOOR
  return albedo.rgb + surface.rgb + emission_at(texel);
#else
  vec2 n = surface.rg * (255.0 / 127.0) - 128.0 / 127.0;
  float n_z = sqrt(max(0.0, 1.0 - dot(n, n)));
  uint slot = uint(surface.b * 255.0 + 0.5);
  float lambert = max(0.0, dot(vec3(n, n_z), uintBitsToFloat(v_agent.xyz)));
  uint outfit = v_agent.w >> CB_FLAT_LAYER_BITS;
  vec3 lit = shade_lit(albedo.rgb * albedo.rgb, lambert, slot & 0x7fu, outfit, slot > 0x7fu, vec3(0.0));
  // Added here, since what an unlit texel holds is the part of it that glows.
  return lit + emission_at(texel) * uintBitsToFloat(table.layers.z);
#endif
}

void main() {
  vec2 at = v_texel;
  float layer = float(v_agent.w & ((1u << CB_FLAT_LAYER_BITS) - 1u));
#if CB_BETWEEN > 0
  Between between = Between(v_between[0], v_between[1], v_between[2], v_between[3]);
#endif
#if CB_PARALLAX > 0
  ParallaxView view = ParallaxView(v_parallax[0], v_parallax[1]);
  float rise;
#if CB_BETWEEN > 0
  at = met_at(at, layer, view, v_bounds, table.centre.w, between, rise);
#else
  at = met_at(at, layer, view, v_bounds, table.centre.w, rise);
#endif
#endif
#if CB_CORNERS == 3 || CB_PARALLAX > 0 || CB_BETWEEN > 0
  vec4 bounds = v_bounds;
#endif
#if CB_BETWEEN > 0
  InFrames in_both = in_frames(at, between);
  at = in_both.nearer;
#if CB_BETWEEN == 2
  if (in_both.far_weight > in_both.near_weight) {  // the nearer frame hides what is here
    at = in_both.farther;
    bounds = between.other_bounds;
    layer = between.other.z;
  }
#endif
#endif
#if CB_CORNERS == 3 || CB_PARALLAX > 0 || CB_BETWEEN > 0
  at = clamp(at, bounds.xy, bounds.zw);  // a triangle reaches beyond its tile; the gutter is empty
#endif
  vec3 texel = vec3(at, layer);
  vec4 albedo = texture(albedo_map, texel);
#if CB_BETWEEN == 1 || CB_BETWEEN == 3
  vec3 other_texel = vec3(clamp(in_both.farther, between.other_bounds.xy, between.other_bounds.zw), between.other.z);
  vec4 other_albedo = texture(albedo_map, other_texel);
  vec2 weights = vec2(in_both.near_weight, in_both.far_weight);
  if (in_both.cover * dot(weights, vec2(albedo.a, other_albedo.a)) < 0.5 * (weights.x + weights.y)) discard;
  weights *= step(0.5, vec2(albedo.a, other_albedo.a));
  bool other_counts = weights.y > weights.x;
#elif CB_BETWEEN == 2
  if (in_both.cover * albedo.a < 0.5) discard;
#else
  if (albedo.a < 0.5) discard;
#endif
#ifdef CB_LIST
  write_output(albedo.rgb * albedo.rgb, v_id);
#else
  vec4 surface = surface_at(texel);
#ifdef CB_SLICES
  float over = (surface.a * 255.0 - 128.0) / 127.0 * table.centre.w - v_plane;
  if (over < v_interval.x || over >= v_interval.y) discard;
#endif
#if CB_BETWEEN == 1 || CB_BETWEEN == 3
  vec4 other_surface = surface_at(other_texel);
#endif
#if defined(CB_NAILBOARD) && CB_PARALLAX > 0
  // What rises from the polygon to the eye's height is at the eye.
  float toward = rise / max(view.eye.z - dot(view.plane, vec3(v_texel, 1.0)), 1e-3);
  float depth = max((1.0 - toward) / gl_FragCoord.w, frame.lens.x);
  gl_FragDepth = frame.projection[3][2] / depth - frame.projection[2][2];
#elif defined(CB_NAILBOARD)
  // The point of the capture plane moved along the view's axis by the stored depth, through the projection in force.
  // Within a texel the surface slopes as its normal says; silhouettes would slope without end.
#if CB_BETWEEN == 1 || CB_BETWEEN == 3
  vec4 shown = other_counts ? other_surface : surface;
  vec2 shown_at = other_counts ? other_texel.xy : at;
#else
  vec4 shown = surface;
  vec2 shown_at = at;
#endif
  vec2 n = shown.rg * (255.0 / 127.0) - 128.0 / 127.0;
  vec2 within = fract(shown_at * vec2(textureSize(surface_map, 0).xy)) - 0.5;
  float height = (shown.a * 255.0 - 128.0) / 127.0 -
                 v_texel_height * dot(n, within) / max(sqrt(max(0.0, 1.0 - dot(n, n))), 0.35);
  float depth = max(v_depth + v_depth_range * height, frame.lens.x);
  gl_FragDepth = frame.projection[3][2] / depth - frame.projection[2][2];
#endif
#ifdef CB_TEXELS
  vec2 place = at * vec2(textureSize(albedo_map, 0).xy);
  write_output(vec3(place * exp2(table.scale.w), table.scale.w), v_id);
#elif CB_BETWEEN == 1 || CB_BETWEEN == 3
  vec3 colour = weights.x > 0.0 ? weights.x * colour_of(albedo, surface, texel) : vec3(0.0);
  if (weights.y > 0.0) colour += weights.y * colour_of(other_albedo, other_surface, other_texel);
  write_output(colour / max(weights.x + weights.y, 1e-6), v_id);
#else
  write_output(colour_of(albedo, surface, texel), v_id);
#endif
#endif
}
