// FLIP: how far two pictures differ to a person who flips between them, pixel by pixel.
//
// Values are 0 (nobody sees a difference) .. 1 (as far apart as colours can be); lower is better. Colour: pictures are
// sRGB, seen at a stated number of pixels per degree of visual angle; what the eye cannot resolve there is filtered
// away. Differences of colour are amplified where edges or points of one picture are missing in the other. Not
// modelled: the luminance of the screen, masking by texture, motion. Alpha is ignored; grey counts as R = G = B.
//
// Both pictures go to YCxCz (D65) and through the eye's contrast sensitivity at that resolution (sums of Gaussians, by
// channel), to RGB held within 0 and 1, and to L*a*b* with Hunt's adjustment. Colour: HyAB distance to the power 0.7,
// of which 0.4 of the greatest one (green to blue) is spread over 0 .. 0.95 and the rest over 0.95 .. 1. Structure: F =
// sqrt(max(|edge difference|, |point difference|) / sqrt 2), edges and points of Y by derivatives of a Gaussian of
// 0.041 degrees. FLIP = colour^(1 - F). Based on: P. Andersson, J. Nilsson, T. Akenine-Moeller, M. Oskarsson, K.
// Astroem, M. D. Fairchild, "FLIP: A difference evaluator for alternating images", Proc. ACM Comput. Graph. Interact.
// Tech. 3(2), 2020; constants of its version 1.6. Pooled figures agree with that tool's within 1e-4
// (tests/metrics/flip_ground_truth_test.cpp). Differs from it: separable filters over tiles, taps that no float sum
// notices left out, roots and powers by metrics/fast_math.h, sums of the pooled figures in double.
//
// Every function throws Error when sizes differ. Results are the same bytes whatever the number of threads.
#pragma once
#include <functional>

#include "metrics/difference.h"

namespace crowdbench::metrics {

// The source's default: 0.7 m before a screen 0.7 m and 3840 pixels wide.
constexpr double kFlipPixelsPerDegree = 67.020643276582255;

struct FlipSettings {
  double pixels_per_degree = kFlipPixelsPerDegree;  // 1 or more (asserted)
  unsigned threads = 0;                             // as parallel_for()
};

// What the error is made of, one channel each, of the pictures' size.
struct FlipStages {
  ImageF colour;  // 0..1
  ImageF edge;    // |edge strength of the reference - of the test|
  ImageF point;
};

// The error of every pixel: one channel. 8 or 16 bits, sRGB-encoded. stages: filled where given.
ImageF flip_map(const Image8& reference, const Image8& test, const FlipSettings& settings = {},
                FlipStages* stages = nullptr);
ImageF flip_map(const Image16& reference, const Image16& test, const FlipSettings& settings = {},
                FlipStages* stages = nullptr);

// Gives row y of a picture, of columns first .. last - 1, as linear RGB (BT.709) of 0..1. Called from several threads.
using LinearRow = std::function<void(int y, int first, int last, float* red, float* green, float* blue)>;
ImageF flip_map(int width, int height, const LinearRow& reference, const LinearRow& test,
                const FlipSettings& settings = {}, FlipStages* stages = nullptr);

// Figures of a map. A weighted quantile q is the value at which the sum of the errors, taken in ascending order, first
// exceeds q times the sum of all: half of the error lies in pixels above the weighted median. All 0 for a map of zeros.
struct FlipPooled {
  double mean = 0;
  double weighted_median = 0;
  double q1 = 0, q3 = 0;  // weighted, 0.25 and 0.75
  double min = 0, max = 0;
};
// map: one channel of values of 0 or above, at least one pixel.
FlipPooled flip_pooled(const ImageF& map);

}  // namespace crowdbench::metrics
