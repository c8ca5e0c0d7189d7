// Structural similarity with its map, and over five scales; gradient magnitude similarity deviation.
//
// Colour space: BT.601 luma of sRGB code values, 0..255, which is not the luminance of a screen; colour has no say.
// Viewing conditions: none is modelled; a pixel is a pixel, at whatever distance it is looked at (FLIP and
// ColorVideoVDP are told where). Limits: of a picture that is mostly background these are mostly of that background,
// where both agree: score the figure (`ssim_union`, a crop). Where both pictures are nearly flat SSIM is ruled by its
// constants, and by rounding.
#pragma once
#include <optional>
#include <string>

#include "metrics/difference.h"

namespace crowdbench::metrics {

constexpr int kSsimWindow = 11;
constexpr int kSsimRadius = kSsimWindow / 2;
constexpr int kMsSsimSmallest = 176;

// SSIM of Z. Wang, A. C. Bovik, H. R. Sheikh, E. P. Simoncelli, "Image quality assessment: from error visibility to
// structural similarity", IEEE TIP 13(4), 2004; the mean of the map is the score. With mu the means, s the (population)
// variances and covariance under an 11 x 11 Gaussian window of sigma 1.5:
//   SSIM = (2 mu_a mu_b + C1) (2 s_ab + C2) / ((mu_a^2 + mu_b^2 + C1) (s_a + s_b + C2)),
//   C1 = (0.01 * 255)^2, C2 = (0.03 * 255)^2.
struct Ssim {
  double mean = 0;      // of the map; 1 = equal, lower is worse, -1 the least possible
  double contrast = 0;  // mean of the second factor alone, (2 s_ab + C2) / (s_a + s_b + C2)
  // One value a window that lies wholly inside: (width - 10) x (height - 10). Element (x, y) belongs to the pixel
  // (x + 5, y + 5).
  Plane map;
};
// a, b: luma601() of the pictures (or any planes of 0..255). Nothing when a side is below 11 pixels: the window does
// not fit, and no smaller one is put in its place. Throws Error when the sizes differ.
std::optional<Ssim> ssim(const Plane& a, const Plane& b);

// MS-SSIM of Z. Wang, E. P. Simoncelli, A. C. Bovik, "Multiscale structural similarity for image quality assessment",
// 37th Asilomar Conference on Signals, Systems and Computers, 2003: the contrast terms of scales 1..4 and the SSIM of
// scale 5, each to its power (0.0448, 0.2856, 0.3001, 0.2363, 0.1333), multiplied. A scale is halved by the mean of 2 x
// 2 pixels (the last row or column of an odd size counts twice). 1 = equal, 0 the least. Nothing when a side is below
// 176 pixels. first: ssim(a, b), where the caller has it already.
std::optional<double> ms_ssim(const Plane& a, const Plane& b, const Ssim* first = nullptr);

// GMSD: the standard deviation (N - 1) of the similarity of gradient magnitudes, (2 g_a g_b + 170) / (g_a^2 + g_b^2 +
// 170), g by Prewitt's operator over 3 on luma halved by the mean of 2 x 2 pixels; beyond the border all is 0. 0 =
// equal, higher is worse, 1 is not reached. Defined for every size; pictures of one pixel or two give 0. Limits:
// away from the border a uniform change of brightness scores nothing.
// Based on: W. Xue, L. Zhang, X. Mou, A. C. Bovik, "Gradient magnitude similarity deviation: a highly efficient
// perceptual image quality index", IEEE TIP 23(2), 2014.
double gmsd(const Plane& a, const Plane& b);

}  // namespace crowdbench::metrics
