// ColorVideoVDP: how visible the difference of two pictures or two clips is to a person at a stated display.
//
// In just-objectionable differences (JOD): 10 = no visible difference, exactly so for equal input; one less means that
// 75 % of people would prefer the reference; no lower bound (a strong difference is below 0, and is not cut off).
//
// Each frame becomes light at the display, opponent channels (achromatic sustained and transient, red-green,
// yellow-violet; temporal_filter.h, opponent.h) and bands of a contrast pyramid (pyramid.h). In each band the contrasts
// of both, times the sensitivity at its frequency, luminance and channel (sensitivity.h), are compared: the
// difference's power over one plus what masks it (band.h). The differences are pooled as power means over pixels,
// bands, channels and frames into Q, and JOD = 10 - kJodA Q^kJodExponent (parameters.h), for small Q along the straight
// line to 10. Based on: R. K. Mantiuk, P. Hanji, M. Ashraf, Y. Asano, A. Chapiro, "ColorVideoVDP: A visual difference
// predictor for image, video and display distortions", ACM TOG 43(4), 2024, doi 10.1145/3658144, in the version 0.5.6
// of its authors' program (github.com/gfxdisp/ColorVideoVDP, commit 7ca201a), base model. Colour space and viewing
// conditions: the display's (metrics/display.h). Pictures are never scaled to it. Agrees with that program, which works
// in single precision too, within 1.5e-5 JOD on each of 147 pictures and clips (tests/metrics/cvvdp_test.cpp, which
// asks for 1e-4). Sums are in double precision and in one order: the bits depend neither on the number of threads nor
// on the processor.
//
// Differs from the source: contrast sensitivity from formulas in place of a table (sensitivity.h); a picture of one
// channel is grey, not three copies of a luminance; values that are not finite are refused. Limits, which are the
// metric's own:
//   - A uniform change of luminance is invisible to it: black against white scores 10.
//   - A still scored as a clip is lower than scored as a picture: never compare the two.
//   - It looks back only: the last 1/8 s of a clip count less, and what stands for the frames before the first
//   (Padding)
//     counts with the first. Keep 1/4 s around what is to be judged.
//   - Frames count alike: long equal stretches dilute a short event. The score depends on the frame rate.
//   - Where one side has an odd and the other an even size the last column counts a little too much or too little, as
//   in
//     the source.
#pragma once
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "core/image.h"
#include "metrics/cvvdp/temporal_filter.h"
#include "metrics/display.h"

namespace crowdbench::metrics {

struct CvvdpMap {
  double q = 0;  // CvvdpResult::frame_q of its frame
  ImageF jod;  // one channel: what each pixel would score, 10 = no visible difference; bands and channels pooled there
};

struct CvvdpOptions {
  double fps = 0;  // of clips: above 0, at most 1000; a single picture needs none
  Padding padding = Padding::replicate;
  unsigned threads = 0;  // as parallel_for
  // If set: called for every frame in order with its map. Takes a picture up to half as long again, a clip a tenth.
  std::function<void(size_t frame, CvvdpMap&& map)> map;
};

struct CvvdpResult {
  double jod = 10;
  double q = 0;                     // the pooled difference that JOD is a function of; 0 = none
  bool still = true;                // scored as a picture (three channels), not as a clip (four)
  std::vector<double> frequencies;  // cycles per degree, by band; the base band last
  // By frame, channel (achromatic sustained, red-green, violet-yellow; of a clip also achromatic transient) and band:
  // the root mean square of the visible difference, before weights.
  std::vector<std::vector<std::vector<double>>> by_frame;
  // By frame: over bands and channels, with weights; what `q` is the root mean square of, in a clip.
  std::vector<double> frame_q;
  // By channel: its part of `q`, pooled alone over bands and frames.
  std::vector<double> channel_q;
};

// JOD of a pooled difference: 10 at 0, about 0.044 less for each unit.
double cvvdp_jod(double q);

// Why the two cannot be scored: a side below 2 pixels, values that are not finite. Empty: they can.
std::string cvvdp_obstacle(int width, int height);
std::string cvvdp_obstacle(const ImageF& reference, const ImageF& test);

// Frames are shown to it in order, one at a time; it keeps 1/4 s of them (24 bytes a pixel and frame).
class Cvvdp {
 public:
  explicit Cvvdp(const Display& display, CvvdpOptions options = {});
  ~Cvvdp();
  Cvvdp(const Cvvdp&) = delete;
  Cvvdp& operator=(const Cvvdp&) = delete;

  // All frames of one size and both of one kind: sRGB-like code values of the display's colour space, or floats as
  // light_of() takes them (cd/m2 where the colour space is linear, else encoded values of 0..1). Grey counts as R = G =
  // B; alpha is left out (composite with over() first). Throws Error where sizes differ, where cvvdp_obstacle() says
  // so, and where a second frame comes without a frame rate.
  void take(const Image8& reference, const Image8& test);
  void take(const Image16& reference, const Image16& test);
  void take(const ImageF& reference, const ImageF& test);
  size_t frames() const;

  // After the last frame, once. Throws Error when there was none.
  CvvdpResult finish();

 private:
  class State;
  std::unique_ptr<State> state_;
};

// Two pictures.
CvvdpResult cvvdp(const Image8& reference, const Image8& test, const Display& display, CvvdpOptions options = {});
CvvdpResult cvvdp(const Image16& reference, const Image16& test, const Display& display, CvvdpOptions options = {});
CvvdpResult cvvdp(const ImageF& reference, const ImageF& test, const Display& display, CvvdpOptions options = {});

}  // namespace crowdbench::metrics
