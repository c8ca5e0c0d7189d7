#version 450 core
// Linear blend skinning into a buffer, once a frame, for draws that then read places and normals: invocation (v, s)
// writes vertex v of slot `slot` + s by palette first + s.
#include "renderers/shaders/palette.glsl"
#include "renderers/mesh/skinned_vertex.glsl"

layout(local_size_x = 64) in;
layout(binding = CB_TEXTURE_REST) uniform usamplerBuffer rest;  // RestVertex (mesh_data.h), two texels
layout(std430, binding = CB_STORAGE_SKINNED) writeonly restrict buffer Skinned { uvec4 skinned[]; };
layout(location = CB_LOCATION_FIRST) uniform uint first;
layout(location = CB_LOCATION_JOINTS) uniform uint joints;
layout(location = CB_LOCATION_VERTICES) uniform uint vertices;
layout(location = CB_LOCATION_SLOT) uniform uint slot;

// A component of a 10:10:10 normal as the vertex fetch reads it.
float normal_component(uint bits, int at) {
  return max(float(bitfieldExtract(int(bits), at, 10)) / 511.0, -1.0);
}

void main() {
  uint vertex = gl_GlobalInvocationID.x;
  if (vertex >= vertices) return;
  uvec4 place = texelFetch(rest, int(vertex) * 2);
  uvec4 skin = texelFetch(rest, int(vertex) * 2 + 1);
  vec4 p = vec4(uintBitsToFloat(place.xyz), 1.0);
  vec3 n = vec3(normal_component(place.w, 0), normal_component(place.w, 10), normal_component(place.w, 20));
  uvec4 at = uvec4(skin.x & 0xffffu, skin.x >> 16u, skin.y & 0xffffu, skin.y >> 16u);
  at = (first + gl_WorkGroupID.y) * joints * 3u + at * 3u;
  vec4 w = vec4(unpackUnorm2x16(skin.z), unpackUnorm2x16(skin.w));
  vec4 row0 = w.x * palette_row(at.x) + w.y * palette_row(at.y) + w.z * palette_row(at.z) + w.w * palette_row(at.w);
  vec4 row1 = w.x * palette_row(at.x + 1u) + w.y * palette_row(at.y + 1u) + w.z * palette_row(at.z + 1u) + w.w * palette_row(at.w + 1u);
  vec4 row2 = w.x * palette_row(at.x + 2u) + w.y * palette_row(at.y + 2u) + w.z * palette_row(at.z + 2u) + w.w * palette_row(at.w + 2u);
  skinned[(slot + gl_WorkGroupID.y) * vertices + vertex] =
      skinned_record(vec3(dot(row0, p), dot(row1, p), dot(row2, p)),
                     vec3(dot(row0.xyz, n), dot(row1.xyz, n), dot(row2.xyz, n)));
}
