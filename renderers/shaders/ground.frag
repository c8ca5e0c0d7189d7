#version 450 core
// The ground: a grey grid on y = 0, one line a metre, anti-aliased by the exact coverage of a pixel's box. The eye's
// place enters only as its offset within a cell, so the grid is as sharp at 100 km from the origin as at the origin.
#include "renderers/shaders/frame.glsl"
#include "renderers/shaders/output.glsl"

layout(location = 0) in vec2 v_ndc;

// Mean over [x - w/2, x + w/2] of the pattern that is 1 within half_width of every integer.
float line_coverage(float x, float w, float half_width) {
  w = max(w, 1e-6);
  vec2 ends = vec2(x - 0.5 * w, x + 0.5 * w) + half_width;
  // The integral of the pattern from 0: whole periods plus what is covered of the last one.
  vec2 integral = floor(ends) * 2.0 * half_width + min(fract(ends), 2.0 * half_width);
  return clamp((integral.y - integral.x) / w, 0.0, 1.0);
}

void main() {
  vec3 ray = transpose(mat3(frame.view_from_world)) *
             vec3(v_ndc.x * frame.lens.z * frame.lens.w, v_ndc.y * frame.lens.z, -1.0);
  float height = frame.ground_origin.y;
  float t = -height / ray.y;  // eye-space depth, because the ray's eye-space z is -1
  vec2 place = ray.xz * t;
  // A pixel's footprint along both axes, from the ray's own derivatives: exact up to second order, and no quad artefacts.
  vec2 footprint = fwidth(place);
  if (!(t > frame.lens.x) || (frame.lens.y > 0.0 && t > frame.lens.y)) discard;
  vec2 cell = place + frame.ground_origin.xz;
  vec2 covered = vec2(line_coverage(cell.x, footprint.x, 0.015), line_coverage(cell.y, footprint.y, 0.015));
  float grid = 1.0 - (1.0 - covered.x) * (1.0 - covered.y);
  vec3 grey = mix(vec3(0.30), vec3(0.16), grid);
  float fade = exp2(-dot(place, place) / (120.0 * 120.0));
  write_output(mix(frame.background.rgb, grey, fade), 0u);
  vec4 clip = frame.projection * vec4(0.0, 0.0, -t, 1.0);
  gl_FragDepth = clip.z / clip.w;
}
