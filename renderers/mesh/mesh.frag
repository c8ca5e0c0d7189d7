#version 450 core
#include "renderers/shaders/shading.glsl"
#ifdef CB_CAPTURE
#define CB_CAPTURE_OUTPUTS
#include "renderers/tiles/capture.glsl"
#else
#include "renderers/shaders/output.glsl"
#endif

struct MaterialRecord {
  vec4 base_colour;    // linear factor
  vec4 emissive;       // linear factor; w unused
  uvec4 part_flags;    // part, CB_MATERIAL_* flags, layer of the base colour, layer of the emissive image
};
layout(std430, binding = CB_STORAGE_MATERIALS) readonly restrict buffer Materials { MaterialRecord materials[]; };
#ifdef CB_TEXTURES
layout(binding = CB_TEXTURE_BASE_COLOUR) uniform sampler2DArray base_colour_images;
#endif
#ifdef CB_EMISSIVE_TEXTURES
layout(binding = CB_TEXTURE_EMISSIVE) uniform sampler2DArray emissive_images;
#endif

layout(location = 0) in vec4 v_normal_u;
layout(location = 1) in float v_v;
layout(location = 2) flat in uint v_agent_material;
#ifdef CB_COLOURS
layout(location = 3) in vec3 v_colour;
#endif
#ifdef CB_EMISSIVE_UVS
layout(location = 4) in vec2 v_emissive_uv;
#endif

void main() {
  uint agent = v_agent_material & 0xfffffu;
  MaterialRecord material = materials[v_agent_material >> 20u];
  uint flags = material.part_flags.y;
  vec3 albedo = material.base_colour.rgb;
  vec3 emissive = material.emissive.rgb;
  vec2 uv = vec2(v_normal_u.w, v_v);
#ifdef CB_TEXTURES
  // Sampled outside the branch: derivatives must not depend on a neighbour's material.
  vec3 texel = texture(base_colour_images, vec3(uv, float(material.part_flags.z))).rgb;
  if ((flags & CB_MATERIAL_TEXTURE) != 0u) albedo *= texel;
#endif
#ifdef CB_COLOURS
  albedo *= v_colour;
#endif
#ifdef CB_EMISSIVE_TEXTURES
#ifdef CB_EMISSIVE_UVS
  vec2 emissive_uv = v_emissive_uv;
#else
  vec2 emissive_uv = uv;
#endif
  vec3 glow = texture(emissive_images, vec3(emissive_uv, float(material.part_flags.w))).rgb;
  if ((flags & CB_MATERIAL_EMISSIVE_TEXTURE) != 0u) emissive *= glow;
#endif
  vec3 normal = v_normal_u.xyz;
#ifdef CB_DOUBLE_SIDED
  if (!gl_FrontFacing) normal = -normal;
#endif
#ifdef CB_CAPTURE
  write_capture(albedo, normal, material.part_flags.x, (flags & CB_MATERIAL_UNLIT) != 0u);
#else
  uvec2 identity = agents[agent].identity.xy;
  write_output(shade(albedo, normal, material.part_flags.x, identity.x, (flags & CB_MATERIAL_UNLIT) != 0u, emissive),
               identity.y);
#endif
}
