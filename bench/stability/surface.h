// What is drawn beside the mesh's surface: pixels that no picture may have, holes and strays.
#pragma once
#include "bench/stability/fixture.h"

namespace crowdbench::bench {

// Insane pixels of one frame of the walker; and the holes and strays of a representation that draws the surface itself
// (it stores no views), beyond two pixels and two texels from the mesh's outline. The bound is 0.
Found wrong_pixels(Fixture& fixture, const scene::Frame& frame);
inline constexpr const char* kSurfaceBound =
    "no pixel without a finite colour and depth; outlines to two pixels and two texels of the mesh's: the pixel that a "
    "rasteriser may round away and the texel that a map's outline ends in, on both sides";

// The same of pictures in hand: holes and strays farther than `band` pixels from the mesh's outline.
Found wrong_beside(const renderers::Capture& mesh, const renderers::Capture& drawn, const scene::Frame& frame,
                   int band);

// Metres of the nearest pixel with an agent; infinite where nobody is seen.
double nearest_depth(const renderers::Capture& capture);

}  // namespace crowdbench::bench
