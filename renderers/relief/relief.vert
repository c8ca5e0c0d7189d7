#version 450 core
// One instance an agent; eight corners of a box, or the corners of its outline on the screen.
#include "renderers/shaders/frame.glsl"
#include "renderers/relief/relief_records.glsl"

layout(std430, binding = RELIEF_STORAGE_POSED) readonly restrict buffer Posed { PosedBox posed[]; };
layout(location = RELIEF_LOCATION_FIRST) uniform uint first;

#ifndef HULL
#define CORNERS 8
#endif
layout(location = 0) out vec3 v_anchor;  // an outline has w = 1: linear on the screen (clipping spoils noperspective here)
layout(location = 1) flat out vec4 v_eye_depth;
layout(location = 2) flat out vec4 v_light;
layout(location = 3) flat out uvec4 v_maps;
layout(location = 4) flat out uvec4 v_identity;  // outfit, id, box, top row of its maps
#ifdef CARVE
layout(std430, binding = RELIEF_STORAGE_BOXES) readonly restrict buffer Boxes { BoxRecord boxes[]; };
layout(location = 5) out vec3 v_view;
#else
layout(location = 5) flat out vec3 v_view;
#endif

void main() {
  uint box = uint(gl_VertexID) / uint(CORNERS);
  uint corner = uint(gl_VertexID) % uint(CORNERS);
  uint item = uint(gl_InstanceID) * uint(BOXES) + box;
  vec4 eye_depth = posed[item].eye_depth;
  vec4 light = posed[item].light;
#ifdef HULL
  vec4 pair = posed[item].corners[corner / 2u];
  vec2 aside = (corner & 1u) == 0u ? pair.xy : pair.zw;
  vec4 a = posed[item].frame[0];
  vec4 b = posed[item].frame[1];
  v_anchor = posed[item].frame[2].xyz + a.xyz * aside.x + b.xyz * aside.y;
  vec2 at = vec2(a.w, b.w) + aside;
  gl_Position = vec4(at.x * frame.projection[0][0], at.y * frame.projection[1][1], 0.5, 1.0);
#else
  vec3 unit = vec3(corner & 1u, (corner >> 1u) & 1u, (corner >> 2u) & 1u);
  // A mirrored box keeps its outside outside.
  if (light.w < 0.0) unit.x = 1.0 - unit.x;
  vec4 p = vec4(unit, 1.0);
  gl_Position = frame.projection *
                vec4(dot(posed[item].frame[0], p), dot(posed[item].frame[1], p), dot(posed[item].frame[2], p), 1.0);
  v_anchor = unit;
#endif
  // What draws nothing collapses to a point.
  if (eye_depth.w < 0.0) gl_Position = vec4(0.0, 0.0, 0.5, 1.0);
  v_eye_depth = eye_depth;
  v_light = vec4(light.xyz, posed[item].view.w);
#ifdef CARVE
  vec3 back = v_eye_depth.xyz - v_anchor;
  v_view = vec3(dot(boxes[box].rows[0].xyz, back), dot(boxes[box].rows[1].xyz, back), dot(boxes[box].rows[2].xyz, back));
#else
  v_view = posed[item].view.xyz;
#endif
  uvec4 maps = posed[item].maps;
  v_identity = uvec4(agents[list[first + uint(gl_InstanceID)]].identity.xy, box, maps.w);
  maps.w = item;
  v_maps = maps;
}
