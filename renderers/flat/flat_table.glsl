// One level of the bake of the character being drawn.
#include "renderers/flat/flat.shared.h"
#include "renderers/shaders/bindings.shared.h"

layout(std140, binding = CB_UNIFORM_TABLE) uniform Table {
  vec4 centre;  // capture centre, model space, metres; w: what the ends of the stored depth stand for, metres
  ivec4 grid;   // as pick_view takes them
  vec4 span;
  vec4 scale;   // metres a texel, 1 / width, 1 / height of a page in texels; the level
  uvec4 first;  // of the level's tiles, of its outlines' corners; views
  uvec4 layers;  // that the textures bound hold: the first, how many; z: peak of the light given off, a float
  uvec4 clips[CB_FLAT_CLIPS];  // first frame, frames
} table;
