#version 450 core
// Where the view ray meets a joint's stored surface.
//
// Based on: Beacco et al. 2011 (dual-depth maps on the faces of a joint's box, linear search, binary refinement).
// Differs from the source, and why:
// - The ray is clipped to the box and marched from where it enters to where it leaves, in the map of the face whose axis it
//   crosses most of, so nothing is divided by a component that a grazing ray can make zero. The printed loop divides by the
//   ray's component along the rasterised face's normal.
// - One fragment a ray, also with the eye inside: back faces are rasterised, or the outline of a tighter hull.
// - A step is an interval: the part of the ray above half a texel is compared with that texel's [front, back]. A surface as thin as
//   one depth value cannot be stepped over, and front == back needs no special case. The printed loop samples points, never
//   depth 0, and gives up at the first sample off the map.
// - The hit's depth is written.
//
// How the surface is found is `Hit search(Ray, Map)`, one file a search; which of the box's faces stores what was found is
// `Face face_at(...)`. relief_map.glsl says what they are given.
#include "renderers/shaders/shading.glsl"
#include "renderers/shaders/output.glsl"

// Boxes of the farther tiers: the search and the choice of face in fewer operations.
#if SEARCH == RELIEF_SEARCH_ADAPTIVE && !defined(CARVE) && !defined(CUBE)
#define PLAIN
#endif
#include "renderers/relief/relief_map.glsl"

layout(location = 0) in vec3 v_anchor;
layout(location = 1) flat in vec4 v_eye_depth;
layout(location = 2) flat in vec4 v_light;  // w: steps to a texel
layout(location = 3) flat in uvec4 v_maps;   // w: of the posed box
layout(location = 4) flat in uvec4 v_identity;
#ifdef CARVE
layout(location = 5) in vec3 v_view;
#else
layout(location = 5) flat in vec3 v_view;
#endif

layout(binding = RELIEF_TEXTURE_COLOUR) uniform sampler2D colour_map;  // sRGB colour, unlit; filtered
#ifdef CB_EMISSIVE
layout(binding = RELIEF_TEXTURE_EMISSION) uniform sampler2D emission_map;  // sRGB, fractions of the peak; filtered
layout(location = RELIEF_LOCATION_PEAK) uniform float emission_peak;
#endif
layout(std430, binding = RELIEF_STORAGE_POSED) readonly restrict buffer Posed { PosedBox posed[]; };

#ifdef CUBE
#include "renderers/relief/relief_cube.glsl"
#elif SEARCH == RELIEF_SEARCH_LINEAR
#include "renderers/relief/relief_linear.glsl"
#elif SEARCH == RELIEF_SEARCH_CONE
#include "renderers/relief/relief_cone.glsl"
#elif defined(PLAIN)
#include "renderers/relief/relief_plain.glsl"
#else
#include "renderers/relief/relief_adaptive.glsl"
#endif
#include "renderers/relief/relief_face.glsl"

float stored_depth(float metres) { return -frame.projection[2][2] + frame.projection[3][2] / metres; }

#ifdef DEBUG
#include "renderers/relief/relief_debug.glsl"
#endif

// Lambert's cosine of a bind-space normal as stored, at a point of the box.
float lambert_of(vec3 stored, vec3 point) {
  vec3 n = stored * 2.0 - 1.0;
  float square = max(dot(n, n), 1e-6);
  // What looks away is the inner side of an open piece, or beside a rim: mirrored, which does nothing at right angles and turns
  // round what faces away.
  float away = dot(n, v_view);
  if (away < 0.0) n -= 2.0 * away / dot(v_view, v_view) * v_view;
  float lambert = dot(n, v_light.xyz) * inversesqrt(square);
  if ((v_maps.z >> 24u & 1u) != 0u) {
    // What shears or stretches turns normals as the mesh's shader does: with each joint's weight where the point lies.
    vec3 world = vec3(dot(posed[v_maps.w].turn[0].xyz, n), dot(posed[v_maps.w].turn[1].xyz, n), dot(posed[v_maps.w].turn[2].xyz, n));
    vec3 light = posed[v_maps.w].lights[3].xyz + posed[v_maps.w].lights[0].xyz * point.x +
                 posed[v_maps.w].lights[1].xyz * point.y + posed[v_maps.w].lights[2].xyz * point.z;
    lambert = dot(n, light) * inversesqrt(max(dot(world, world), 1e-30));
  }
  return max(lambert, 0.0);
}

