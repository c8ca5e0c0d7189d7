// search=linear: the source's. STEPS equal steps, each tested as a point, then BINARY halvings between the first one inside and
// the one before it.
Hit search(Ray ray, Map map) {
  ivec2 low = map_low(map, map.axis);
  ivec2 high = low + (map.size - 1);
  vec2 start = vec2(low) + ray.from.xy * float(map.size);
  vec2 across = ray.delta.xy * float(map.size);
  Hit hit = nothing(map);
  float below = 0.0;
  for (int i = 0; i <= STEPS; ++i) {
    float t = float(i) / float(STEPS);
    float c = ray.from.z + ray.delta.z * t;
    hit.texel = clamp(ivec2(start + across * t), low, high);
    vec2 bounds = texelFetch(depth_map, hit.texel, 0).rg;
    COUNT_TAP;
    if (ray.down) bounds = 1.0 - bounds.yx;
    if (bounds.x - SLACK <= c && c <= bounds.y + SLACK) {
      float above = t;
      for (int k = 0; k < BINARY; ++k) {
        float middle = 0.5 * (below + above);
        c = ray.from.z + ray.delta.z * middle;
        ivec2 there = clamp(ivec2(start + across * middle), low, high);
        bounds = texelFetch(depth_map, there, 0).rg;
        COUNT_TAP;
        if (ray.down) bounds = 1.0 - bounds.yx;
        if (bounds.x - SLACK <= c && c <= bounds.y + SLACK) {
          above = middle;
          hit.texel = there;
        } else {
          below = middle;
        }
      }
      hit.depth = ray.from.z + ray.delta.z * above;
      break;
    }
    below = t;
  }
  return hit;
}
