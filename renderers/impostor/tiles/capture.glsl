// Captures for bakes: a view an agent, and the maps of a tile (renderers/impostor/tiles/tile.h) in place of a picture. The
// depth target's value is one half at the capture plane, of parallel views.
struct CaptureView {
  vec4 x;  // where w is 1, clip-space x = dot(x, (position, 1)); the same for y and z
  vec4 y;
  vec4 z;
  vec4 w;  // (0, 0, 0, 1) of parallel views
  vec4 place;  // x, y: of the tile on the page, clip space; it is part of x and y, and lies beyond the division by w
};
layout(std430, binding = CB_STORAGE_CAPTURE) readonly restrict buffer CaptureViews { CaptureView capture_views[]; };

vec4 capture_position(CaptureView view, vec3 position) {
  vec4 p = vec4(position, 1.0);
  float w = dot(view.w, p);
  return vec4(dot(view.x, p) + view.place.x * (w - 1.0), dot(view.y, p) + view.place.y * (w - 1.0), dot(view.z, p), w);
}

// To the view's axes; the rows of a view are those axes times a scale of their own.
vec3 capture_normal(CaptureView view, vec3 normal) {
  return vec3(dot(view.x.xyz, normal) * inversesqrt(dot(view.x.xyz, view.x.xyz)),
              dot(view.y.xyz, normal) * inversesqrt(dot(view.y.xyz, view.y.xyz)),
              dot(view.z.xyz, normal) * inversesqrt(dot(view.z.xyz, view.z.xyz)));
}

#ifdef CB_CAPTURE_OUTPUTS
layout(location = 0) out vec4 out_albedo;
layout(location = 1) out vec4 out_surface;
#ifdef CB_EMISSIVE
layout(location = 2) out vec4 out_emission;  // square root of the fraction of the peak
#endif

vec2 encode_signed(vec2 v) { return (clamp(v, -1.0, 1.0) * 127.0 + 128.0) / 255.0; }

void write_capture(vec3 albedo, vec3 normal, uint slot, bool unlit, vec3 emission) {
  vec3 n = normalize(normal);
  // A smooth normal may lean away from the eye at the silhouette; its length then lies in the plane.
  if (n.z < 0.0) n.xy = normalize(n.xy + vec2(1e-8, 0.0));
  out_albedo = vec4(sqrt(clamp(albedo, 0.0, 1.0)), 1.0);
  uint id = min(slot, 0x7fu) | (unlit ? 0x80u : 0u);
  out_surface = vec4(encode_signed(n.xy), float(id) / 255.0, encode_signed(vec2(gl_FragCoord.z * 2.0 - 1.0)).x);
#ifdef CB_EMISSIVE
  out_emission = vec4(sqrt(clamp(emission, 0.0, 1.0)), 1.0);
#endif
}
#endif
