#version 450 core
// One convex polygon an agent: picks the tile for the direction from the capture centre to the eye, and lays the tile's
// outline on the tile's own plane, turned with the agent and not towards the screen, so that an agent seen from above
// does not lean. CB_CORNERS vertices an agent, in strip order.
#include "renderers/shaders/frame.glsl"
#include "renderers/flat/flat.shared.h"
#include "renderers/views/view_grid.glsl"

struct Level {
  vec4 scale;   // metres a texel, 1 / width, 1 / height of a page in texels
  uvec4 first;  // of the level's tiles, of its outlines' corners
};
layout(std430, binding = CB_STORAGE_VIEWS) readonly restrict buffer Table {
  vec4 centre;      // capture centre, model space, metres; w: what the ends of the stored depth stand for, metres
  ivec4 grid;       // as pick_view takes them
  vec4 span;
  uvec4 counts;     // views
  Level levels[CB_FLAT_LEVELS];
  uvec4 clips[CB_FLAT_CLIPS];  // first frame, frames
  vec4 views[];     // right, up of every view
} table;
layout(std430, binding = CB_STORAGE_TILES) readonly restrict buffer Tiles { vec4 tiles[]; };  // two a tile: FlatTile
layout(std430, binding = CB_STORAGE_OUTLINES) readonly restrict buffer Outlines { vec2 outlines[]; };
layout(location = CB_FLAT_LOCATION_LEVEL) uniform int level;

layout(location = 0) out vec3 v_texel;              // page coordinates in [0, 1], layer
layout(location = 1) flat out vec3 v_light;         // towards the light, in the tile's axes
layout(location = 2) flat out uint v_outfit;
#ifdef CB_IDS
layout(location = 3) flat out uint v_id;
#endif
#ifdef CB_NAILBOARD
layout(location = 4) out float v_depth;             // eye-space depth of the capture plane, metres
layout(location = 5) flat out float v_depth_range;  // added to it at the end of the stored depth
layout(location = 6) flat out float v_texel_height; // of a surface that rises by a texel over a texel, as stored
#endif

void main() {
  uint slot = uint(gl_VertexID) / uint(CB_CORNERS);
  uint corner = uint(gl_VertexID) % uint(CB_CORNERS);
  AgentRecord agent = agents[list[slot]];
  vec2 heading = agent.heading_blend.xy;
  vec2 back = vec2(-heading.x, heading.y);
  float scale = agent.position_scale.w;
  vec3 centre = agent.position_scale.xyz + scale * turn(table.centre.xyz, heading);

  int flipped;
  uint view = uint(pick_view(turn(-centre, back), table.grid, table.span, flipped));
  uvec4 clip = table.clips[agent.pose.z];
  uint step = uint(floor(agent.heading_blend.w * float(clip.y) + 0.5)) + (flipped != 0 ? clip.y / 2u : 0u);
  uint tile = (clip.x + step % clip.y) * table.counts.x + view;

  vec3 right = table.views[2u * view].xyz;
  vec3 up = table.views[2u * view + 1u].xyz;
  float side = 1.0;
  if (flipped != 0) {
    right.z = -right.z;
    up.x = -up.x;
    side = -1.0;
  }
  Level l = table.levels[level];
  vec2 p = outlines[l.first.y + tile * uint(CB_CORNERS) + corner];
  vec4 place = tiles[2u * (l.first.x + tile)];
  vec4 plane = tiles[2u * (l.first.x + tile) + 1u];
  vec2 metres = p * l.scale.x;
  vec3 to_eye = cross(right, up);
  vec3 on_capture = right * (side * metres.x) + up * metres.y;
  vec3 world = centre + scale * turn(on_capture + to_eye * (plane.x * metres.x + plane.y * metres.y + plane.z), heading);
  gl_Position = frame.clip_from_world * vec4(world, 1.0);

  v_texel = vec3((p + place.xy) * l.scale.yz, place.z);
  vec3 light = turn(frame.light_direction.xyz, back);
  v_light = vec3(dot(light, right) * side, dot(light, up), dot(light, to_eye));
  v_outfit = agent.identity.x;
#ifdef CB_IDS
  v_id = agent.identity.y;
#endif
#ifdef CB_NAILBOARD
  vec3 backward = transpose(frame.view_from_world)[2].xyz;
  v_depth = -dot(backward, centre + scale * turn(on_capture, heading));
  v_texel_height = l.scale.x / table.centre.w;
  v_depth_range = -dot(backward, turn(to_eye, heading)) * scale * table.centre.w;
#endif
}
