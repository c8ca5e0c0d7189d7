// Outputs of every fragment shader that draws agents. CB_IDS adds the id target. The frame buffer encodes sRGB, so the
// colour written here is linear in both kinds of target.
#include "renderers/shaders/bindings.shared.h"
#include "renderers/shaders/dither.shared.h"

#ifdef CB_TOUCHED
layout(early_fragment_tests) in;  // depth before discard, see Pass::touched
#endif
layout(location = 0) out vec4 out_colour;
#ifdef CB_IDS
layout(location = 1) out uint out_id;
#endif

#ifdef CB_DITHER
layout(std140, binding = CB_UNIFORM_DITHER) uniform DitherUniforms { vec4 dither_range; };
#endif

void write_output(vec3 linear_colour, uint id) {
#ifdef CB_DITHER
  float threshold = (float(dither_rank(uint(gl_FragCoord.x), uint(gl_FragCoord.y))) + 0.5) / float(CB_DITHER_RANKS);
  if (threshold < dither_range.x || threshold >= dither_range.y) discard;
#endif
  out_colour = vec4(linear_colour, 1.0);
#ifdef CB_IDS
  out_id = id;
#endif
}
