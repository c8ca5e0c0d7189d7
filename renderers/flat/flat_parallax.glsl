// Depth-corrected reprojection of a stored view: the picture that lies on a tile's polygon is of another direction than the
// eye's, and what stands out of the polygon is seen elsewhere from here. The stored depths say where.
//
// Based on: parallax mapping (Kaneko et al. 2001) along the eye's own ray, iterated.
// Differs from the source, and why: the steps after the first go half of their way, since at an outline depths jump, and whole
// steps go to and fro between its two sides.

// In a tile's page coordinates, metres along its axis toward the eye: where the eye is, and the height of the polygon as
// dot(plane, (place, 1)).
struct ParallaxView {
  vec3 eye;
  vec3 plane;
};

// Where the ray that passes the polygon at `start` meets the surface that the depths describe, and how much nearer to the eye
// than the polygon that is, metres. Where nothing is stored the capture plane stands for it. whole: metres of a whole depth.
// Between stored frames the depths are those of the nearer one, moved.
vec2 met_at(vec2 start, float layer, ParallaxView view, vec4 bounds, float whole,
#if CB_BETWEEN > 0
            Between between,
#endif
            out float rise) {
  float height = dot(view.plane, vec3(start, 1.0));
  vec2 shift = (view.eye.xy - start) / max(view.eye.z - height, 1e-3);
  vec2 at = start;
  rise = 0.0;
  for (int i = 0; i < CB_PARALLAX; ++i) {
#if CB_BETWEEN > 0
    vec2 there = in_frames(at, between).nearer;
#else
    vec2 there = at;
#endif
    float found = (surface_at(vec3(clamp(there, bounds.xy, bounds.zw), layer)).a * 255.0 - 128.0) / 127.0 * whole - height;
    rise = mix(rise, found, i == 0 ? 1.0 : 0.5);
    at = start + rise * shift;
  }
  return at;
}
