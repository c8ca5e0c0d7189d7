// search=adaptive of the farther tiers: one interval a texel crossed, the first that meets a texel's [front, back].
//
// A step's interval makes everything thicker by what the ray rises while it is in the next texel already. What is thicker
// than that is made thinner by as much in all; what is not is one surface, which no step may miss. Depths are doubled and not
// mirrored: two intervals meet when their middles lie no farther apart than their halves' sum. The ray was clipped half a
// texel within the map, so that no texel needs clamping.
Hit search(Ray ray, Map map) {
  vec2 start = vec2(map_low(map, map.axis)) + ray.from.xy * float(map.size);
  vec2 across = ray.delta.xy * float(map.size);
  int steps = steps_across(ray, across);
  float inverse_steps = 1.0 / float(steps);
  vec2 move = across * inverse_steps;
  float from = ray.from.z - EARLIER;
  float rise = (ray.delta.z + EARLIER) * inverse_steps;
  vec2 at = start + 0.5 * move;
  float thinner = rise * clamp(max(abs(move.x), abs(move.y)) - 0.5, 0.0, 0.5);
  float thickness = rise + 2.0 * SLACK;
  float grown = thickness - thinner;
  float upward = ray.down ? -rise : rise;
  float middle = 2.0 * (ray.down ? 1.0 - from : from) + upward;
  Hit hit = nothing(map);
  bool met = false;
  int i = 0;
  for (; i < steps && !met; ++i) {
    hit.texel = ivec2(at);
    hit.solid = texelFetch(depth_map, hit.texel, 0).rg;
    COUNT_TAP;
    float thick = hit.solid.y - hit.solid.x;
    met = thick >= 0.0 && abs(hit.solid.x + hit.solid.y - middle) <= max(thick + grown, thickness);
    middle += 2.0 * upward;
    at += move;
  }
  if (met)
    hit.depth = max(max(ray.down ? 1.0 - hit.solid.y : hit.solid.x, from + float(i - 1) * rise - SLACK), 0.0);
  return hit;
}
