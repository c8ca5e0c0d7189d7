#version 450 core
// Poses the boxes of the listed agents, once a frame: the vertex shader then only places corners, and what the fragment
// shader needs of a box is computed once a box.
#include "renderers/shaders/frame.glsl"
#include "renderers/relief/relief_records.glsl"

layout(local_size_x = 64) in;

layout(std430, binding = CB_STORAGE_PALETTE) readonly restrict buffer Palette { vec4 palette[]; };
layout(std430, binding = RELIEF_STORAGE_BOXES) readonly restrict buffer Boxes { BoxRecord boxes[]; };
layout(std430, binding = RELIEF_STORAGE_POSED) writeonly restrict buffer Posed { PosedBox posed[]; };
#ifdef HULL
layout(std430, binding = RELIEF_STORAGE_POINTS) readonly restrict buffer Points { vec4 points[]; };
#endif

layout(location = RELIEF_LOCATION_COUNT) uniform uint count;
layout(location = RELIEF_LOCATION_OFFSET) uniform uint offset;

#ifdef HULL
// The outline of the box's hull on the screen: CORNERS support lines around it, the first across the projected longest edge (or
// halfway to the next, when that encloses less). A hull that reaches behind the near plane gets the whole screen. False: all
// of it lies behind.
bool outline(uint item, uint box, mat3 linear, vec3 centre, float depth, vec3 edges) {
  vec2 middle = centre.xy / depth;
  float nearest = 1e30;
  float farthest = -1e30;
  vec2 q[RELIEF_HULL_POINTS];
  for (int i = 0; i < RELIEF_HULL_POINTS; ++i) {
    vec3 p = linear * (points[box * uint(RELIEF_HULL_POINTS) + uint(i)].xyz - 0.5) + centre;
    nearest = min(nearest, -p.z);
    farthest = max(farthest, -p.z);
    q[i] = p.xy / max(-p.z, 1e-20) - middle;
  }
  if (farthest < frame.lens.x) return false;
  vec2 corners[CORNERS];
  if (nearest < 1.0001 * frame.lens.x) {
    vec2 screen = frame.lens.z * vec2(frame.lens.w, 1.0);
    for (int k = 0; k < CORNERS; ++k) {
      int quarter = k * 4 / CORNERS;
      corners[k] = screen * vec2(quarter == 0 || quarter == 3 ? 1.0 : -1.0, quarter < 2 ? 1.0 : -1.0) - middle;
    }
  } else {
    vec3 longest = edges.x >= edges.y && edges.x >= edges.z ? linear[0] : edges.y >= edges.z ? linear[1] : linear[2];
    vec2 along = longest.xy * depth + centre.xy * longest.z;  // of the quotient x / depth, up to a factor
    float len = length(along);
    vec2 d = len > 1e-12 * depth ? along / len : vec2(1.0, 0.0);
    const float h = 0.70710678;
    vec2 e = h * vec2(d.x - d.y, d.x + d.y);  // d turned by an eighth
    vec4 high = vec4(-1e30);
    vec4 low = vec4(1e30);
    for (int i = 0; i < RELIEF_HULL_POINTS; ++i) {
      vec4 x = vec4(dot(q[i], d), dot(q[i], e), dot(q[i], vec2(-d.y, d.x)), dot(q[i], vec2(-e.y, e.x)));
      high = max(high, x);
      low = min(low, x);
    }
    vec4 span = high - low;
#if CORNERS == 8
    float extents[8] = float[8](high.x, high.y, high.z, high.w, -low.x, -low.y, -low.z, -low.w);
    const float turn_sine = h;
#else
    bool turned = span.y * span.w < span.x * span.z;
    if (turned) d = e;
    float extents[4] = float[4](turned ? high.y : high.x, turned ? high.w : high.z, turned ? -low.y : -low.x,
                                turned ? -low.w : -low.z);
    const float turn_sine = 1.0;
#endif
    vec2 from = d;
    for (int k = 0; k < CORNERS; ++k) {
#if CORNERS == 8
      vec2 to = h * vec2(from.x - from.y, from.x + from.y);
#else
      vec2 to = vec2(-from.y, from.x);
#endif
      corners[k] = (extents[k] * vec2(to.y, -to.x) - extents[(k + 1) % CORNERS] * vec2(from.y, -from.x)) / turn_sine;
      from = to;
    }
  }
  for (int k = 0; k < CORNERS / 2; ++k) posed[item].corners[k] = vec4(corners[2 * k], corners[2 * k + 1]);
  return true;
}
#endif

