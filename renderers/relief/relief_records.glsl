#include "renderers/relief/relief.shared.h"

// One box of the character: rows of bind space from unit coordinates; the joints that move it, each with its mean weight (0:
// none, nor after it) and what its matrix is multiplied by; where its maps lie.
struct BoxRecord {
  vec4 rows[3];
  uvec4 maps;  // left, top in the depth atlas; texels a side; levels
  uint joints[RELIEF_SHARES];
  float weights[RELIEF_SHARES];
  mat4 movers[RELIEF_SHARES];
};

// One box of one agent, posed.
struct PosedBox {
  vec4 eye_depth;  // the eye in unit coordinates; hull: depth of the plane of the outline. Below zero: draws nothing
  vec4 light;      // the light's direction in bind space; w: 1 where the box's matrix does not keep angles, below 0: mirrored
  uvec4 maps;      // see pack_maps(); z: the edges, the longest 1; w: top row of its maps
  vec4 view;       // direction from the box's middle to the eye in bind space, unit; steps of the search to a texel
  vec4 turn[3];    // rows of world directions from bind space
  vec4 lights[4];  // the light's direction in bind space at the box's origin (3), and what each unit of the box adds (0 to 2)
  vec4 frame[3];   // box: rows of eye space from unit coordinates. hull: the outline's plane in unit coordinates
#ifdef HULL
  vec4 corners[CORNERS / 2];  // of the outline on the plane at depth 1, relative to the box's middle
#endif
};

// Where the maps of a box's chosen mip level lie. Depth atlas: three maps next to each other; colour atlas: six, in a picture
// twice as wide; level L > 0 under level 0, after the larger ones.
uvec2 pack_maps(uint left, uint top, uint texels, uint level) {
  uint aside = level == 0u ? 0u : texels - (texels >> (level - 1u));
  uint down = level == 0u ? 0u : texels;
  return uvec2(left | (top + down) << 16u, texels | (texels >> level) << 10u | aside << 20u);
}
