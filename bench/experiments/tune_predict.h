// What is predicted of a candidate without looking at a picture: the rules of thumb that a tuning is held beside.
//
//   one texel a pixel  Dobbyn et al. 2005: an impostor may be drawn from where a texel spans no more than a pixel
//   an error of one pixel  as Godot's default has it: a coarser mesh from where its largest distance from the
//     character's spans no more than a pixel
#pragma once
#include <optional>

#include "bench/experiments/tune.h"

namespace crowdbench::bench {

struct TunePrediction {
  double texel = 0;  // metres; 0: it has none
  double error = 0;  // metres; 0: it is not a coarser mesh
};
// Bakes the candidate, or reads its bake. One that cannot be had has neither.
TunePrediction predict(gl::Context& context, const TuneRequest& request, const TuneSubject& subject,
                       const renderers::Spec& candidate);

// Pixels that so many metres of a character span where it is height_px tall; and the height at which they span one.
double pixels_spanned(double metres, const TuneSubject& subject, double height_px);
std::optional<double> height_of_one_pixel(double metres, const TuneSubject& subject);

}  // namespace crowdbench::bench
