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
#include "renderers/shaders/shading.glsl"
#include "renderers/shaders/output.glsl"
#include "renderers/relief/relief_records.glsl"
#if SEARCH == RELIEF_SEARCH_CONE
#include "renderers/relief/relief_cone.glsl"
#endif

// Boxes of the farther tiers: the search and the choice of face in fewer operations.
#if SEARCH == RELIEF_SEARCH_ADAPTIVE && !defined(CARVE)
#define PLAIN
#endif

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

layout(binding = RELIEF_TEXTURE_DEPTH) uniform sampler2D depth_map;    // least and greatest depth along the axis
layout(binding = RELIEF_TEXTURE_COLOUR) uniform sampler2D colour_map;  // sRGB colour, unlit; filtered
#ifdef CB_EMISSIVE
layout(binding = RELIEF_TEXTURE_EMISSION) uniform sampler2D emission_map;  // sRGB, fractions of the peak; filtered
layout(location = RELIEF_LOCATION_PEAK) uniform float emission_peak;
#endif
layout(binding = RELIEF_TEXTURE_NORMAL) uniform sampler2D normal_map;  // bind-space normal, part
layout(binding = RELIEF_TEXTURE_BOUNDS) uniform sampler2D bounds_map;  // conservative least and greatest depth
#if SEARCH == RELIEF_SEARCH_CONE
layout(binding = RELIEF_TEXTURE_CONES) uniform sampler2D cone_map;  // roots of the approaching and leaving cone, up and down
#endif
layout(std430, binding = RELIEF_STORAGE_POSED) readonly restrict buffer Posed { PosedBox posed[]; };

float stored_depth(float metres) { return -frame.projection[2][2] + frame.projection[3][2] / metres; }

#ifdef DEBUG
vec3 heat(float t) { return clamp(vec3(1.5 - abs(4.0 * t - 3.0), 1.5 - abs(4.0 * t - 2.0), 1.5 - abs(4.0 * t - 1.0)), 0.0, 1.0); }
#endif

