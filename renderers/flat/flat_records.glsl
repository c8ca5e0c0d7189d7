// The bake of the character being drawn and the agents, as the vertex shaders read them.
#include "renderers/shaders/frame.glsl"
#include "renderers/flat/flat_table.glsl"
#include "renderers/impostor/views/view_grid.glsl"

layout(binding = CB_TEXTURE_TILES) uniform samplerBuffer tile_texels;        // three a tile: FlatTile
layout(binding = CB_TEXTURE_OUTLINES) uniform samplerBuffer outline_texels;  // one a corner
layout(binding = CB_TEXTURE_VIEWS) uniform samplerBuffer view_texels;        // right and up of every view

struct Agent {
  vec3 position;  // relative to the eye, world axes, metres
  float scale;
  vec2 heading;  // sine and cosine
  float phase;   // of the clip
  uint outfit, id, clip;
};

Agent listed_agent(uint slot) {
  uint at = list[slot];
  vec4 place = agent_position_scale(at);
  vec4 heading = agent_heading_blend(at);
  uvec3 identity = agent_identity(at);
  return Agent(place.xyz, place.w, heading.xy, heading.w, identity.x, identity.y, identity.z);
}

// The tile, of this level, of a view at the agent's nearest frame; a mirrored image is half a cycle late.
int tile_of(Agent agent, uint view, int flipped) {
  uvec2 clip = table.clips[agent.clip].xy;
  uint step = uint(floor(agent.phase * float(clip.y) + 0.5)) + (flipped != 0 ? clip.y / 2u : 0u);
  return int((clip.x + step % clip.y) * table.first.z + view);
}

#if CB_BETWEEN > 0
// The two frames of its clip that an agent's moment lies between.
struct Moment {
  int nearer, farther;  // their tiles of this level
  int earlier;          // of the two; where motions are
  float share;          // of a step between frames, from the nearer one: [0, 0.5]
  bool later;           // the nearer one is the later one
};

Moment moment_of(Agent agent, uint view, int flipped) {
  uvec2 clip = table.clips[agent.clip].xy;
  float at = agent.phase * float(clip.y);
  uint step = uint(floor(at)) + (flipped != 0 ? clip.y / 2u : 0u);
  int earlier = int((clip.x + step % clip.y) * table.first.z + view);
  int later = int((clip.x + (step + 1u) % clip.y) * table.first.z + view);
  float share = fract(at);
  bool second = share >= 0.5;
  return Moment(second ? later : earlier, second ? earlier : later, earlier, second ? 1.0 - share : share, second);
}
#endif

// FlatTile's members in three.
vec4 tile_place(int tile) { return texelFetch(tile_texels, 3 * (int(table.first.x) + tile)); }
vec4 tile_plane(int tile) { return texelFetch(tile_texels, 3 * (int(table.first.x) + tile) + 1); }
vec4 tile_bounds(int tile) { return texelFetch(tile_texels, 3 * (int(table.first.x) + tile) + 2); }

// The middles of a tile's outermost texels, its gutter's: low, high; texels of the page.
vec4 gutter_of(vec4 bounds, vec4 place) { return bounds + vec4(-0.5, -0.5, 0.5, 0.5) + place.xyxy; }

// A corner of a tile's outline, texels.
vec2 tile_corner(int tile, uint corner) {
  return texelFetch(outline_texels, int(table.first.y) + tile * CB_CORNERS + int(corner)).xy;
}

// The axes of a view's plane in model space. Returns -1 where the tile's x runs against `right`, else 1.
float view_axes(uint view, int flipped, out vec3 right, out vec3 up) {
  right = texelFetch(view_texels, 2 * int(view)).xyz;
  up = texelFetch(view_texels, 2 * int(view) + 1).xyz;
  if (flipped == 0) return 1.0;
  right.z = -right.z;
  up.x = -up.x;
  return -1.0;
}

#if CB_PARALLAX > 0
// An outline may show beside itself what stands out of its plane.
const float kParallaxRoom = 1.1;

// ParallaxView of flat_parallax.glsl. eye: in the tile's axes, metres from the capture centre at scale 1.
void parallax_view(vec3 eye, vec4 plane, vec4 place, out vec3 eye_there, out vec3 plane_there) {
  eye_there = vec3((eye.xy / table.scale.x + place.xy) * table.scale.yz, eye.z);
  vec2 slope = plane.xy * table.scale.x / table.scale.yz;
  plane_there = vec3(slope, plane.z - dot(slope, place.xy * table.scale.yz));
}
#endif