void main() {
  uint item = gl_GlobalInvocationID.x;
  if (item >= count * uint(BOXES)) return;
  uint agent = item / uint(BOXES);
  uint index = item - agent * uint(BOXES);
  uvec4 maps = boxes[index].maps;
  uint first = (offset + agent) * uint(JOINTS);
  mat3x4 rows_of_bind = mat3x4(0.0);  // of world space from bind space, by the mean matrix
  mat3x4 rows_of_unit = mat3x4(0.0);  // of world space from the box
  vec3 lights[4] = vec3[4](vec3(0.0), vec3(0.0), vec3(0.0), vec3(0.0));
  for (int k = 0; k < RELIEF_SHARES; ++k) {
    if (boxes[index].weights[k] <= 0.0) break;
    uint matrix = (first + boxes[index].joints[k]) * 3u;
    vec3 toward = vec3(0.0);
    for (int row = 0; row < 3; ++row) {
      vec4 of_joint = palette[matrix + uint(row)];
      rows_of_bind[row] += boxes[index].weights[k] * of_joint;
      rows_of_unit[row] += of_joint * boxes[index].movers[k];
      toward += frame.light_direction[row] * of_joint.xyz;
    }
    for (int c = 0; c < 4; ++c) lights[c] += toward * boxes[index].movers[k][c].w;
  }
  mat4 world_from_bind =
      transpose(mat4(rows_of_bind[0], rows_of_bind[1], rows_of_bind[2], vec4(0.0, 0.0, 0.0, 1.0)));
  mat4 world_from_unit =
      transpose(mat4(rows_of_unit[0], rows_of_unit[1], rows_of_unit[2], vec4(0.0, 0.0, 0.0, 1.0)));
  mat4 eye_from_unit = frame.view_from_world * world_from_unit;

  mat3 linear = mat3(eye_from_unit);
  vec3 origin = eye_from_unit[3].xyz;
  vec3 edges = vec3(length(linear[0]), length(linear[1]), length(linear[2]));
  // Relative to the edges, so that "flattened" does not depend on the character's size.
  float volume = determinant(linear);
  bool drawn = abs(volume) > 1e-12 * edges.x * edges.y * edges.z;
  mat3 unit_from_eye = drawn ? inverse(linear) : mat3(0.0);
  vec3 eye = -(unit_from_eye * origin);
  vec3 centre = linear * vec3(0.5) + origin;

  // One texel of the longest edge to a pixel, at the box's depth.
  float longest = max(edges.x, max(edges.y, edges.z));
  float depth = max(-centre.z, 2.0 * frame.lens.x);
  float pixel = 2.0 * depth * frame.lens.z * frame.viewport.w;
  float wanted = log2(max(pixel * float(maps.z) / longest, 1e-6));
  float most = float(maps.w - 2u);  // 8 texels a side
  float level = clamp(floor(wanted + LEVEL_BIAS), 0.0, most);
  // Levels of colours, in sixteenths.
  uint colour_level = uint(clamp(wanted * 16.0, 0.0, 127.0));

  mat3 turned = mat3(world_from_bind);
  vec3 lengths = vec3(dot(turned[0], turned[0]), dot(turned[1], turned[1]), dot(turned[2], turned[2]));
  vec3 skew = abs(vec3(dot(turned[0], turned[1]), dot(turned[1], turned[2]), dot(turned[2], turned[0])));
  float stretch = max(lengths.x, max(lengths.y, lengths.z));
  bool angles_kept = min(lengths.x, min(lengths.y, lengths.z)) > 0.98 * stretch &&
                     max(skew.x, max(skew.y, skew.z)) < 0.01 * stretch;
#ifdef HULL
  drawn = drawn && outline(item, index, linear, centre, depth, edges);
  posed[item].frame[0] = vec4(depth * unit_from_eye[0], centre.x / depth);
  posed[item].frame[1] = vec4(depth * unit_from_eye[1], centre.y / depth);
  posed[item].frame[2] = vec4(0.5 - unit_from_eye[2] * (depth + centre.z), 0.0);
#else
  mat4 rows = transpose(eye_from_unit);
  posed[item].frame[0] = rows[0];
  posed[item].frame[1] = rows[1];
  posed[item].frame[2] = rows[2];
#endif
  posed[item].eye_depth = vec4(eye, drawn ? depth : -1.0);
  posed[item].light = vec4(frame.light_direction.xyz * turned * inversesqrt(max(stretch, 1e-30)),
                           (volume < 0.0 ? -2.0 : 0.0) + (angles_kept ? 0.0 : 1.0));
  vec3 view = transpose(mat3(frame.view_from_world)) * -centre * turned;
  // Nearby, steps of a quarter of a pixel, between one and half a texel of level 0.
#ifdef CARVE
  float a_texel = clamp(4.0 * exp2(level - wanted), 1.0, level > 0.0 ? 1.0 : 2.0);
#else
  const float a_texel = 1.0;
#endif
  posed[item].view = vec4(view * inversesqrt(max(dot(view, view), 1e-30)), a_texel);
  posed[item].maps = uvec4(pack_maps(maps.x, maps.y, maps.z, uint(level)),
                           packUnorm4x8(vec4(edges / longest, 0.0)) | (angles_kept ? 0u : 1u << 24u) | colour_level << 25u,
                           maps.y);
  for (int k = 0; k < 3; ++k) posed[item].turn[k] = vec4(rows_of_bind[k].xyz, 0.0);
  for (int k = 0; k < 4; ++k) posed[item].lights[k] = vec4(lights[k], 0.0);
}
