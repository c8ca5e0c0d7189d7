#version 450 core
// A corner of a part's polygon, between its places in two stored frames.
#include "renderers/shaders/frame.glsl"
#include "renderers/polypostor/polypostor.shared.h"

layout(binding = CB_POLYPOSTOR_TEXTURE_WORDS) uniform usamplerBuffer words;
layout(location = CB_POLYPOSTOR_ATTRIBUTE_VERTEX) in uvec4 in_vertex;  // u, v, layer and part, turn
layout(location = CB_POLYPOSTOR_ATTRIBUTE_CLIP) in mat4 in_clip_from_units;
layout(location = CB_POLYPOSTOR_ATTRIBUTE_LIGHT) in vec4 in_light_blend;
layout(location = CB_POLYPOSTOR_ATTRIBUTE_POSE) in uvec4 in_pose;

// Page coordinates in [0, 1], layer. Affine on the screen, as polygons are fitted: images are what an eye sees.
layout(location = 0) noperspective out vec3 v_texel;
layout(location = 1) flat out vec3 v_light;  // towards the light, in the key image's axes
layout(location = 2) flat out uint v_outfit;
#ifdef CB_IDS
layout(location = 3) flat out uint v_id;
#endif
#ifdef CB_DEBUG
layout(location = 4) flat out uint v_part;
layout(location = 5) out vec2 v_units;  // place on the view's plane
layout(location = 6) flat out float v_level;
#endif

vec3 position(uint word) { return vec3(word & 0xfffu, word >> 12 & 0xfffu, word >> 24); }

void main() {
#ifdef CB_DEBUG
  float level = floor(in_light_blend.w * 0.5);
  float blend = in_light_blend.w - 2.0 * level;
  v_level = level;
#else
  float blend = in_light_blend.w;
#endif
  int a = gl_VertexID + int(in_pose.x);
  int b = gl_VertexID + int(in_pose.y);
  vec3 p = mix(position(texelFetch(words, a).x), position(texelFetch(words, b).x), blend);
  gl_Position = in_clip_from_units * vec4(p, 1.0);
  v_texel = vec3(vec2(in_vertex.xy) / 65535.0, float(in_vertex.z & 0x7ffu));

  vec2 turned = mix(unpackSnorm2x16(texelFetch(words, a + int(in_vertex.w)).x),
                    unpackSnorm2x16(texelFetch(words, b + int(in_vertex.w)).x), blend);
  turned *= inversesqrt(max(dot(turned, turned), 1e-12));
  vec3 light = in_light_blend.xyz;
  v_light = vec3(turned.x * light.x + turned.y * light.y, turned.x * light.y - turned.y * light.x, light.z);
  v_outfit = in_pose.z;
#ifdef CB_IDS
  v_id = in_pose.w;
#endif
#ifdef CB_DEBUG
  v_part = in_vertex.z >> 11;
  v_units = p.xy;
#endif
}
