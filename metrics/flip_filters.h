// The filters of FLIP, as taps from the centre outwards.
//
// Based on: P. Andersson, J. Nilsson, T. Akenine-Moeller, M. Oskarsson, K. Astroem, M. D. Fairchild, "FLIP: A
// difference evaluator for alternating images", Proc. ACM Comput. Graph. Interact. Tech. 3(2), 2020.
#pragma once
#include <vector>

namespace crowdbench::metrics {

// Element i belongs to the distance of i pixels, on both sides; at least one.
using Taps = std::vector<float>;

// The contrast sensitivity of the eye, one Gaussian for the achromatic and the red-green channel each, two that are
// added for blue-yellow. Each is applied along x and along y; what the second direction leaves adds up to 1.
struct ContrastFilters {
  Taps achromatic;      // Y
  Taps red_green;       // Cx
  Taps blue_yellow[2];  // Cz: the sum of both, each along x and y
};
// All of radius ceil(3 sqrt(0.04 / (2 pi^2)) ppd). pixels_per_degree: 1 or more.
ContrastFilters contrast_filters(double pixels_per_degree);

// A Gaussian whose width is that of an edge that an eye finds, 0.082 degrees, with its first and second derivative. The
// taps of one sign of a derivative add up to 1. `first` is odd: the tap at -i is minus that at i.
struct FeatureFilters {
  Taps gaussian, first, second;
};
FeatureFilters feature_filters(double pixels_per_degree);

// Without the outermost taps, as far as those left out come to less than 2^-26 of all together: no sum in float of
// values of one size notices them.
Taps trimmed(const Taps& taps);

}  // namespace crowdbench::metrics
