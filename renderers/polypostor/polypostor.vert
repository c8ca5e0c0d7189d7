#version 450 core
// A corner of a part's polygon, between its places in two stored frames.
#include "renderers/shaders/frame.glsl"
#include "renderers/polypostor/polypostor.shared.h"

layout(binding = CB_POLYPOSTOR_TEXTURE_WORDS) uniform usamplerBuffer words;
layout(location = CB_POLYPOSTOR_ATTRIBUTE_VERTEX) in uvec4 in_vertex;  // u, v, layer and part, turn
layout(location = CB_POLYPOSTOR_ATTRIBUTE_CLIP) in mat4 in_clip_from_units;
layout(location = CB_POLYPOSTOR_ATTRIBUTE_LIGHT) in vec4 in_light_blend;
layout(location = CB_POLYPOSTOR_ATTRIBUTE_POSE) in uvec4 in_pose;

layout(location = 0) out vec4 v_texel;  // page coordinates in [0, 1] times a weight; layer; the weight
layout(location = 1) flat out vec3 v_light;  // towards the light, in the key image's axes
layout(location = 2) flat out uint v_outfit;  // and ranks
#ifdef CB_IDS
layout(location = 3) flat out uint v_id;
#endif
#ifdef CB_DEBUG
layout(location = 4) flat out uint v_part;
layout(location = 5) out vec2 v_units;  // place on the view's plane
layout(location = 6) flat out float v_level;
#endif

vec3 position(uint word) { return vec3(word & 0xfffu, word >> 12 & 0xfffu, word >> 24); }

// Weighted by its distance a corner's texel is affine on the screen, as polygons are fitted: images are what an eye sees.
// Where the eye is about to pass through the figure, what all weights are raised by keeps them positive, so that nothing
// jumps when a corner gets behind the eye; alike weights are affine on the polygon. distance: of the corner.
float weight(float distance) {
  vec4 row = vec4(in_clip_from_units[0].w, in_clip_from_units[1].w, in_clip_from_units[2].w, in_clip_from_units[3].w);
  vec3 half_range = vec3(2048.0, 2048.0, 128.0);  // of the words' positions
  float middle = dot(row.xyz, half_range) + row.w;
  float reach = dot(abs(row.xyz), half_range);  // of all corners from there, at most
  return distance + max(0.0, 2.0 * reach - middle);
}

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
  float w = weight(gl_Position.w);
  v_texel = vec4(vec2(in_vertex.xy) / 65535.0 * w, float(in_vertex.z & 0x7ffu), w);

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
