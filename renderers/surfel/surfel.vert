#version 450 core
// Surfels of one character type, instanced: skinned points, each lit here and drawn as the ellipse that a disc in its
// plane shows. CB_STATIC: the floor, already posed in model space.
#include "renderers/shaders/shading.glsl"

layout(location = CB_ATTRIBUTE_POSITION) in vec4 in_position;  // w: metres to where the surface ends
layout(location = CB_ATTRIBUTE_NORMAL) in vec4 in_normal;
layout(location = CB_ATTRIBUTE_UV) in uint in_bits;  // slot, unlit << 8, double-sided << 9
layout(location = CB_ATTRIBUTE_COLOUR) in vec3 in_colour;
layout(location = CB_ATTRIBUTE_EMISSIVE_UV) in vec3 in_emissive;
layout(location = CB_ATTRIBUTE_AGENT) in uint in_agent;
#ifndef CB_STATIC
layout(location = CB_ATTRIBUTE_JOINTS) in uvec4 in_joints;
layout(location = CB_ATTRIBUTE_WEIGHTS) in vec4 in_weights;
#include "renderers/shaders/palette.glsl"
layout(location = CB_LOCATION_JOINTS) uniform uint joints;
layout(location = CB_LOCATION_FIRST) uniform uint first;  // palette of the first instance
#endif
layout(location = CB_LOCATION_RADIUS) uniform float radius;    // metres at scale 1
layout(location = CB_LOCATION_REACH) uniform float reach;      // factor of in_position.w
layout(location = CB_LOCATION_THIN) uniform float thin;        // factor of all, in figures of few pixels
layout(location = CB_LOCATION_TALL) uniform float tall;        // metres at scale 1, of the figure
layout(location = CB_LOCATION_SAMPLES) uniform float samples;  // of the target along a pixel of the picture

layout(location = 0) flat out vec3 v_colour;
layout(location = 1) flat out vec4 v_ellipse;  // rows: from samples of the target about v_centre to the unit circle
layout(location = 2) flat out vec2 v_centre;   // samples of the target
#ifdef CB_IDS
layout(location = 3) flat out uint v_id;
#endif

// Discs seen from their edge are shown no narrower than this share of their radius (surfel_area.h, kNarrowest), and no
// narrower than so many pixels where they are larger: for what positions are rounded by.
const float kNarrowest = 0.1;
// Figures of few pixels cover as much as the character does, in the mean, with gaps between discs; in larger ones next
// to none are left. Pixels of the longest side (surfel_level.h).
const vec2 kFewPixels = vec2(8.0, 64.0);
// What drivers round a point's place by, in samples.
const float kRounded = 1.0 / 128.0;

void main() {
  vec4 position_scale = agent_position_scale(in_agent);
#ifdef CB_STATIC
  vec2 heading = agent_heading_blend(in_agent).xy;
  vec3 world = position_scale.xyz + position_scale.w * turn(in_position.xyz, heading);
  vec3 normal = turn(in_normal.xyz, heading);
#else
  uvec4 at = ((first + uint(gl_InstanceID)) * joints + in_joints) * 3u;
  vec4 w = in_weights;
  vec4 row0 = w.x * palette_row(at.x) + w.y * palette_row(at.y) + w.z * palette_row(at.z) + w.w * palette_row(at.w);
  vec4 row1 = w.x * palette_row(at.x + 1u) + w.y * palette_row(at.y + 1u) + w.z * palette_row(at.z + 1u) + w.w * palette_row(at.w + 1u);
  vec4 row2 = w.x * palette_row(at.x + 2u) + w.y * palette_row(at.y + 2u) + w.z * palette_row(at.z + 2u) + w.w * palette_row(at.w + 2u);
  vec4 p = vec4(in_position.xyz, 1.0);
  vec3 world = vec3(dot(row0, p), dot(row1, p), dot(row2, p));
  vec3 normal = vec3(dot(row0.xyz, in_normal.xyz), dot(row1.xyz, in_normal.xyz), dot(row2.xyz, in_normal.xyz));
#endif
  normal *= inversesqrt(max(dot(normal, normal), 1e-30));
  float facing = -dot(normal, world) * inversesqrt(max(dot(world, world), 1e-30));
  bool turned = facing < 0.0 && (in_bits & 0x200u) != 0u;
  if (turned) {
    normal = -normal;
    facing = -facing;
  }
  uvec2 identity = agent_identity(in_agent).xy;
  v_colour = shade(in_colour, normal, in_bits & 0xffu, identity.x, (in_bits & 0x100u) != 0u, in_emissive);
#ifdef CB_IDS
  v_id = identity.y;
#endif
  gl_Position = frame.clip_from_world * vec4(world, 1.0);
  float metre = position_scale.w * 0.5 * frame.viewport.y / (frame.lens.z * max(gl_Position.w, 1e-6));  // in pixels
  float whole = clamp((tall * metre - kFewPixels.x) / (kFewPixels.y - kFewPixels.x), 0.0, 1.0);
  float major = max(min(radius, reach * in_position.w) * metre * mix(thin, 1.0, whole), 1e-6);
  float minor = max(major * facing, min(major, 1.0) * kNarrowest);
  vec2 lean = (mat3(frame.view_from_world) * normal).xy;
  float length2 = dot(lean, lean);
  vec2 along = length2 > 1e-12 ? lean * inversesqrt(length2) : vec2(1.0, 0.0);
  float square = max(major * samples, 0.5) + kRounded;  // half its side, in samples: drivers draw no smaller points
  v_ellipse = vec4(along, -along.y, along.x) * (1.0 / (samples * vec4(minor, minor, major, major)));
  v_centre = (0.5 * gl_Position.xy / gl_Position.w + 0.5) * frame.viewport.xy * samples;
  gl_PointSize = 2.0 * square;
  // A point whose centre lies outside of the picture is not drawn, though its disc may reach in: its square is moved to
  // the border. What lies beyond its reach, and what faces away, being behind what faces here, goes outside.
  vec2 border = vec2(gl_Position.w);
  vec2 reached = border * (1.0 + 2.0 * square / (samples * frame.viewport.xy));
  bool outside = any(greaterThan(abs(gl_Position.xy), reached));
  gl_Position.xy = clamp(gl_Position.xy, -border, border);
  if (facing < 0.0 || outside) gl_Position = vec4(2.0, 2.0, 0.0, 1.0);
}
