// search=cone: adaptive, passing over steps that the texel's cones show to be air; relief_cone.h says what the cones promise.
#ifdef CARVE
#include "renderers/relief/relief_carve.glsl"
#endif

layout(binding = RELIEF_TEXTURE_CONES) uniform sampler2D cone_map;  // roots of the approaching and leaving cone, up and down

// Approaching and leaving cone of a texel.
vec2 cones_of(vec4 tap, bool down) {
  vec2 root = down ? tap.zw : tap.xy;
  return root * root;
}

// Depth that a ray of `slope` (across over along) may gain from depth c above or below a texel's [front, back] without
// passing through a surface; 2: it meets none.
float cone_reach(vec2 cones, vec2 bounds, float c, float slope, float texel) {
  float before = bounds.x - c;
  float behind = c - bounds.y;
  float reach = 0.0;
  if (before > 0.0) reach = (cones.x * before - texel) / (slope + cones.x + 1e-6);
  if (behind > 0.0) {
    float room = cones.y * behind - texel;
    reach = max(reach, slope > cones.y ? room / (slope - cones.y) : room >= 0.0 ? 2.0 : 0.0);
  }
  return reach;
}

Hit search(Ray ray, Map map) {
  ivec2 low = map_low(map, map.axis);
  ivec2 high = low + (map.size - 1);
  vec2 start = vec2(low) + ray.from.xy * float(map.size);
  vec2 across = ray.delta.xy * float(map.size);
  int steps = steps_across(ray, across);
  float inverse_steps = 1.0 / float(steps);
  vec2 move = across * inverse_steps;
  float rise = (ray.delta.z + EARLIER) * inverse_steps;
  vec2 at = start + 0.5 * move;
  float c = ray.from.z - EARLIER - SLACK;
  float slope = max(abs(ray.delta.x), abs(ray.delta.y)) / max(ray.delta.z, 1e-20);
  float a_step = 1.0 / max(rise, 1e-20);
  int skipped = 0;  // steps between the last one tested and this one
  int behind = 0;   // the same of a step that began inside a surface
  Hit hit = nothing(map);
  // Nested, as in relief_adaptive.glsl.
  int i = 0;
  while (i < steps) {
    float enter = -1.0;
    at = start + (float(i) + 0.5) * move;
    skipped = 0;
    while (i < steps && enter < 0.0) {
      hit.texel = clamp(ivec2(at), low, high);
      vec2 bounds = texelFetch(depth_map, hit.texel, 0).rg;
      COUNT_TAP;
      if (ray.down) bounds = 1.0 - bounds.yx;
      float from_here = max(bounds.x, c);
      int ahead = 1;
      if (from_here <= min(bounds.y, c + rise + 2.0 * SLACK)) {
        enter = max(from_here, 0.0);
        behind = c > bounds.x ? skipped : 0;
      } else {
        COUNT_TAP;
        float reach = cone_reach(cones_of(texelFetch(cone_map, hit.texel, 0), ray.down), bounds, c + 0.5 * rise, slope,
                                 1.0 / float(map.size));
        // The last step is always tested: a skip may end beyond the box in a surface.
        ahead = reach >= 2.0 ? steps - i : max(1, min(int(0.5 + reach * a_step), steps - 1 - i));
      }
      skipped = ahead - 1;
      i += ahead;
      c += float(ahead) * rise;
      at += float(ahead) * move;
    }
    if (enter < 0.0) break;
    // Where a skip ended inside, the surface lies behind: between the last step tested and this one. (A loop that most
    // rays leave at once: unrolled, or inside the other one, it would cost every ray its taps.)
    float below = float(i - 1 - behind);
    float above = float(i - 1);
    for (int k = behind > 0 ? 0 : BINARY; k < BINARY; ++k) {
      float middle = 0.5 * (below + above);
      float depth = ray.from.z - EARLIER + middle * rise;
      ivec2 there = clamp(ivec2(start + middle * move), low, high);
      vec2 bounds = texelFetch(depth_map, there, 0).rg;
      COUNT_TAP;
      if (ray.down) bounds = 1.0 - bounds.yx;
      if (bounds.x - SLACK <= depth && depth <= bounds.y + SLACK) {
        above = middle;
        hit.texel = there;
        enter = depth;
        at = start + (middle + 1.0) * move;
      } else {
        below = middle;
      }
    }
#ifdef CARVE
    if (is_carved(vec3((at - move - vec2(low)) / float(map.size), ray.down ? 1.0 - enter : enter), map)) continue;
#endif
    hit.depth = enter;
    break;
  }
  return hit;
}
