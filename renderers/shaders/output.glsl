// Outputs of every fragment shader that draws agents. CB_IDS adds the id target. The frame buffer encodes sRGB, so the
// colour written here is linear in both kinds of target.
#ifdef CB_TOUCHED
layout(early_fragment_tests) in;  // depth before discard, see Pass::touched
#endif
layout(location = 0) out vec4 out_colour;
#ifdef CB_IDS
layout(location = 1) out uint out_id;
#endif

void write_output(vec3 linear_colour, uint id) {
  out_colour = vec4(linear_colour, 1.0);
#ifdef CB_IDS
  out_id = id;
#endif
}
