#version 450 core
// One figure an agent: its view, the two stored frames around its phase, the transform of the view's plane, and the
// command that draws its polygons. Where images change from step to step, two: the second draws the neighbouring step's
// images while they fade, and nothing else.
#include "renderers/shaders/dither.shared.h"
#include "renderers/shaders/frame.glsl"
#include "renderers/polypostor/polypostor.shared.h"
#include "renderers/impostor/views/view_grid.glsl"

layout(local_size_x = CB_POLYPOSTOR_GROUP) in;
layout(location = CB_LOCATION_COUNT) uniform uint count;
layout(location = CB_POLYPOSTOR_LOCATION_LEVELS) uniform uint first_of_level[CB_POLYPOSTOR_LEVELS];

layout(std430, binding = CB_POLYPOSTOR_STORAGE_TABLE) readonly restrict buffer Table {
  vec4 centre;   // capture centre, model space, metres; metres a unit of x and y
  ivec4 grid;    // as pick_view takes them
  vec4 span;
  uvec4 counts;  // views, clips, levels, ranges by frame
  vec4 units;    // metres a unit of z
  uvec4 clips[CB_POLYPOSTOR_CLIPS];  // x: frames
  vec4 views[];  // right, up of every view
} table;
layout(std430, binding = CB_POLYPOSTOR_STORAGE_SETS) readonly restrict buffer Sets { uvec4 sets[]; };
layout(std430, binding = CB_POLYPOSTOR_STORAGE_RANGES) readonly restrict buffer Ranges { uvec2 ranges[]; };
struct Figure {
  mat4 clip_from_units;  // of the words' positions
  vec4 light_blend;      // towards the light, in the view's axes; from frame a to frame b
  uvec4 pose;            // from a vertex's index to its word in frames a and b; outfit and ranks; id
};
layout(std430, binding = CB_POLYPOSTOR_STORAGE_FIGURES) writeonly restrict buffer Figures { Figure figures[]; };
layout(std430, binding = CB_POLYPOSTOR_STORAGE_COMMANDS) writeonly restrict buffer Commands { uint commands[]; };

// What `figure` draws with the images of `range`, in pixels of the dither's ranks in [low, high).
void store_figure(uint at, Figure figure, uvec2 range, uint first_vertex, uint low, uint high) {
  figure.pose.z |= low << 16u | high << 24u;
  figures[at] = figure;
  bool drawn = low < high;
  commands[at * 5u] = drawn ? range.y : 0u;
  commands[at * 5u + 1u] = drawn ? 1u : 0u;
  commands[at * 5u + 2u] = range.x;
  commands[at * 5u + 3u] = first_vertex;
  commands[at * 5u + 4u] = at;
}

void main() {
  uint slot = gl_GlobalInvocationID.x;
  if (slot >= count) return;
  // Not a loop that slots leave one by one: llvmpipe then loses what the first to leave store here.
  uint level = 0u;
  for (uint l = 1u; l < table.counts.z; ++l)
    if (slot >= first_of_level[l]) level = l;

  AgentRecord agent = agents[list[slot]];
  vec2 heading = agent.heading_blend.xy;
  vec2 back = vec2(-heading.x, heading.y);
  float scale = agent.position_scale.w;
  vec3 centre = agent.position_scale.xyz + scale * turn(table.centre.xyz, heading);
  int flipped;
  uint view = uint(pick_view(turn(-centre, back), table.grid, table.span, flipped));
  vec3 right = table.views[2u * view].xyz;
  vec3 up = table.views[2u * view + 1u].xyz;
  float side = 1.0;
  if (flipped != 0) {
    right.z = -right.z;
    up.x = -up.x;
    side = -1.0;
  }
  vec3 to_eye = cross(right, up);

  uint frames = table.clips[agent.pose.z].x;
  float at = fract(agent.heading_blend.w + (flipped != 0 ? 0.5 : 0.0)) * float(frames);
  uint a = min(uint(at), frames - 1u);
  uint b = a + 1u == frames ? 0u : a + 1u;
  uvec4 set = sets[(level * table.counts.y + agent.pose.z) * table.counts.x + view];
  uvec2 range = ranges[set.z + (table.counts.w != 0u ? a : 0u)];
  float blend = at - float(a);

  float unit = table.centre.w * scale;
  float unit_z = table.units.x * scale;
  vec3 x = turn(right, heading) * (unit * side);
  vec3 y = turn(up, heading) * unit;
  vec3 z = turn(to_eye, heading) * unit_z;
  vec3 origin = centre - 2048.0 * (x + y) - 128.0 * z;
  Figure figure;
  figure.clip_from_units =
      frame.clip_from_world * mat4(vec4(x, 0.0), vec4(y, 0.0), vec4(z, 0.0), vec4(origin, 1.0));
  vec3 light = turn(frame.light_direction.xyz, back);
  figure.light_blend = vec4(side * dot(light, right), dot(light, up), dot(light, to_eye), blend);
#ifdef CB_DEBUG
  figure.light_blend.w += 2.0 * float(level);
#endif
  figure.pose = uvec4(set.x + a * set.y - set.w, set.x + b * set.y - set.w, agent.identity.xy);
  uint border = uint(CB_DITHER_RANKS);
  uvec2 other = range;
  bool ends = true;
  uint place = slot;
  if (table.counts.w != 0u) {
    // The earlier step's images have the lower ranks: all of them at the window's beginning, none at its end.
    ends = blend > 0.5;
    other = ranges[set.z + (ends ? b : a == 0u ? frames - 1u : a - 1u)];
    float past = ends ? blend - 1.0 : blend;  // the pose between, in steps
    float earlier = clamp(0.5 - past / (2.0 * CB_POLYPOSTOR_FADE), 0.0, 1.0);
    if (range != other)
      border = uint(earlier * float(CB_DITHER_RANKS) + 0.5);
    else if (!ends)
      border = 0u;
    place = 2u * slot;
    store_figure(place + 1u, figure, ends ? other : range, set.w, border, uint(CB_DITHER_RANKS));
  }
  store_figure(place, figure, ends ? range : other, set.w, 0u, border);
}
