// The posed palettes that FrameResources::draw_posed computed: rows of camera-relative world from bind space.
#include "renderers/shaders/bindings.shared.h"

layout(binding = CB_TEXTURE_PALETTE) uniform samplerBuffer palette_texels;
// Row r (0..2) of joint j of the instance'th agent of the batch is row (instance * joints + j) * 3 + r.
vec4 palette_row(uint row) { return texelFetch(palette_texels, int(row)); }
