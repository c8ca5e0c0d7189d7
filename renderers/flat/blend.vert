#version 450 core
// The blend of three views: one quad an agent, facing the eye, around what the three tiles' outlines cover as the eye
// sees them on their own planes. From a point of the quad to a point of a tile is a projective map, so its homogeneous
// coordinates are interpolated and divided in the fragment shader.
#include "renderers/flat/flat_records.glsl"

layout(location = 0) out vec3 v_texel[3];           // page coordinates times z, z
layout(location = 3) flat out vec4 v_bounds[3];     // what of the page belongs to the tile: low, high
layout(location = 6) flat out vec4 v_light[3];      // towards the light in the tile's axes; layer
layout(location = 9) flat out vec3 v_weights;
layout(location = 10) flat out uvec2 v_outfit_id;
#ifdef CB_NAILBOARD
layout(location = 11) flat out vec4 v_depth[3];     // eye-space depth: dot with page coordinates, 1, stored depth
layout(location = 14) flat out float v_texel_height;
#endif
#if CB_PARALLAX > 0
layout(location = 15) flat out vec3 v_parallax[6];  // ParallaxView of each
#endif

void main() {
  uint slot = uint(gl_VertexID) / 4u;
  uint corner = uint(gl_VertexID) % 4u;
  Agent agent = listed_agent(slot);
  vec2 heading = agent.heading;
  vec2 back = vec2(-heading.x, heading.y);
  float scale = agent.scale;
  vec3 centre = agent.position + scale * turn(table.centre.xyz, heading);
  // Model axes, metres at scale 1, from the capture centre.
  vec3 eye = turn(-centre, back) / scale;
  vec3 light = turn(frame.light_direction.xyz, back);
  float distance = max(length(eye), 1e-6);
  vec3 facing = eye / distance;
  vec3 quad_right = abs(facing.y) > 0.999 ? vec3(1.0, 0.0, 0.0) : normalize(vec3(facing.z, 0.0, -facing.x));
  vec3 quad_up = cross(facing, quad_right);

  ivec3 views;
  vec3 weights;
  int flipped;
  blend_views(eye, table.grid, table.span, views, weights, flipped);
  vec2 low = vec2(1e30);
  vec2 high = vec2(-1e30);
  vec3 eye_there[3], right[3], up[3];
  vec4 place[3], plane[3];
  float side = 1.0;
  for (int i = 0; i < 3; ++i) {
    int tile = tile_of(agent, uint(views[i]), flipped);
    side = view_axes(uint(views[i]), flipped, right[i], up[i]);
    vec3 to_eye = cross(right[i], up[i]);
    right[i] *= side;  // the tile's own x
    eye_there[i] = vec3(dot(right[i], eye), dot(up[i], eye), dot(to_eye, eye));
    place[i] = tile_place(tile);
    plane[i] = tile_plane(tile);
    vec2 tile_low = vec2(1e30);
    vec2 tile_high = vec2(-1e30);
#if CB_CORNERS == 3
    vec4 bounds = tile_bounds(tile);
#endif
    for (uint c = 0u; c < uint(max(CB_CORNERS, 4)); ++c) {
#if CB_CORNERS == 3
      vec2 p = vec2(c % 2u == 0u ? bounds.x : bounds.z, c < 2u ? bounds.y : bounds.w);
#else
      vec2 p = tile_corner(tile, c);
#endif
      tile_low = min(tile_low, p);
      tile_high = max(tile_high, p);
      vec2 m = p * table.scale.x;
      vec3 point = right[i] * m.x + up[i] * m.y + to_eye * (plane[i].x * m.x + plane[i].y * m.y + plane[i].z);
      // Through the eye onto the quad's plane.
      vec2 there = vec2(dot(quad_right, point), dot(quad_up, point)) * (distance / max(distance - dot(facing, point), 1e-3));
      if (weights[i] > 0.001) {
        low = min(low, there);
        high = max(high, there);
      }
    }
    v_bounds[i] = vec4((tile_low + place[i].xy) * table.scale.yz, (tile_high + place[i].xy) * table.scale.yz);
    v_light[i] = vec4(dot(light, right[i]), dot(light, up[i]), dot(light, to_eye), place[i].z);
  }
#if CB_PARALLAX > 0
  vec2 room = (0.5 * kParallaxRoom - 0.5) * (high - low);
  low -= room;
  high += room;
  for (int i = 0; i < 3; ++i) parallax_view(eye_there[i], plane[i], place[i], v_parallax[2 * i], v_parallax[2 * i + 1]);
#endif
  vec2 at = mix(low, high, vec2(corner & 1u, corner >> 1u));
  vec3 point = quad_right * at.x + quad_up * at.y;
  gl_Position = frame.clip_from_world * vec4(centre + scale * turn(point, heading), 1.0);

  for (int i = 0; i < 3; ++i) {
    // The ray from the eye through the point meets height = plane.x * x + plane.y * y + plane.z.
    vec3 ray = point - eye;
    vec3 to_eye = cross(right[i], up[i]) * side;
    ray = vec3(dot(right[i], ray), dot(up[i], ray), dot(to_eye, ray));
    vec3 e = eye_there[i];
    float across = ray.z - plane[i].x * ray.x - plane[i].y * ray.y;
    float along = plane[i].x * e.x + plane[i].y * e.y + plane[i].z - e.z;
    vec2 metres = e.xy * across + along * ray.xy;
    v_texel[i] = vec3((metres / table.scale.x + place[i].xy * across) * table.scale.yz, across);
#ifdef CB_NAILBOARD
    vec3 forward = turn(-transpose(frame.view_from_world)[2].xyz, back);
    vec2 slope = scale * vec2(dot(forward, right[i]), dot(forward, up[i])) * table.scale.x;  // a texel
    v_depth[i] = vec4(slope / table.scale.yz, dot(turn(forward, heading), centre) - dot(slope, place[i].xy),
                      scale * dot(forward, to_eye) * table.centre.w);
#endif
  }
  v_weights = weights;
  v_outfit_id = uvec2(agent.outfit, agent.id);
#ifdef CB_NAILBOARD
  v_texel_height = table.scale.x / table.centre.w;
#endif
}
