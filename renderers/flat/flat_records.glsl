// The bake of the character being drawn, as the vertex shaders read it.
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

// The tile of a view at the agent's nearest frame; a mirrored image is half a cycle late.
uint tile_of(AgentRecord agent, uint view, int flipped) {
  uvec4 clip = table.clips[agent.pose.z];
  uint step = uint(floor(agent.heading_blend.w * float(clip.y) + 0.5)) + (flipped != 0 ? clip.y / 2u : 0u);
  return (clip.x + step % clip.y) * table.counts.x + view;
}

// The axes of a view's plane in model space. Returns -1 where the tile's x runs against `right`, else 1.
float view_axes(uint view, int flipped, out vec3 right, out vec3 up) {
  right = table.views[2u * view].xyz;
  up = table.views[2u * view + 1u].xyz;
  if (flipped == 0) return 1.0;
  right.z = -right.z;
  up.x = -up.x;
  return -1.0;
}
