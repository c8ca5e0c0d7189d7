// The march finds the point; which of the six faces stores the surface there is another matter: a column's side wall belongs to
// another axis.
//
// `Face face_at(point, direction, down, map, hit)`: the face whose stored depth is nearest to the point (unit coordinates) that
// a ray of the direction met, as searched in `map`.
struct Face {
  int axis;
  int side;     // 0: seen from the low face
  ivec2 texel;  // of the depth picture
  vec4 normal;  // as stored, with the slot
};

// The colour and normal pictures hold two maps where the depth picture holds one.
vec4 normal_at(Map map, ivec2 texel, int axis, int side) {
  return texelFetch(normal_map, texel + ivec2(map.left + (axis + side) * map.texels, 0), 0);
}

#ifdef CUBE

// The map that the point was found in: there is one of each place of the skin.
Face face_at(vec3 point, vec3 direction, bool down, Map map, Hit hit) {
  int face = (hit.texel.x - map.corner.x - map.left) / map.texels;
  return Face(face >> 1, face & 1, hit.texel, texelFetch(normal_map, hit.texel, 0));
}

#elif !defined(ATTRIBUTE)

// The floor: the one that the ray was searched in.
Face face_at(vec3 point, vec3 direction, bool down, Map map, Hit hit) {
  int side = down ? 1 : 0;
  return Face(map.axis, side, hit.texel, normal_at(map, hit.texel, map.axis, side));
}

#elif defined(PLAIN)

// As below, from the march's axis on, whose depths are known already.
Face face_at(vec3 point, vec3 direction, bool down, Map map, Hit hit) {
  vec3 edges = unpackUnorm4x8(v_maps.z).xyz;
  vec3 reach = max(abs(direction), 1e-20);
  bvec3 forward = greaterThan(direction, vec3(0.0));
  int axis = map.axis;
  vec3 p = along_axis(point, axis);
  vec3 edge = axis == 0 ? edges : axis == 1 ? edges.yzx : edges.zxy;
  vec3 facing = axis == 0 ? reach : axis == 1 ? reach.yzx : reach.zxy;
  facing *= 1.0 / facing.x;
  bvec3 ahead = axis == 0 ? forward : axis == 1 ? forward.yzx : forward.zxy;
  vec2 miss = (abs(p.z - hit.solid) + (ahead.x ? vec2(0.0, 0.04) : vec2(0.04, 0.0))) * edge.x;
  Face face = Face(axis, miss.x <= miss.y ? 0 : 1, hit.texel, vec4(0.0));
  float nearest = min(miss.x, miss.y);
  for (int j = 1; j < 3; ++j) {
    p = p.yzx;
    int k = map.axis + j;
    k -= k > 2 ? 3 : 0;
    ivec2 there = map_low(map, k) + clamp(ivec2(p.xy * float(map.size)), ivec2(0), ivec2(map.size - 1));
    vec2 bounds = texelFetch(depth_map, there, 0).rg;
    float turned = 0.02 * facing[j];
    miss = (abs(p.z - bounds) + (ahead[j] ? vec2(0.02 - turned, 0.02 + turned) : vec2(0.02 + turned, 0.02 - turned))) * edge[j];
    if (bounds.x <= bounds.y && min(miss.x, miss.y) < nearest) {
      nearest = min(miss.x, miss.y);
      face.axis = k;
      face.side = miss.x <= miss.y ? 0 : 1;
      face.texel = there;
    }
  }
  face.normal = normal_at(map, face.texel, face.axis, face.side);
  return face;
}

#else

Face face_at(vec3 point, vec3 direction, bool down, Map map, Hit hit) {
  vec3 edges = unpackUnorm4x8(v_maps.z).xyz;
  vec3 reach = max(abs(direction), 1e-20);
  bvec3 forward = greaterThan(direction, vec3(0.0));
  Face face = Face(map.axis, down ? 1 : 0, hit.texel, vec4(0.5, 1.0, 0.5, 0.0));
  float nearest = 1e30;
  for (int k = 0; k < 3; ++k) {
    vec3 p = along_axis(point, k);
    ivec2 left = map_low(map, k);
    // The march's own texel: the point may lie in the next one, by rounding or by half a step.
    ivec2 there = k == map.axis ? hit.texel : clamp(left + ivec2(p.xy * float(map.size)), left, left + (map.size - 1));
    vec2 bounds = texelFetch(depth_map, there, 0).rg;
    if (bounds.x > bounds.y) continue;
    // In metres of the longest edge. A face that the ray grazes costs a little; one that looks away, as at the rim of a round
    // limb, a little more.
    float facing = reach[k] / reach[map.axis];
    vec2 miss = (abs(p.z - bounds) + (forward[k] ? vec2(0.02 * (1.0 - facing), 0.02 * (1.0 + facing))
                                                 : vec2(0.02 * (1.0 + facing), 0.02 * (1.0 - facing)))) * edges[k];
    int nearer = miss.x <= miss.y ? 0 : 1;
    float cost = min(miss.x, miss.y);
#ifdef CARVE
    vec4 seen = normal_at(map, there, k, nearer);
    // What looks away from the eye is not what the ray met, if anything else will do.
    cost += dot(seen.xyz * 2.0 - 1.0, v_view) < 0.0 ? 0.1 : 0.0;
#endif
    if (cost < nearest) {
      nearest = cost;
      face.axis = k;
      face.side = nearer;
      face.texel = there;
#ifdef CARVE
      face.normal = seen;
#endif
    }
  }
#ifndef CARVE
  face.normal = normal_at(map, face.texel, face.axis, face.side);
#endif
  return face;
}

#endif
