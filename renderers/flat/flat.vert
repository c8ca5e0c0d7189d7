#version 450 core
// One convex polygon an agent: picks the tile for the direction from the capture centre to the eye, and lays the tile's
// outline on the tile's own plane, turned with the agent and not towards the screen, so that an agent seen from above
// does not lean. CB_CORNERS vertices an agent, in strip order. With CB_SLICES as many polygons an agent, parallel to that plane, each
// for the texels whose stored depth lies in its own interval.
#include "renderers/flat/flat_records.glsl"

layout(location = 0) out vec2 v_texel;              // page coordinates in [0, 1]
layout(location = 1) flat out uvec4 v_agent;        // towards the light in the tile's axes, as floats; outfit and layer
#ifdef CB_IDS
layout(location = 2) flat out uint v_id;
#endif
#ifdef CB_NAILBOARD
layout(location = 3) out float v_depth;             // eye-space depth of the capture plane, metres
layout(location = 4) flat out float v_depth_range;  // added to it at the end of the stored depth
layout(location = 5) flat out float v_texel_height; // of a surface that rises by a texel over a texel, as stored
#endif
#if CB_CORNERS == 3 || CB_PARALLAX > 0 || CB_BETWEEN > 0
layout(location = 6) flat out vec4 v_bounds;        // page coordinates of the gutter's texels: low, high
#endif
#if CB_PARALLAX > 0
layout(location = 7) flat out vec3 v_parallax[2];   // ParallaxView
#endif
#if CB_BETWEEN > 0
layout(location = 9) flat out vec4 v_between[4];    // Between
#endif
#ifdef CB_SLICES
layout(location = 9) flat out vec2 v_interval;      // heights over the tile's plane that are shown, metres
layout(location = 10) out float v_plane;            // height of that plane over the capture plane
layout(location = CB_LOCATION_OVERLAP) uniform float overlap;
#endif

void main() {
#ifdef CB_SLICES
  uint slot = uint(gl_VertexID) / uint(CB_CORNERS * CB_SLICES);
  uint slice = uint(gl_VertexID) / uint(CB_CORNERS) % uint(CB_SLICES);
#else
  uint slot = uint(gl_VertexID) / uint(CB_CORNERS);
#endif
  uint corner = uint(gl_VertexID) % uint(CB_CORNERS);
  Agent agent = listed_agent(slot);
  vec2 heading = agent.heading;
  vec2 back = vec2(-heading.x, heading.y);
  vec3 centre = agent.position + agent.scale * turn(table.centre.xyz, heading);

  int flipped;
  uint view = uint(pick_view(turn(-centre, back), table.grid, table.span, flipped));
#if CB_BETWEEN > 0
  Moment moment = moment_of(agent, view, flipped);
  int tile = moment.nearer;
#else
  int tile = tile_of(agent, view, flipped);
#endif
  vec3 right, up;
  float side = view_axes(view, flipped, right, up);
  vec2 p = tile_corner(tile, corner);
  vec4 place = tile_place(tile);
  vec4 plane = tile_plane(tile);
#if CB_BETWEEN > 0
  plane = mix(plane, tile_plane(moment.farther), moment.share);
#endif
#if CB_CORNERS == 3 || CB_PARALLAX > 0 || CB_BETWEEN > 0
  vec4 bounds = tile_bounds(tile);
#endif
#if CB_PARALLAX > 0
  vec2 middle = 0.5 * (bounds.xy + bounds.zw);
  p = middle + (p - middle) * kParallaxRoom;
#endif
  vec2 metres = p * table.scale.x;
  vec3 to_eye = cross(right, up);
  vec3 on_capture = right * (side * metres.x) + up * metres.y;
  float height = plane.x * metres.x + plane.y * metres.y + plane.z;
#ifdef CB_SLICES
  v_plane = height;
  float thick = 2.0 * plane.w / float(CB_SLICES);
  float low = float(slice) * thick - plane.w;
  v_interval = vec2(slice == 0u ? -1e9 : low - overlap * thick,
                    slice + 1u == uint(CB_SLICES) ? 1e9 : low + (1.0 + overlap) * thick);
  height += low + 0.5 * thick;
#endif
  vec3 world = centre + agent.scale * turn(on_capture + to_eye * height, heading);
  gl_Position = frame.clip_from_world * vec4(world, 1.0);

  v_texel = (p + place.xy) * table.scale.yz;
#if CB_CORNERS == 3 || CB_PARALLAX > 0 || CB_BETWEEN > 0
  v_bounds = gutter_of(bounds, place) * table.scale.yzyz;
#endif
  vec3 light = turn(frame.light_direction.xyz, back);
  v_agent.xyz = floatBitsToUint(vec3(dot(light, right) * side, dot(light, up), dot(light, to_eye)));
  uint layer = uint(place.z) - table.layers.x;
  if (layer >= table.layers.y) gl_Position = vec4(0.0, 0.0, 2.0, 1.0);  // in another texture: beyond the near plane
  v_agent.w = agent.outfit << CB_FLAT_LAYER_BITS | layer;
#if CB_PARALLAX > 0
  vec3 eye = turn(-centre, back) / agent.scale;
  parallax_view(vec3(dot(eye, right) * side, dot(eye, up), dot(eye, to_eye)), plane, place, v_parallax[0], v_parallax[1]);
#endif
#if CB_BETWEEN > 0
  vec4 other = tile_place(moment.farther);
  v_between[2] = vec4((other.xy - place.xy) * table.scale.yz, other.z - float(table.layers.x), moment.later ? 1.0 : 0.0);
  v_between[3] = gutter_of(tile_bounds(moment.farther), other) * table.scale.yzyz;
  v_between[0] = vec4(0.0, 0.0, 0.0, moment.share);
  v_between[1] = vec4(0.0);
#if CB_BETWEEN > 1
  // Of the level whose motions these are.
  int motion = 3 * (int(table.first.w) + moment.earlier);
  vec4 motion_place = texelFetch(tile_texels, motion);
  v_between[0].xyz = vec3(motion_place.xy - place.xy * table.motion.y, motion_place.z);
  v_between[1] = gutter_of(texelFetch(tile_texels, motion + 2), motion_place);
#endif
#endif
#ifdef CB_IDS
  v_id = agent.id;
#endif
#ifdef CB_NAILBOARD
  vec3 backward = transpose(frame.view_from_world)[2].xyz;
  v_depth = -dot(backward, centre + agent.scale * turn(on_capture, heading));
  v_texel_height = table.scale.x / table.centre.w;
  v_depth_range = -dot(backward, turn(to_eye, heading)) * agent.scale * table.centre.w;
#endif
}
