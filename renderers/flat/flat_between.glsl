// Between two stored frames: the pictures of both, each moved to where the surface is at this moment.
//
// Based on: image interpolation by motion vectors (flat_motion.cpp says where they come from and what differs).
// CB_BETWEEN: 1 both frames as they are, averaged; 2 the nearer frame, moved, and where it hides the surface
// the farther one; 3 both, moved and averaged.

#if CB_BETWEEN > 1
layout(binding = CB_FLAT_TEXTURE_MOTION) uniform sampler2DArray motion_map;
#endif

struct Between {
  vec4 motion;         // from texels of the nearer frame's page times table.motion.y to those of its motion's; layer; share
  vec4 motion_bounds;  // texels of the motion's page that belong to the tile: low, high
  vec4 other;          // from page coordinates of the nearer frame to those of the farther; layer; 1 where the nearer is the later
  vec4 other_bounds;   // page coordinates of the gutter's texels of the farther frame: low, high
};

// Where the surface that is seen at `at` lies in either frame, page coordinates of each, and what it counts for there.
struct InFrames {
  vec2 nearer, farther;
  float near_weight, far_weight;
  float cover;  // what the coverage found counts for: less where nothing is half-way
};

#if CB_BETWEEN > 1
const int kMotionSteps = 2;

vec4 motion_at(vec2 at, Between between) {
  vec2 texel = at / table.scale.yz * table.motion.y + between.motion.xy;
  ivec2 place = ivec2(clamp(texel, between.motion_bounds.xy, between.motion_bounds.zw));
  return texelFetch(motion_map, ivec3(place, int(between.motion.z)), 0) * 255.0;
}

// Page coordinates, from half-way to a frame.
vec2 displacement(vec2 code) {
  return vec2((floor(code.x * 0.5 + 0.25) - 64.0) / 63.0, (code.y - 128.0) / 127.0) * table.motion.x * table.scale.yz;
}
bool hidden(float code) { return fract(code * 0.5 + 0.25) > 0.5; }
#endif

InFrames in_frames(vec2 at, Between between) {
  float share = between.motion.w;
#if CB_BETWEEN > 1
  bool later = between.other.w > 0.5;
  float still = 1.0 - 2.0 * share;  // of the way from half-way to the nearer frame
  // The point that will be, or was, half-way at `there` is at `there` plus `still` of its motion now.
  vec2 there = at;
  vec4 code;
  for (int i = 0; i < kMotionSteps; ++i) {
    code = motion_at(there, between);
    there = at - still * displacement(later ? code.zw : code.xy);
  }
  code = motion_at(there, between);
  code = later ? code.zwxy : code;
  bool in_near = !hidden(code.x);
  bool in_far = !hidden(code.z);
  bool air = !in_near && !in_far;
  float seen = in_near || !in_far ? 1.0 : still;
  return InFrames(at + (1.0 - still) * displacement(code.xy), there + displacement(code.zw) + between.other.xy,
                  (1.0 - share) * seen, in_far ? share : 0.0, air ? 2.0 * still - 1.0 : 1.0);
#else
  return InFrames(at, at + between.other.xy, 1.0 - share, share, 1.0);
#endif
}
