// The light that a character gives off, as impostors store it.
//
// An emission map holds colours sRGB-encoded, as fractions of the character's peak: what a texel gives off is its
// decoded colour times the peak. GPUs decode before they filter, so a light of a few texels keeps its strength, and
// factors above 1 (KHR_materials_emissive_strength) are kept as the mesh keeps them. A character whose peak is 0 has no
// such map.
#pragma once
#include "scene/character/character.h"

namespace crowdbench::renderers {

// The largest component of linear light that any point of the mesh gives off: of the materials in use, factor times the
// brightest texel of the image. 0: nothing glows. Unlit materials give off nothing of their own (shade_lit).
float emission_peak(const scene::Character& character);

}  // namespace crowdbench::renderers
