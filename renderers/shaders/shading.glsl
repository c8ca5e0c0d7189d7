// The one shading of every representation, so that a difference between two pictures is never a difference in shading.
// Linear light throughout; the sRGB curve comes at the very end, in output_colour().
#include "renderers/shaders/frame.glsl"

layout(binding = CB_TEXTURE_OUTFITS) uniform samplerBuffer outfits;

// The outfit's colour factor for a body slot; slots beyond CB_OUTFIT_SLOTS keep their own colour.
vec3 outfit_colour(uint slot, uint outfit) {
  return slot < uint(CB_OUTFIT_SLOTS) ? texelFetch(outfits, int(outfit) * CB_OUTFIT_SLOTS + int(slot)).rgb : vec3(1.0);
}

// albedo: linear, before the outfit. lambert: cosine between the normal and the light, 0 where the light is behind.
// Returns linear light.
vec3 shade_lit(vec3 albedo, float lambert, uint slot, uint outfit, bool unlit, vec3 emissive) {
  vec3 base = albedo * outfit_colour(slot, outfit);
  if (unlit) return base;
  return base * (frame.light.x + frame.light.y * lambert) + emissive;
}

// normal: world axes, any length but zero.
vec3 shade(vec3 albedo, vec3 normal, uint slot, uint outfit, bool unlit, vec3 emissive) {
  float lambert = max(0.0, dot(normal, frame.light_direction.xyz) * inversesqrt(max(dot(normal, normal), 1e-30)));
  return shade_lit(albedo, lambert, slot, outfit, unlit, emissive);
}
