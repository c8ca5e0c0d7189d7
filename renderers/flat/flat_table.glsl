// One level of the bake of the character being drawn.
#include "renderers/flat/flat.shared.h"
#include "renderers/shaders/bindings.shared.h"

layout(std140, binding = CB_UNIFORM_TABLE) uniform Table {
  vec4 centre;  // capture centre, model space, metres; w: what the ends of the stored depth stand for, metres
  ivec4 grid;   // as pick_view takes them
  vec4 span;
  vec4 scale;   // metres a texel, 1 / width, 1 / height of a page in texels; the level
  uvec4 first;  // of the level's tiles, of its outlines' corners; views; of the tiles of the level whose motion maps it uses
  uvec4 layers;  // that the textures bound hold: the first, how many; z: peak of the light given off, a float
  vec4 motion;  // of the bake with motion: texels of the level that a code's end stands for; texels of the motion's level over one
  uvec4 clips[CB_FLAT_CLIPS];  // first frame, frames
} table;
