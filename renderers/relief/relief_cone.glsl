// How far search=cone may go; relief_cone.h says what the cones promise.

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
