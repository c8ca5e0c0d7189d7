// Judge: a picture held against the truth, pixel by pixel, with the distance that a rasteriser may be off.
#pragma once
#include <cstdint>
#include <vector>

#include "truth/truth.h"

namespace crowdbench::truth {

// How far, in pixels, the outline of an agent may lie from the truth's when its triangles are rasterised in single
// precision as the mesh is. Derived, not measured; the terms add up:
//   snap     a vertex goes to a place of the rasteriser's grid of 1/256 pixel, whichever way the driver rounds
//            (OpenGL asks for 4 bits, GL_SUBPIXEL_BITS; hardware and llvmpipe have 8): sqrt(2)/256
//   weights  16-bit weights: three of four are off by half a step and by the 1e-6 by which floats miss a sum of 1, the
//            largest takes what is left: a vertex moves by less than 2/65535 of how far apart its joints would put it
//   single   rounding on the way from bind space to the window: at most 24 operations in sequence, each off by 2^-24 of
//            the largest length that takes part: the agent's farthest vertex from the eye, and its own size
// Metres become pixels at the agent's nearest vertex, but not nearer than the near plane.
struct OutlineBound {
  double snap = 0;
  double weights = 0;
  double single = 0;
  double pixels() const { return snap + weights + single; }
};

struct JudgedPixel {
  int x = 0;
  int y = 0;
  uint32_t id = 0;        // the picture's
  uint32_t truth_id = 0;  // the truth's
  double bound = 0;       // pixels: of the two agents, the larger OutlineBound
};

struct Judgement {
  uint64_t pixels = 0;
  uint64_t covered = 0;  // that show an agent in the truth
  uint64_t wrong = 0;    // whose id differs: each is one of the following four
  // The truth shows the picture's id at a place nearer to the pixel's centre than the bound.
  uint64_t outline = 0;
  // What the picture shows is there, and no farther behind or before what the truth shows than depths may be off: 2^-22
  // of the depth for what a 32-bit depth buffer keeps, and OutlineBound's weights and single of both agents.
  uint64_t depth = 0;
  // Within a pixel the truth shows the picture's id, and the surface here or there is masked: alpha is that of a
  // filter as wide as a pixel, whose level OpenGL lets drivers approximate.
  uint64_t mask = 0;
  uint64_t unexplained = 0;
  double worst_distance = 0;           // pixels: of those in `outline`, from above, in quarters of the bound
  double largest_bound = 0;            // pixels: of the agents of wrong pixels
  std::vector<JudgedPixel> offenders;  // the unexplained, by rows, 64 at most
  // Pixels inside: they and their eight neighbours show one agent in both, at depths within a hundredth.
  uint64_t inner = 0;
  // Outlines of a limb before the agent's own body, where they differ by less than that, are among them.
  double worst_depth = 0;        // of their depths, relative to the truth's
  double mean_colour = 0;        // code values, over pixels and channels; 0 where there is no colour
  int worst_colour = 0;          // code values
  int worst_x = 0, worst_y = 0;  // where
};

// What is judged. ids and depth are as renderers::Capture has them, of the frame's size; colour may be empty.
struct JudgedPicture {
  const ImageU32& ids;
  const ImageF& depth;
  const Image8& colour;
};

// By the frame that it was drawn from. truth: of that frame. Deterministic; says its progress and notices Ctrl-C.
Judgement judge(const scene::Cast& cast, const scene::Frame& frame, const TruthPicture& truth,
                const JudgedPicture& picture, const TruthOptions& options = {});

// The bound of one agent.
OutlineBound outline_bound(const scene::Cast& cast, const scene::Frame& frame, size_t character, size_t agent);

}  // namespace crowdbench::truth