void main() {
  // The ray through the anchor, a point in front of the eye; s counts backwards from the anchor (0) to the eye (1).
  vec3 ray = v_anchor - v_eye_depth.xyz;
#ifdef HULL
  float anchor_depth = v_eye_depth.w;
#else
  float anchor_depth = 1.0 / gl_FragCoord.w;
#endif

  int texels = int(v_maps.y & 1023u);

  // Clipped by slabs to the captured surface's own bounds, which end on the centres of the outermost texels: s in
  // [s_far, s_near]. (The outer half of those texels would widen every silhouette.)
  float margin = 0.5 / float(texels);
  bvec3 forward = greaterThan(ray, vec3(0.0));
  vec3 reach = max(abs(ray), 1e-20);
  vec3 inverse_reach = 1.0 / reach;
  vec3 slab = (mix(1.0 - v_anchor, v_anchor, forward) - margin) * inverse_reach;
  vec3 leave = slab - (1.0 - 2.0 * margin) * inverse_reach;
  float s_near = min(min(min(slab.x, slab.y), slab.z), 1.0 - frame.lens.x / anchor_depth);
  float span = s_near - max(max(leave.x, leave.y), leave.z);

  // The axis that the ray crosses most of, counted in texels (the three maps have as many). Along it the ray goes up: for one
  // that goes down, the depths are mirrored.
  int axis = reach.x >= reach.y && reach.x >= reach.z ? 0 : (reach.y >= reach.z ? 1 : 2);
  vec3 from = v_anchor - s_near * ray;
  vec3 delta = span * ray;
  from = axis == 0 ? from.yzx : axis == 1 ? from.zxy : from;
  delta = axis == 0 ? delta.yzx : axis == 1 ? delta.zxy : delta;
  bool down = delta.z < 0.0;
  if (down) {
    from.z = 1.0 - from.z;
    delta.z = -delta.z;
  }

  int size = int(v_maps.y >> 10u & 1023u);
  int column = int(v_maps.y >> 20u);
  ivec2 low = ivec2(v_maps.x & 65535u, v_maps.x >> 16u) + ivec2(axis * texels + column, 0);
  ivec2 high = low + (size - 1);
  vec2 start = vec2(low) + from.xy * float(size);
  vec2 across = delta.xy * float(size);
  float hit = -1.0;  // depth along the axis
  ivec2 texel = low;
#ifdef PLAIN
  vec2 solid;  // least and greatest depth there
#endif
#ifdef DEBUG
  int taps = 0;
#define COUNT_TAP ++taps
#else
#define COUNT_TAP
#endif

  if (span > 0.0) {
#if SEARCH != RELIEF_SEARCH_LINEAR
#ifdef CARVE
    // Where the other two axes' bounds lie. Their (u, v, depth) are turns of the march's: its axis's depth is the next axis's v
    // and the one after's u.
    ivec2 corner2 = ivec2(v_maps.x & 65535u, v_maps.x >> 16u) + ivec2(column, 0);
    int half_size = size >> 1;
    ivec2 low1 = (corner2 + ivec2((axis == 2 ? 0 : axis + 1) * texels, 0)) >> 1;
    ivec2 low2 = (corner2 + ivec2((axis == 0 ? 2 : axis - 1) * texels, 0)) >> 1;
#endif
#ifdef RELIEF_FLOOR
    int steps = 1;
#else
    float a_texel = v_light.w;
    int steps = clamp(int(ceil(a_texel * max(abs(across.x), abs(across.y)))), 1, STEPS);
#endif
    float inverse_steps = 1.0 / float(steps);
    vec2 move = across * inverse_steps;
    float rise = delta.z * inverse_steps;
    vec2 at = start + 0.5 * move;
#ifdef PLAIN
    // A step's interval makes everything thicker by what the ray rises while it is in the next texel already. What is thicker
    // than that is made thinner by as much in all; what is not is one surface, which no step may miss. Depths are doubled and not
    // mirrored: two intervals meet when their middles lie no farther apart than their halves' sum. The ray was clipped half a
    // texel within the map, so that no texel needs clamping.
    float thinner = rise * clamp(max(abs(move.x), abs(move.y)) - 0.5, 0.0, 0.5);
    float thickness = rise + 2.0 * SLACK;
    float grown = thickness - thinner;
    float upward = down ? -rise : rise;
    float middle = 2.0 * (down ? 1.0 - from.z : from.z) + upward;
    bool met = false;
    int i = 0;
    for (; i < steps && !met; ++i) {
      texel = ivec2(at);
      solid = texelFetch(depth_map, texel, 0).rg;
      COUNT_TAP;
      float thick = solid.y - solid.x;
      met = thick >= 0.0 && abs(solid.x + solid.y - middle) <= max(thick + grown, thickness);
      middle += 2.0 * upward;
      at += move;
    }
    if (met) hit = max(max(down ? 1.0 - solid.y : solid.x, from.z + float(i - 1) * rise - SLACK), 0.0);
#else
    float c = from.z - SLACK;
    float half_step = 0.5 * rise + SLACK;
    vec2 mirror = down ? vec2(1.0, -0.5) : vec2(0.0, 0.5);
#if SEARCH == RELIEF_SEARCH_CONE
    float slope = max(abs(delta.x), abs(delta.y)) / max(delta.z, 1e-20);
    float a_step = 1.0 / max(rise, 1e-20);
    int skipped = 0;  // steps between the last one tested and this one
    int behind = 0;   // the same of a step that began inside a surface
#endif
    // Nested, since a branch costs its whole content on every step where lanes run together: the inner loop takes one tap a
    // step, the outer one looks at what it found.
    int i = 0;
    while (i < steps) {
      float enter = -1.0;
#if SEARCH == RELIEF_SEARCH_CONE
      at = start + (float(i) + 0.5) * move;
      skipped = 0;
#endif
#if SEARCH == RELIEF_SEARCH_CONE
      while (i < steps && enter < 0.0) {
        texel = clamp(ivec2(at), low, high);
        vec2 bounds = texelFetch(depth_map, texel, 0).rg;
        COUNT_TAP;
        if (down) bounds = 1.0 - bounds.yx;
        float from_here = max(bounds.x, c);
        int ahead = 1;
        if (from_here <= min(bounds.y, c + rise + 2.0 * SLACK)) {
          enter = max(from_here, 0.0);
          behind = c > bounds.x ? skipped : 0;
        } else {
          COUNT_TAP;
          float reach = cone_reach(cones_of(texelFetch(cone_map, texel, 0), down), bounds, c + 0.5 * rise, slope, 1.0 / float(size));
          // The last step is always tested: a skip may end beyond the box in a surface.
          ahead = reach >= 2.0 ? steps - i : max(1, min(int(0.5 + reach * a_step), steps - 1 - i));
        }
        skipped = ahead - 1;
        i += ahead;
        c += float(ahead) * rise;
        at += float(ahead) * move;
      }
#else
      for (; i < steps && enter < 0.0; ++i) {
        texel = clamp(ivec2(at), low, high);
        vec2 bounds = texelFetch(depth_map, texel, 0).rg;
        COUNT_TAP;
        // Two intervals meet when their middles lie no farther apart than their halves' sum.
        float half_solid = 0.5 * (bounds.y - bounds.x);
        float middle = mirror.x + mirror.y * (bounds.x + bounds.y);
        if (half_solid >= 0.0 && abs(middle - (c + half_step)) <= half_solid + half_step)
          enter = max(max(middle - half_solid, c), 0.0);
        c += rise;
        at += move;
      }
#endif
      if (enter < 0.0) break;
#if SEARCH == RELIEF_SEARCH_CONE
      // Where a skip ended inside, the surface lies behind: between the last step tested and this one. (A loop that most
      // rays leave at once: unrolled, or inside the other one, it would cost every ray its taps.)
      float below = float(i - 1 - behind);
      float above = float(i - 1);
      for (int k = behind > 0 ? 0 : BINARY; k < BINARY; ++k) {
        float middle = 0.5 * (below + above);
        float depth = from.z + middle * rise;
        ivec2 there = clamp(ivec2(start + middle * move), low, high);
        vec2 bounds = texelFetch(depth_map, there, 0).rg;
        COUNT_TAP;
        if (down) bounds = 1.0 - bounds.yx;
        if (bounds.x - SLACK <= depth && depth <= bounds.y + SLACK) {
          above = middle;
          texel = there;
          enter = depth;
          at = start + (middle + 1.0) * move;
        } else {
          below = middle;
        }
      }
#endif
#ifdef CARVE
      // In one axis's map alone everything between the nearest and the farthest surface counts as solid. What another axis
      // shows to be air is not.
      vec3 p = vec3((at - move - vec2(low)) / float(size), down ? 1.0 - enter : enter);
      vec2 next = texelFetch(bounds_map, clamp(low1 + ivec2(p.yz * float(half_size)), low1, low1 + (half_size - 1)), 0).rg;
      vec2 last = texelFetch(bounds_map, clamp(low2 + ivec2(p.zx * float(half_size)), low2, low2 + (half_size - 1)), 0).rg;
      COUNT_TAP;
      COUNT_TAP;
      if (p.x < next.x || p.x > next.y || p.y < last.x || p.y > last.y) continue;
#endif
      hit = enter;
      break;
    }
#endif
#else
    float below = 0.0;
    for (int i = 0; i <= STEPS; ++i) {
      float t = float(i) / float(STEPS);
      float c = from.z + delta.z * t;
      texel = clamp(ivec2(start + across * t), low, high);
      vec2 bounds = texelFetch(depth_map, texel, 0).rg;
      COUNT_TAP;
      if (down) bounds = 1.0 - bounds.yx;
      if (bounds.x - SLACK <= c && c <= bounds.y + SLACK) {
        float above = t;
        for (int k = 0; k < BINARY; ++k) {
          float middle = 0.5 * (below + above);
          c = from.z + delta.z * middle;
          ivec2 there = clamp(ivec2(start + across * middle), low, high);
          bounds = texelFetch(depth_map, there, 0).rg;
          COUNT_TAP;
          if (down) bounds = 1.0 - bounds.yx;
          if (bounds.x - SLACK <= c && c <= bounds.y + SLACK) {
            above = middle;
            texel = there;
          } else {
            below = middle;
          }
        }
        hit = from.z + delta.z * above;
        break;
      }
      below = t;
    }
#endif
  }

#if defined(DEBUG) && DEBUG == RELIEF_DEBUG_BOXES
  gl_FragDepth = stored_depth(anchor_depth);
  write_output(0.5 + 0.5 * cos(6.2831853 * (float(v_identity.z) * 0.381966 + vec3(0.0, 0.33, 0.67))), v_identity.y);
  return;
#endif
#if defined(DEBUG) && DEBUG == RELIEF_DEBUG_MISSES
  if (hit < 0.0) {
    gl_FragDepth = stored_depth(anchor_depth);
    write_output(vec3(0.8, 0.05, 0.05), 0u);
    return;
  }
#endif
#if defined(DEBUG) && DEBUG == RELIEF_DEBUG_STEPS
  // Rays that meet nothing cost too: they show where nothing else does.
  if (hit < 0.0) {
    gl_FragDepth = stored_depth(1e6);
    write_output(heat(min(float(taps) / 64.0, 1.0)), 0u);
    return;
  }
#endif
  if (hit < 0.0) discard;

  float s = s_near - span * clamp((hit - from.z) / max(delta.z, 1e-20), 0.0, 1.0);
  gl_FragDepth = stored_depth(anchor_depth * (1.0 - s));

  int side = down ? 1 : 0;
#ifdef ATTRIBUTE
  // The march finds the point; which of the six faces stores the surface there is another matter: a column's side wall
  // belongs to another axis. Take the face whose stored depth is nearest to the point.
  vec3 edges = unpackUnorm4x8(v_maps.z).xyz;
  vec3 point = v_anchor - s * ray;
#ifdef PLAIN
  // As below, from the march's axis on, whose depths are known already.
  int main_axis = axis;
  ivec2 corner = ivec2(v_maps.x & 65535u, v_maps.x >> 16u) + ivec2(column, 0);
  vec3 p = axis == 0 ? point.yzx : axis == 1 ? point.zxy : point;
  vec3 edge = axis == 0 ? edges : axis == 1 ? edges.yzx : edges.zxy;
  vec3 facing = axis == 0 ? reach : axis == 1 ? reach.yzx : reach.zxy;
  facing *= 1.0 / facing.x;
  bvec3 ahead = axis == 0 ? forward : axis == 1 ? forward.yzx : forward.zxy;
  vec2 miss = (abs(p.z - solid) + (ahead.x ? vec2(0.0, 0.04) : vec2(0.04, 0.0))) * edge.x;
  side = miss.x <= miss.y ? 0 : 1;
  float nearest = min(miss.x, miss.y);
  for (int j = 1; j < 3; ++j) {
    p = p.yzx;
    int k = main_axis + j;
    k -= k > 2 ? 3 : 0;
    ivec2 there = corner + ivec2(k * texels, 0) + clamp(ivec2(p.xy * float(size)), ivec2(0), ivec2(size - 1));
    vec2 bounds = texelFetch(depth_map, there, 0).rg;
    float turned = 0.02 * facing[j];
    miss = (abs(p.z - bounds) + (ahead[j] ? vec2(0.02 - turned, 0.02 + turned) : vec2(0.02 + turned, 0.02 - turned))) * edge[j];
    if (bounds.x <= bounds.y && min(miss.x, miss.y) < nearest) {
      nearest = min(miss.x, miss.y);
      axis = k;
      side = miss.x <= miss.y ? 0 : 1;
      texel = there;
    }
  }
#else
  float nearest = 1e30;
  ivec2 corner = ivec2(v_maps.x & 65535u, v_maps.x >> 16u) + ivec2(column, 0);
  ivec2 found = texel;
  int main_axis = axis;
#ifdef CARVE
  vec4 normal = vec4(0.5, 1.0, 0.5, 0.0);
#endif
  for (int k = 0; k < 3; ++k) {
    vec3 p = k == 0 ? point.yzx : k == 1 ? point.zxy : point;
    ivec2 left = corner + ivec2(k * texels, 0);
    // The march's own texel: the point may lie in the next one, by rounding or by half a step.
    ivec2 there = k == main_axis ? found : clamp(left + ivec2(p.xy * float(size)), left, left + (size - 1));
    vec2 bounds = texelFetch(depth_map, there, 0).rg;
    if (bounds.x > bounds.y) continue;
    // In metres of the longest edge. A face that the ray grazes costs a little; one that looks away, as at the rim of a round
    // limb, a little more.
    float facing = reach[k] / reach[main_axis];
    vec2 miss = (abs(p.z - bounds) + (forward[k] ? vec2(0.02 * (1.0 - facing), 0.02 * (1.0 + facing))
                                                 : vec2(0.02 * (1.0 + facing), 0.02 * (1.0 - facing)))) * edges[k];
    int nearer = miss.x <= miss.y ? 0 : 1;
    float cost = min(miss.x, miss.y);
#ifdef CARVE
    vec4 seen = texelFetch(normal_map, there + ivec2(int(v_maps.x & 65535u) + (k + nearer) * texels, 0), 0);
    // What looks away from the eye is not what the ray met, if anything else will do.
    cost += dot(seen.xyz * 2.0 - 1.0, v_view) < 0.0 ? 0.1 : 0.0;
#endif
    if (cost < nearest) {
      nearest = cost;
      axis = k;
      side = nearer;
      texel = there;
#ifdef CARVE
      normal = seen;
#endif
    }
  }
#endif
#endif
#if !defined(ATTRIBUTE) || !defined(CARVE)
  // The colour and normal atlases hold two maps where the depth atlas holds one.
  vec4 normal = texelFetch(normal_map, texel + ivec2(int(v_maps.x & 65535u) + (axis + side) * texels, 0), 0);
#endif
  // Colour from the level of about one texel a pixel, filtered: as the mesh's texture is.
  int colour_level = int(v_maps.z >> 25u);
  int colour_size = texels >> colour_level;
  vec2 colour_low = vec2(ivec2(int(v_maps.x & 65535u) * 2 + (2 * axis + side) * texels +
                                   (colour_level == 0 ? 0 : texels - (texels >> (colour_level - 1))),
                               int(v_identity.w)));
  vec3 place = v_anchor - s * ray;
  place = axis == 0 ? place.yzx : axis == 1 ? place.zxy : place;
  vec2 colour_at = (colour_low + clamp(place.xy * float(colour_size), 0.5, float(colour_size) - 0.5)) /
                   vec2(textureSize(colour_map, 0));
  vec4 colour = textureLod(colour_map, colour_at, 0.0);
  vec3 n = normal.xyz * 2.0 - 1.0;
  float square = max(dot(n, n), 1e-6);
  // What looks away is the inner side of an open piece, or beside a rim: mirrored, which does nothing at right angles and turns
  // round what faces away.
  float away = dot(n, v_view);
  if (away < 0.0) n -= 2.0 * away / dot(v_view, v_view) * v_view;
  float lambert = dot(n, v_light.xyz) * inversesqrt(square);
  if ((v_maps.z >> 24u & 1u) != 0u) {
    // What shears or stretches turns normals as the mesh's shader does.
    vec3 world = vec3(dot(posed[v_maps.w].turn[0].xyz, n), dot(posed[v_maps.w].turn[1].xyz, n), dot(posed[v_maps.w].turn[2].xyz, n));
    lambert = dot(world, frame.light_direction.xyz) * inversesqrt(max(dot(world, world), 1e-30));
  }
  vec3 shown = shade_lit(colour.rgb, max(lambert, 0.0), uint(normal.a * 255.0 + 0.5), v_identity.x, colour.a > 0.5, vec3(0.0));
#ifdef CB_EMISSIVE
  // Added here, since what an unlit texel holds is the part of it that glows.
  shown += textureLod(emission_map, colour_at, 0.0).rgb * emission_peak;
#endif
#if defined(DEBUG) && DEBUG == RELIEF_DEBUG_STEPS
  shown = heat(min(float(taps) / 64.0, 1.0));  // dark red: 64 taps and more
#elif defined(DEBUG) && DEBUG == RELIEF_DEBUG_HIT_FACE
  shown = (axis == 0 ? vec3(1.0, 0.2, 0.2) : axis == 1 ? vec3(0.2, 1.0, 0.2) : vec3(0.2, 0.3, 1.0)) * (side == 0 ? 0.5 : 1.0);
#endif
  write_output(shown, v_identity.y);
}
