#version 450 core
// Two triangles an agent: the rectangle of its tile, on the plane that the tile was drawn for, turned with the agent.
#include "renderers/shaders/frame.glsl"
#include "renderers/dynamic/dynamic.shared.h"

layout(binding = CB_DYNAMIC_TEXTURE_RECORDS) uniform samplerBuffer records;  // CB_DYNAMIC_TEXELS an agent: QuadRecord
layout(location = CB_LOCATION_FIRST) uniform uint first;                     // record of the first agent drawn

layout(location = 0) out vec2 v_texel;  // page coordinates in [0, 1]
#ifdef CB_IDS
layout(location = 1) flat out uint v_id;
#endif

void main() {
  int at = (int(first) + gl_VertexID / 6) * CB_DYNAMIC_TEXELS;
  int corner = gl_VertexID % 6;
  vec2 share = vec2(corner == 1 || corner == 3 || corner == 4, corner == 2 || corner == 4 || corner == 5);
  vec4 centre = texelFetch(records, at);
  vec4 extent = texelFetch(records, at + 3);
  vec2 metres = mix(extent.xy, extent.zw, share);
  vec3 world = centre.xyz + texelFetch(records, at + 1).xyz * metres.x + texelFetch(records, at + 2).xyz * metres.y;
  vec4 place = texelFetch(records, at + 4);
  v_texel = mix(place.xy, place.zw, share);
  gl_Position = frame.clip_from_world * vec4(world, 1.0);
#ifdef CB_IDS
  v_id = floatBitsToUint(centre.w);
#endif
}
