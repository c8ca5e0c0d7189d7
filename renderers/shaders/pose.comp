#version 450 core
// Poses the listed agents once a frame: blends the two bank samples of each and puts the agent's place into the result,
// so that every later stage fetches one matrix a joint: camera-relative world from bind space.
#include "renderers/shaders/frame.glsl"

layout(local_size_x = 64) in;
layout(std430, binding = CB_STORAGE_POSE_BANK) readonly restrict buffer Bank { vec4 bank[]; };
layout(std430, binding = CB_STORAGE_PALETTE) writeonly restrict buffer Palette { vec4 palette[]; };
layout(location = CB_LOCATION_FIRST) uniform uint first;
layout(location = CB_LOCATION_JOINTS) uniform uint joints;
layout(location = CB_LOCATION_COUNT) uniform uint count;

void main() {
  uint item = gl_GlobalInvocationID.x;
  if (item >= count * joints) return;
  uint agent = item / joints;
  uint joint = item - agent * joints;
  AgentRecord record = agents[list[first + agent]];
  uint a = (record.pose.x * joints + joint) * 3u;
  uint b = (record.pose.y * joints + joint) * 3u;
  float blend = record.heading_blend.z;
  vec4 row0 = mix(bank[a], bank[b], blend);
  vec4 row1 = mix(bank[a + 1u], bank[b + 1u], blend);
  vec4 row2 = mix(bank[a + 2u], bank[b + 2u], blend);
  float scale = record.position_scale.w;
  float s = record.heading_blend.x * scale;
  float c = record.heading_blend.y * scale;
  uint to = item * 3u;
  palette[to] = c * row0 + s * row2 + vec4(0.0, 0.0, 0.0, record.position_scale.x);
  palette[to + 1u] = scale * row1 + vec4(0.0, 0.0, 0.0, record.position_scale.y);
  palette[to + 2u] = c * row2 - s * row0 + vec4(0.0, 0.0, 0.0, record.position_scale.z);
}
