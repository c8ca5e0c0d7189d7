// One level of the bake of the character being drawn, and its pieces.
#include "renderers/perjoint/perjoint.shared.h"
#include "renderers/shaders/bindings.shared.h"

layout(std140, binding = CB_UNIFORM_TABLE) uniform Table {
  ivec4 grid;   // as pick_view takes them
  vec4 span;
  vec4 scale;   // metres a texel, 1 / width, 1 / height of a page in texels; peak of the light given off
  uvec4 first;  // tile of the level; views; joints of the character; 0
} table;
