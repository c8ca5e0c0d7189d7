// The maps of the tiles (renderers/impostor/tiles/tile.h), as texels or, with CB_SLOT_BITS, as compressed blocks
// (renderers/impostor/tiles/block_compression.h). With CB_EMISSIVE there is light given off.
#include "renderers/flat/flat.shared.h"

layout(binding = CB_FLAT_TEXTURE_ALBEDO) uniform sampler2DArray albedo_map;    // filtered
layout(binding = CB_FLAT_TEXTURE_SURFACE) uniform sampler2DArray surface_map;  // nearest: ids must not be mixed

#ifdef CB_SLOT_BITS
layout(binding = CB_FLAT_TEXTURE_SLOTS) uniform usampler2DArray slot_map;
#if defined(CB_NAILBOARD) || CB_PARALLAX > 0
layout(binding = CB_FLAT_TEXTURE_DEPTH) uniform sampler2DArray depth_map;
#endif
#endif

#ifdef CB_EMISSIVE
layout(binding = CB_FLAT_TEXTURE_EMISSION) uniform sampler2DArray emission_map;  // filtered
#endif

// The maps have one level, and derivatives are undefined where a neighbour was discarded: hence textureLod.

// As the map holds it: fractions of the peak, linear light.
vec3 emission_at(vec3 texel) {
#ifdef CB_EMISSIVE
  return textureLod(emission_map, texel, 0.0).rgb;
#else
  return vec3(0.0);
#endif
}

// Normal x and y, material id and depth as Tile::surface codes them. texel: page coordinates in [0, 1], layer.
vec4 surface_at(vec3 texel) {
#ifdef CB_SLOT_BITS
  ivec2 size = textureSize(surface_map, 0).xy;
  ivec3 at = ivec3(min(ivec2(texel.xy * vec2(size)), size - 1), int(texel.z + 0.5));
  vec4 surface = vec4(texelFetch(surface_map, at, 0).rg, 0.0, 0.0);
#if defined(CB_NAILBOARD) || CB_PARALLAX > 0
  surface.a = texelFetch(depth_map, at, 0).r;
#endif
#if CB_SLOT_BITS == 8
  uint slot = texelFetch(slot_map, at, 0).r;
#else
  uint code = texelFetch(slot_map, ivec3(at.x >> 1, at.yz), 0).r >> (4 * (at.x & 1));
  uint slot = (code & 7u) | (code & 8u) << 4;
#endif
  surface.b = float(slot) / 255.0;
  return surface;
#else
  return textureLod(surface_map, texel, 0.0);
#endif
}
