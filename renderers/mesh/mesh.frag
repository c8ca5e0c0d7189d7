#version 450 core
#include "renderers/shaders/shading.glsl"
#ifdef CB_CAPTURE
#define CB_CAPTURE_OUTPUTS
#include "renderers/impostor/tiles/capture.glsl"
#else
#include "renderers/shaders/output.glsl"
#endif

// CB_MATERIAL_TEXELS a material: linear base colour and, as bits, slot | flags << 8 | layer << 16; linear emissive colour and
// the layer of its image; the least alpha that counts as there.
layout(binding = CB_TEXTURE_MATERIALS) uniform samplerBuffer materials;
#ifdef CB_TEXTURES
layout(binding = CB_TEXTURE_BASE_COLOUR) uniform sampler2DArray base_colour_images;
#endif
#ifdef CB_EMISSIVE_TEXTURES
layout(binding = CB_TEXTURE_EMISSIVE) uniform sampler2DArray emissive_images;
#endif

#ifdef CB_SAMPLED
// Where some of a pixel's samples lie within the triangle: at its middle, colours would be those of beyond the edge.
#define CB_WITHIN centroid
#else
#define CB_WITHIN
#endif
layout(location = 0) CB_WITHIN in vec4 v_normal_u;
layout(location = 1) CB_WITHIN in float v_v;
layout(location = 2) flat in uint v_outfit_material;
#ifdef CB_IDS
layout(location = 5) flat in uint v_id;
#endif
#ifdef CB_COLOURS
layout(location = 3) CB_WITHIN in vec4 v_colour;
#endif
#ifdef CB_EMISSIVE_UVS
layout(location = 4) CB_WITHIN in vec2 v_emissive_uv;
#endif
#ifdef CB_FLAT_NORMALS
layout(location = 6) CB_WITHIN in vec4 v_place_flat;
#endif

void main() {
  int material = int(v_outfit_material >> 16u) * CB_MATERIAL_TEXELS;
  vec4 texel0 = texelFetch(materials, material);
  uint bits = floatBitsToUint(texel0.w);
  uint slot = bits & 0xffu;
  uint flags = bits >> 8u;
  vec3 albedo = texel0.rgb;
#ifdef CB_EMISSIVE
  vec4 texel1 = texelFetch(materials, material + 1);
  vec3 emissive = texel1.rgb;
#else
  vec3 emissive = vec3(0.0);
#endif
  vec2 uv = vec2(v_normal_u.w, v_v);
#ifdef CB_TEXTURES
  // Sampled outside the branch: derivatives must not depend on a neighbour's material.
  vec4 texel = texture(base_colour_images, vec3(uv, float(bits >> 16u)));
  if ((flags & CB_MATERIAL_TEXTURE) != 0u) albedo *= texel.rgb;
#endif
#ifdef CB_COLOURS
  albedo *= v_colour.rgb;
#endif
#ifdef CB_EMISSIVE_TEXTURES
#ifdef CB_EMISSIVE_UVS
  vec2 emissive_uv = v_emissive_uv;
#else
  vec2 emissive_uv = uv;
#endif
  vec3 glow = texture(emissive_images, vec3(emissive_uv, texel1.w)).rgb;
  if ((flags & CB_MATERIAL_EMISSIVE_TEXTURE) != 0u) emissive *= glow;
#endif
#ifdef CB_MASKED
  float alpha = 1.0;
#ifdef CB_TEXTURES
  if ((flags & CB_MATERIAL_TEXTURE) != 0u) alpha *= texel.a;
#endif
#ifdef CB_COLOURS
  alpha *= v_colour.a;
#endif
  float cutoff = texelFetch(materials, material + 2).x;
#if defined(CB_MASKED) && defined(CB_SAMPLED)
  // Alpha about the cutoff becomes the share of the pixel's samples that are covered: all within a pixel of the outline.
  float covered = cutoff > 0.0 ? clamp((alpha - cutoff) / max(fwidth(alpha), 1e-4) + 0.5, 0.0, 1.0) : 1.0;
  bool absent = covered == 0.0;
#else
  bool absent = alpha < cutoff;
#endif
#endif
  vec3 normal = v_normal_u.xyz;
#ifdef CB_DOUBLE_SIDED
  if (!gl_FrontFacing) normal = -normal;
#endif
#ifdef CB_FLAT_NORMALS
  // The face as it is posed, its side towards the eye. A face of no extent keeps what was interpolated.
  vec3 face = cross(dFdx(v_place_flat.xyz), dFdy(v_place_flat.xyz));
  if (v_place_flat.w > 0.5 && dot(face, face) > 0.0) normal = face;
#endif
#ifdef CB_MASKED
  if (absent) discard;  // after the last derivative
#endif
#ifdef CB_CAPTURE
  write_capture(albedo, normal, slot, (flags & CB_MATERIAL_UNLIT) != 0u, emissive);
#else
#ifdef CB_IDS
  uint id = v_id;
#else
  uint id = 0u;
#endif
  write_output(shade(albedo, normal, slot, v_outfit_material & 0xffffu, (flags & CB_MATERIAL_UNLIT) != 0u, emissive), id);
#if defined(CB_MASKED) && defined(CB_SAMPLED)
  out_colour.a = covered;
#endif
#endif
}
