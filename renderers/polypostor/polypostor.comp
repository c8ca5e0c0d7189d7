#version 450 core
// One figure an agent: its view, the two stored frames around its phase, the transform of the view's plane, and the
// command that draws its polygons.
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
  uvec4 pose;            // from a vertex's index to its word in frames a and b; outfit; id
};
layout(std430, binding = CB_POLYPOSTOR_STORAGE_FIGURES) writeonly restrict buffer Figures { Figure figures[]; };
layout(std430, binding = CB_POLYPOSTOR_STORAGE_COMMANDS) writeonly restrict buffer Commands { uint commands[]; };

void main() {
  uint slot = gl_GlobalInvocationID.x;
  if (slot >= count) return;
  uint level = 0u;
  while (level + 1u < table.counts.z && slot >= first_of_level[level + 1u]) ++level;

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
  figure.light_blend = vec4(side * dot(light, right), dot(light, up), dot(light, to_eye), at - float(a));
#ifdef CB_DEBUG
  figure.light_blend.w += 2.0 * float(level);
#endif
  figure.pose = uvec4(set.x + a * set.y - set.w, set.x + b * set.y - set.w, agent.identity.xy);
  figures[slot] = figure;
  commands[slot * 5u] = range.y;
  commands[slot * 5u + 1u] = 1u;
  commands[slot * 5u + 2u] = range.x;
  commands[slot * 5u + 3u] = set.w;
  commands[slot * 5u + 4u] = slot;
}
