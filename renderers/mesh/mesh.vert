#version 450 core
// Linear blend skinning of one character type, instanced. Without posing here:
//   CB_STATIC       positions already posed, in model space
//   CB_SKINNED      vertices that skin.comp wrote, in the world, a slot an instance
//   CB_SHARED_POSE  the same in model space, one slot for all
//   CB_CACHED_POSES the same, each instance a blend of two slots
// CB_TILE: an instance goes to its own tile of a page, lit as in the picture. CB_DEPTH: a pass that writes depth alone. CB_INVARIANT: such a pass and others of the same frame agree to the bit.
#include "renderers/shaders/frame.glsl"

#ifdef CB_INVARIANT
invariant gl_Position;
#endif

#ifdef CB_SAMPLED
#define CB_WITHIN centroid
#else
#define CB_WITHIN
#endif
layout(location = CB_ATTRIBUTE_POSITION) in vec4 in_position;  // w: the material's index
layout(location = CB_ATTRIBUTE_NORMAL) in vec4 in_normal;
layout(location = CB_ATTRIBUTE_UV) in vec2 in_uv;
#if defined(CB_SKINNED) || defined(CB_SHARED_POSE) || defined(CB_CACHED_POSES)
#include "renderers/mesh/skinned_vertex.glsl"
layout(binding = CB_TEXTURE_SKINNED) uniform usamplerBuffer skinned;
layout(location = CB_LOCATION_VERTICES) uniform uint vertices;
#ifdef CB_CACHED_POSES
layout(binding = CB_TEXTURE_BLENDS) uniform usamplerBuffer blends;
#else
layout(location = CB_LOCATION_SLOT) uniform uint slot;
#endif
#elif !defined(CB_STATIC)
layout(location = CB_ATTRIBUTE_JOINTS) in uvec4 in_joints;
layout(location = CB_ATTRIBUTE_WEIGHTS) in vec4 in_weights;
#include "renderers/shaders/palette.glsl"
layout(location = CB_LOCATION_JOINTS) uniform uint joints;
#endif
#ifdef CB_COLOURS
layout(location = CB_ATTRIBUTE_COLOUR) in vec4 in_colour;
layout(location = 3) CB_WITHIN out vec4 v_colour;
#endif
#ifdef CB_EMISSIVE_UVS
layout(location = CB_ATTRIBUTE_EMISSIVE_UV) in vec2 in_emissive_uv;
layout(location = 4) CB_WITHIN out vec2 v_emissive_uv;
#endif
layout(location = CB_ATTRIBUTE_AGENT) in uint in_agent;
#ifdef CB_CAPTURE
#include "renderers/impostor/tiles/capture.glsl"
#endif
#ifdef CB_TILE
layout(binding = CB_TEXTURE_TILE_ROWS) uniform samplerBuffer tile_rows;  // four an instance: clip space from the world
#endif

#ifndef CB_DEPTH
layout(location = 0) CB_WITHIN out vec4 v_normal_u;  // world normal, not unit; u. Few outputs: each costs every triangle's set-up
layout(location = 1) CB_WITHIN out float v_v;
layout(location = 2) flat out uint v_outfit_material;  // outfit in the low 16 bits, material above
#endif
#ifdef CB_IDS
layout(location = 5) flat out uint v_id;
#endif

#ifdef CB_FLAT_NORMALS
layout(location = 6) CB_WITHIN out vec4 v_place_flat;  // place on the axes of the normal; 1 where the face's own normal is used
#endif

#ifdef CB_FEEDBACK
out vec3 f_world;  // captured by the skinning test
#endif

void main() {
  vec3 world;
  vec3 normal;
#ifdef CB_SKINNED
  uvec4 record = texelFetch(skinned, int((slot + uint(gl_InstanceID)) * vertices) + gl_VertexID);
  world = skinned_position(record);
  normal = skinned_normal(record);
#elif defined(CB_STATIC) || defined(CB_SHARED_POSE) || defined(CB_CACHED_POSES)
#ifdef CB_SHARED_POSE
  uvec4 record = texelFetch(skinned, int(slot * vertices) + gl_VertexID);
  vec3 model = skinned_position(record);
  vec3 model_normal = skinned_normal(record);
#elif defined(CB_CACHED_POSES)
  uvec2 pair = texelFetch(blends, gl_InstanceID).xy;
  uvec4 record = texelFetch(skinned, int((pair.x & 0xffffu) * vertices) + gl_VertexID);
  uvec4 after = texelFetch(skinned, int((pair.x >> 16u) * vertices) + gl_VertexID);
  float blend = uintBitsToFloat(pair.y);
  vec3 model = mix(skinned_position(record), skinned_position(after), blend);
  vec3 model_normal = mix(skinned_normal(record), skinned_normal(after), blend);
#else
  vec3 model = in_position.xyz;
  vec3 model_normal = in_normal.xyz;
#endif
  vec4 position_scale = agent_position_scale(in_agent);
  vec2 heading = agent_heading_blend(in_agent).xy;
  world = position_scale.xyz + position_scale.w * turn(model, heading);
  normal = turn(model_normal, heading);
#else
  uint base = uint(gl_InstanceID) * joints * 3u;
  uvec4 at = base + in_joints * 3u;
  vec4 w = in_weights;
  vec4 row0 = w.x * palette_row(at.x) + w.y * palette_row(at.y) + w.z * palette_row(at.z) + w.w * palette_row(at.w);
  vec4 row1 = w.x * palette_row(at.x + 1u) + w.y * palette_row(at.y + 1u) + w.z * palette_row(at.z + 1u) + w.w * palette_row(at.w + 1u);
  vec4 row2 = w.x * palette_row(at.x + 2u) + w.y * palette_row(at.y + 2u) + w.z * palette_row(at.z + 2u) + w.w * palette_row(at.w + 2u);
  vec4 p = vec4(in_position.xyz, 1.0);
  world = vec3(dot(row0, p), dot(row1, p), dot(row2, p));
  normal = vec3(dot(row0.xyz, in_normal.xyz), dot(row1.xyz, in_normal.xyz), dot(row2.xyz, in_normal.xyz));
#endif
#ifdef CB_FEEDBACK
  f_world = world;
#endif
#ifndef CB_DEPTH
  v_normal_u = vec4(normal, in_uv.x);
  v_v = in_uv.y;
  uvec2 identity = agent_identity(in_agent).xy;
  v_outfit_material = identity.x | uint(in_position.w) << 16u;
#endif
#ifdef CB_IDS
  v_id = identity.y;
#endif
#ifdef CB_COLOURS
  v_colour = in_colour;
#endif
#ifdef CB_EMISSIVE_UVS
  v_emissive_uv = in_emissive_uv;
#endif
#ifdef CB_CAPTURE
  CaptureView view = capture_views[in_agent];
  gl_Position = capture_position(view, world);
  v_normal_u.xyz = capture_normal(view, normal);
#ifdef CB_FLAT_NORMALS
  v_place_flat = vec4(capture_normal(view, world), in_normal.w);
#endif
#else
#ifdef CB_TILE
  vec4 place = vec4(world, 1.0);
  int row = gl_InstanceID * 4;
  gl_Position = vec4(dot(texelFetch(tile_rows, row), place), dot(texelFetch(tile_rows, row + 1), place),
                     dot(texelFetch(tile_rows, row + 2), place), dot(texelFetch(tile_rows, row + 3), place));
#else
  gl_Position = frame.clip_from_world * vec4(world, 1.0);
#endif
#ifdef CB_FLAT_NORMALS
  v_place_flat = vec4(world, in_normal.w);
#endif
#endif
}
