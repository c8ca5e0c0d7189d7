// search=adaptive of the nearest tier: intervals, one or two a texel crossed, the first that meets a texel's [front, back] where
// no other axis's map shows air.
#include "renderers/relief/relief_carve.glsl"

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
  float half_step = 0.5 * rise + SLACK;
  vec2 mirror = ray.down ? vec2(1.0, -0.5) : vec2(0.0, 0.5);
  Hit hit = nothing(map);
  // Nested, since a branch costs its whole content on every step where lanes run together: the inner loop takes one tap a
  // step, the outer one looks at what it found.
  int i = 0;
  while (i < steps) {
    float enter = -1.0;
    for (; i < steps && enter < 0.0; ++i) {
      hit.texel = clamp(ivec2(at), low, high);
      vec2 bounds = texelFetch(depth_map, hit.texel, 0).rg;
      COUNT_TAP;
      // Two intervals meet when their middles lie no farther apart than their halves' sum.
      float half_solid = 0.5 * (bounds.y - bounds.x);
      float middle = mirror.x + mirror.y * (bounds.x + bounds.y);
      if (half_solid >= 0.0 && abs(middle - (c + half_step)) <= half_solid + half_step)
        enter = max(max(middle - half_solid, c), 0.0);
      c += rise;
      at += move;
    }
    if (enter < 0.0) break;
    if (is_carved(vec3((at - move - vec2(low)) / float(map.size), ray.down ? 1.0 - enter : enter), map)) continue;
    hit.depth = enter;
    break;
  }
  return hit;
}
