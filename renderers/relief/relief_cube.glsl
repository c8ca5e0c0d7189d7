// projection=cube: each face's map is seen from the box's middle, depths are of the way from there to the face. A straight ray
// crosses several faces' maps, in steps of as many texels as are wanted at the distance from the middle where it is: the step's
// interval of distances against what the texel at its middle stores.

// The face under a point relative to the box's middle, 0 to 5 (axis x 2 + side), with the place on it in xy, in [-1, 1], and the
// distance from the middle in z, 1 on the box.
int cube_face(vec3 q, out vec3 place) {
  vec3 away = abs(q);
  int axis = away.x >= away.y && away.x >= away.z ? 0 : (away.y >= away.z ? 1 : 2);
  vec3 p = along_axis(q, axis);
  float out_by = max(abs(p.z), 1e-6);
  place = vec3(p.xy / out_by, out_by);
  return 2 * axis + (p.z > 0.0 ? 1 : 0);
}

// First texel of a face's map in the depth picture, which is as wide as the colours'.
ivec2 cube_low(Map map, int face) { return map.corner + ivec2(map.left + face * map.texels, 0); }

float distance_out(vec3 q) { return max(max(abs(q.x), abs(q.y)), abs(q.z)); }

Hit search(Ray ray, Map map) {
  // From the map's frame to the box's: along_axis() undone, middle at 0.
  vec3 from = 2.0 * ray.from - 1.0;
  vec3 delta = 2.0 * ray.delta;
  if (ray.down) {
    from.z = -from.z;
    delta.z = -delta.z;
  }
  from = map.axis == 0 ? from.zxy : map.axis == 1 ? from.yzx : from;
  delta = map.axis == 0 ? delta.zxy : map.axis == 1 ? delta.yzx : delta;
  float fastest = max(distance_out(delta), 1e-20);
  float a_step = 2.0 / (float(map.size) * ray.steps_a_texel * fastest);
  Hit hit = nothing(map);
  float t = 0.0;
  float before = distance_out(from);
  bool met = false;
  for (int i = 0; i < STEPS && t < 1.0 && !met; ++i) {
#ifdef RELIEF_FLOOR
    float step_by = 1.0;
#else
    // Near the middle texels are ever smaller; what is nearer than an eighth is passed in steps of an eighth's.
    float step_by = min(max(before, 0.125) * a_step, 1.0 - t + 1e-6);
#endif
    vec3 place;
    int face = cube_face(from + (t + 0.5 * step_by) * delta, place);
    float after = distance_out(from + (t + step_by) * delta);
    ivec2 low = cube_low(map, face);
    hit.texel = clamp(low + ivec2((0.5 * place.xy + 0.5) * float(map.size)), low, low + (map.size - 1));
    vec2 bounds = texelFetch(depth_map, hit.texel, 0).rg;
    COUNT_TAP;
    float least = min(min(before, after), place.z) - SLACK;
    float most = max(before, after) + SLACK;
    met = bounds.x <= bounds.y && least <= bounds.y && bounds.x <= most;
    if (met) {
      // Where within the step the distance is the surface's.
      float at = before > bounds.y ? before - bounds.y : before < bounds.x ? bounds.x - before : 0.0;
      hit.depth = max(ray.from.z + ray.delta.z * (t + step_by * clamp(at / max(abs(after - before), 1e-6), 0.0, 1.0)), 0.0);
      hit.solid = bounds;
    }
    t += step_by;
    before = after;
  }
  return hit;
}
