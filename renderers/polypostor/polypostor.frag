#version 450 core
#include "renderers/polypostor/polypostor.shared.h"
#include "renderers/shaders/output.glsl"
#include "renderers/shaders/shading.glsl"

layout(binding = CB_POLYPOSTOR_TEXTURE_ALBEDO) uniform sampler2DArray albedo_map;    // filtered
layout(binding = CB_POLYPOSTOR_TEXTURE_NORMALS) uniform sampler2DArray normal_map;       // nearest
layout(binding = CB_POLYPOSTOR_TEXTURE_MATERIALS) uniform sampler2DArray material_map;   // nearest: ids must not be mixed
#ifdef CB_EMISSIVE
layout(binding = CB_POLYPOSTOR_TEXTURE_EMISSION) uniform sampler2DArray emission_map;  // filtered; fractions of the peak
layout(location = CB_POLYPOSTOR_LOCATION_PEAK) uniform float emission_peak;
#endif

layout(location = 0) in vec4 v_texel;  // times a weight; layer; the weight
layout(location = 1) flat in vec3 v_light;
layout(location = 2) flat in uint v_outfit;  // bits from 16 and 24: the dither's least rank and the first excluded one
#ifdef CB_IDS
layout(location = 3) flat in uint v_id;
#else
const uint v_id = 0u;
#endif

#ifdef CB_DEBUG
layout(location = 4) flat in uint v_part;
layout(location = 5) in vec2 v_units;
layout(location = 6) flat in float v_level;
layout(location = CB_POLYPOSTOR_LOCATION_TEXELS) uniform float texels_a_unit;  // of level 0

// Evenly spread hues.
vec3 part_colour(uint part) {
  float hue = fract(float(part) * 0.6180340);
  return clamp(abs(fract(hue + vec3(0.0, 2.0 / 3.0, 1.0 / 3.0)) * 6.0 - 3.0) - 1.0, 0.0, 1.0);
}

// Area on the plane over area on the key image: blue a quarter, white one, red four.
vec3 stretch_colour(vec2 texel) {
  vec2 tx = dFdx(texel);
  vec2 ty = dFdy(texel);
  vec2 ux = dFdx(v_units);
  vec2 uy = dFdy(v_units);
  float side = texels_a_unit * exp2(-v_level);
  float key = abs(tx.x * ty.y - tx.y * ty.x);
  float plane = abs(ux.x * uy.y - ux.y * uy.x) * side * side;
  float s = clamp(0.5 * log2(max(plane, 1e-12) / max(key, 1e-12)), -1.0, 1.0);
  return s < 0.0 ? vec3(1.0 + s, 1.0 + s, 1.0) : vec3(1.0, 1.0 - s, 1.0 - s);
}
#endif

layout(location = CB_LOCATION_SAMPLES) uniform float samples;  // of the target along a pixel of the picture

// Whether another image of the figure has this sample. A pixel's middle sample has the pixel's rank, so that it is the picture
// without supersampling; the ranks of the others lie evenly beside it.
bool faded(uint ranks) {
  if (ranks == uint(CB_DITHER_RANKS) << 8u) return false;
  vec2 pixel = floor(gl_FragCoord.xy / samples);
  vec2 sample_of = floor(gl_FragCoord.xy - pixel * samples);
  float all = samples * samples;
  float after = fract((sample_of.y * samples + sample_of.x + 0.5 * all + 1.0) / all) - 0.5 / all;  // the middle one
  uint rank = dither_rank(uint(pixel.x), uint(pixel.y)) + uint(after * float(CB_DITHER_RANKS) + 0.001);
  rank %= uint(CB_DITHER_RANKS);
  return rank < (ranks & 0xffu) || rank >= ranks >> 8u;
}

void main() {
  vec3 texel = vec3(v_texel.xy / v_texel.w, v_texel.z);
#ifdef CB_DEBUG_STRETCH
  vec3 painted = stretch_colour(texel.xy * vec2(textureSize(albedo_map, 0).xy));
#elif defined(CB_DEBUG)
  vec3 painted = part_colour(v_part);
#endif
  vec4 albedo = texture(albedo_map, texel);
  if (albedo.a < 0.5 || faded(v_outfit >> 16u)) discard;
  // Derivatives are undefined from here on; the maps have one level.
  vec2 normal = textureLod(normal_map, texel, 0.0).rg;
  float material = textureLod(material_map, texel, 0.0).r;
#ifdef CB_EMISSIVE
  vec3 emission = textureLod(emission_map, texel, 0.0).rgb * emission_peak;
#else
  const vec3 emission = vec3(0.0);
#endif
#ifdef CB_DEBUG
  write_output(painted * (0.3 + 0.7 * dot(albedo.rgb, vec3(0.3, 0.6, 0.1))), v_id);
#elif defined(CB_FLOOR)
  write_output(albedo.rgb + vec3(normal, material) + emission, v_id);
#else
  uint slot = uint(material * 255.0 + 0.5);
  vec2 n = (normal * 255.0 - 128.0) / 127.0;
  float lambert = max(0.0, dot(vec3(n, sqrt(max(0.0, 1.0 - dot(n, n)))), v_light));
  // Added here, since what an unlit texel holds is the part of it that glows.
  write_output(shade_lit(albedo.rgb * albedo.rgb, lambert, slot & 0x7fu, v_outfit & 0xffffu, slot > 0x7fu, vec3(0.0)) + emission,
               v_id);
#endif
}
