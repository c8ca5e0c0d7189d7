// What every shader may know of the frame. World space here is relative to the eye (Frame::origin), in metres.
#include "renderers/shaders/bindings.shared.h"

layout(std140, binding = CB_UNIFORM_FRAME) uniform FrameUniforms {
  mat4 clip_from_world;   // projection * view rotation: reversed depth
  mat4 view_from_world;   // a rotation: rows are right, up, backward
  mat4 projection;
  vec4 light_direction;   // xyz towards the light, unit
  vec4 light;             // ambient, diffuse
  vec4 viewport;          // width, height, 1 / width, 1 / height, pixels of the picture, however many samples each has
  vec4 lens;              // near, far (0 = infinite), tan(fov_y / 2), aspect
  vec4 background;        // linear
  vec4 ground_origin;     // xz: the eye's place on the ground within a grid cell, y: the eye's height, metres
} frame;

struct AgentRecord {
  vec4 position_scale;  // relative to the eye; uniform scale
  vec4 heading_blend;   // sin, cos of the heading; blend of the pose's samples; phase in [0, 1)
  uvec4 pose;           // sample a, sample b, bank clip, unused
  uvec4 identity;       // outfit, id, bank clip, unused
};
layout(std430, binding = CB_STORAGE_AGENTS) readonly restrict buffer Agents { AgentRecord agents[]; };
layout(std430, binding = CB_STORAGE_LIST) readonly restrict buffer List { uint list[]; };

layout(binding = CB_TEXTURE_AGENTS) uniform samplerBuffer agent_texels;
vec4 agent_position_scale(uint agent) { return texelFetch(agent_texels, int(agent) * 4); }
vec4 agent_heading_blend(uint agent) { return texelFetch(agent_texels, int(agent) * 4 + 1); }
// Outfit, id and bank clip.
uvec3 agent_identity(uint agent) { return floatBitsToUint(texelFetch(agent_texels, int(agent) * 4 + 3).xyz); }

// A model-space vector turned by the agent's heading: +Z goes to (sin, 0, cos).
vec3 turn(vec3 v, vec2 heading) {
  return vec3(heading.y * v.x + heading.x * v.z, v.y, heading.y * v.z - heading.x * v.x);
}
