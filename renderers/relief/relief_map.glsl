// What a search is given and what it answers.
//
// Every search is a function `Hit search(Ray ray, Map map)`: the first place along the ray, from where it enters the box to
// where it leaves it, that lies in a texel's [front, back]. It reads only depth_map, and what it was given; SLACK, STEPS and
// BINARY are its parameters. It counts its taps (COUNT_TAP), and has one return at its end: what returns from within a loop
// keeps llvmpipe and some GPUs from seeing the loop's exits.
#include "renderers/relief/relief_records.glsl"

// A ray through a box, in the frame of the map that it is searched in: (u, v, depth along the axis), the box [0, 1]^3. Along the
// axis the ray goes up: for one that goes down, the depths are mirrored.
struct Ray {
  vec3 from;            // where it enters
  vec3 delta;           // from there to where it leaves; delta.z >= 0
  float steps_a_texel;  // wanted; searches of whole intervals
  bool down;            // depths of the map, and of the hit, are 1 - what is stored
};

// The depth maps of a box at one level, and the axis whose map is searched. Axis a's lies `texels` right of axis a - 1's.
struct Map {
  int left;      // of the box in the depth picture, level 0
  ivec2 corner;  // first texel of axis 0's map
  int texels;    // a side of level 0
  int size;      // texels a side of this level
  int axis;
};

// A sheet at a plain fraction of a box's depth, as in the middle of one that is symmetric, would lie where two steps of every
// ray meet, and be looked for in both: of a mask that leaves half of it three quarters would show. Steps begin so much earlier.
const float EARLIER = 8.0 * SLACK;  // more than neighbouring steps overlap by

struct Hit {
  float depth;  // along the ray's axis, as the ray has it; below 0: none
  ivec2 texel;  // of the depth picture
  vec2 solid;   // least and greatest depth stored there; relief_plain.glsl alone says so
};

layout(binding = RELIEF_TEXTURE_DEPTH) uniform sampler2D depth_map;    // least and greatest depth along the axis
layout(binding = RELIEF_TEXTURE_NORMAL) uniform sampler2D normal_map;  // bind-space normal, slot

#ifdef DEBUG
int taps = 0;
#define COUNT_TAP ++taps
#else
#define COUNT_TAP
#endif

Map map_of(uvec4 maps) {
  int left = int(maps.x & 65535u);
  return Map(left, ivec2(left, maps.x >> 16u) + ivec2(int(maps.y >> 20u), 0), int(maps.y & 1023u),
             int(maps.y >> 10u & 1023u), 0);
}

// First texel of an axis's map.
ivec2 map_low(Map map, int axis) { return map.corner + ivec2(axis * map.texels, 0); }

// A vector's (u, v, depth) for an axis.
vec3 along_axis(vec3 v, int axis) { return axis == 0 ? v.yzx : axis == 1 ? v.zxy : v; }

Hit nothing(Map map) { return Hit(-1.0, map_low(map, map.axis), vec2(1.0, 0.0)); }

// How many intervals a ray is cut into that crosses so many texels.
int steps_across(Ray ray, vec2 across) {
#ifdef RELIEF_FLOOR
  return 1;
#else
  return clamp(int(ceil(ray.steps_a_texel * max(abs(across.x), abs(across.y)))), 1, STEPS);
#endif
}
