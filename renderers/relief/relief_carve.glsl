// In one axis's map alone everything between the nearest and the farthest surface counts as solid. What another axis shows to
// be air is not.
layout(binding = RELIEF_TEXTURE_BOUNDS) uniform sampler2D bounds_map;  // conservative least and greatest depth

// Whether the next axis or the one after shows air at p, in the map's (u, v, depth). Their (u, v, depth) are turns of the
// march's: its axis's depth is the next axis's v and the one after's u.
bool is_carved(vec3 p, Map map) {
  int half_size = map.size >> 1;
  ivec2 low1 = map_low(map, map.axis == 2 ? 0 : map.axis + 1) >> 1;
  ivec2 low2 = map_low(map, map.axis == 0 ? 2 : map.axis - 1) >> 1;
  vec2 next = texelFetch(bounds_map, clamp(low1 + ivec2(p.yz * float(half_size)), low1, low1 + (half_size - 1)), 0).rg;
  vec2 last = texelFetch(bounds_map, clamp(low2 + ivec2(p.zx * float(half_size)), low2, low2 + (half_size - 1)), 0).rg;
  COUNT_TAP;
  COUNT_TAP;
  return p.x < next.x || p.x > next.y || p.y < last.x || p.y > last.y;
}
