// What of a picture's error is owed to order, silhouettes, wrong surfaces, shading and texture, where of every pixel
// is known which surface it shows and how that is lit: the causes that are put in pixel by pixel (metrics/causes.h).
#pragma once
#include <optional>
#include <vector>

#include "metrics/causes.h"

namespace crowdbench::metrics {

// One side, pixel by pixel; all of one size. Its colour in linear light is
// base * (ambient + diffuse * lambert) + emissive, but for what `codes` shows otherwise, which becomes the residue.
struct Surfaces {
  Image8 codes;     // the picture, sRGB code values
  ImageU32 ids;     // agent index + 1, 0 = nothing
  ImageF depth;     // metres along the view axis, +infinity where empty
  ImageF base;      // three channels, linear, outfit included; 0 of surfaces that are not lit
  ImageF emissive;  // three channels, linear; the colour of surfaces that are not lit
  ImageF lambert;   // one channel: cosine between normal and light, 0 to 1; below 0 where base is 0 and it is unknown
};

struct SurfaceSubstitution {
  const Surfaces& reference;
  const Surfaces& test;
  double ambient = 0, diffuse = 0;  // of the light
  // Depths of one agent that are farther apart are other surfaces; nothing: the depths are not those of surfaces.
  std::optional<double> depth_tolerance;  // metres
  // Not 0 where both pictures' agents cover the pixel in both pictures when they are drawn alone; empty: nowhere.
  const Image8& agents_in_both;
};

// The steps from the reference's picture to the test's: order, silhouette, surface (where there is a tolerance),
// shading, texture and the residue, after which the picture is the test's. Throws Error when sizes differ.
std::vector<CauseStep> substitute_surfaces(const SurfaceSubstitution& of);

}  // namespace crowdbench::metrics