// Where the colour of a point on a face lies in the colour picture: at the level whose texture is filtered over a pixel, as
// the mesh's is; it is COLOUR_FINER finer than a texel a pixel, so that borders stay sharp. A surface that stands aslant is seen by wider pixels, by the
// mesh's filter in all directions: half of that (by logarithm) comes nearest to it.
vec2 colour_place(Map map, Face face, vec3 point) {
  vec3 n = face.normal.xyz * 2.0 - 1.0;
  float toward = dot(n, v_view);
  float square = toward * toward / max(dot(n, n) * dot(v_view, v_view), 1e-12);
  float wanted = float(v_maps.z >> 25u) / 16.0 - 0.25 * log2(max(square, 1.0 / 64.0));
  int level = clamp(int(wanted + 0.5) - COLOUR_FINER, 0, findMSB(map.texels) - 2);
  int size = map.texels >> level;
  vec2 low = vec2(ivec2(map.left * 2 + (2 * face.axis + face.side) * map.texels +
                            (level == 0 ? 0 : map.texels - (map.texels >> (level - 1))),
                        int(v_identity.w) + (level == 0 ? 0 : map.texels)));
#ifdef CUBE
  vec3 place = along_axis(2.0 * point - 1.0, face.axis);
  place.xy = 0.5 * place.xy / max(abs(place.z), 1e-6) + 0.5;
#else
  vec3 place = along_axis(point, face.axis);
#endif
  return (low + clamp(place.xy * float(size), 0.5, float(size) - 0.5)) / vec2(textureSize(colour_map, 0));
}

void main() {
  // The ray through the anchor, a point in front of the eye; s counts backwards from the anchor (0) to the eye (1).
  vec3 direction = v_anchor - v_eye_depth.xyz;
#ifdef HULL
  float anchor_depth = v_eye_depth.w;
#else
  float anchor_depth = 1.0 / gl_FragCoord.w;
#endif
  Map map = map_of(v_maps);

  // Clipped by slabs to the captured surface's own bounds, which end on the centres of the outermost texels: s in
  // [s_far, s_near]. (The outer half of those texels would widen every silhouette.)
  float margin = 0.5 / float(map.texels);
  bvec3 forward = greaterThan(direction, vec3(0.0));
  vec3 reach = max(abs(direction), 1e-20);
  vec3 inverse_reach = 1.0 / reach;
  vec3 slab = (mix(1.0 - v_anchor, v_anchor, forward) - margin) * inverse_reach;
  vec3 leave = slab - (1.0 - 2.0 * margin) * inverse_reach;
  float s_near = min(min(min(slab.x, slab.y), slab.z), 1.0 - frame.lens.x / anchor_depth);
  float span = s_near - max(max(leave.x, leave.y), leave.z);

  // The axis that the ray crosses most of, counted in texels (the three maps have as many).
  map.axis = reach.x >= reach.y && reach.x >= reach.z ? 0 : (reach.y >= reach.z ? 1 : 2);
  Ray ray;
  ray.from = along_axis(v_anchor - s_near * direction, map.axis);
  ray.delta = along_axis(span * direction, map.axis);
  ray.steps_a_texel = v_light.w;
  ray.down = ray.delta.z < 0.0;
  if (ray.down) {
    ray.from.z = 1.0 - ray.from.z;
    ray.delta.z = -ray.delta.z;
  }

  Hit hit = nothing(map);
  if (span > 0.0) hit = search(ray, map);

#ifdef DEBUG
  if (shown_instead(hit, anchor_depth)) return;
#endif
  if (hit.depth < 0.0) discard;

  float s = s_near - span * clamp((hit.depth - ray.from.z) / max(ray.delta.z, 1e-20), 0.0, 1.0);
  gl_FragDepth = stored_depth(anchor_depth * (1.0 - s));

  vec3 point = v_anchor - s * direction;
  Face face = face_at(point, direction, ray.down, map, hit);
  vec2 colour_at = colour_place(map, face, point);
  vec4 colour = textureLod(colour_map, colour_at, 0.0);
  vec3 shown = shade_lit(colour.rgb, lambert_of(face.normal.xyz, point), uint(face.normal.a * 255.0 + 0.5), v_identity.x,
                         colour.a > 0.5, vec3(0.0));
#ifdef CB_EMISSIVE
  // Added here, since what an unlit texel holds is the part of it that glows.
  shown += textureLod(emission_map, colour_at, 0.0).rgb * emission_peak;
#endif
#ifdef DEBUG
  shown = shown_of_hit(shown, face);
#endif
  write_output(shown, v_identity.y);
}
