// HDR-FLIP: FLIP of pictures in linear light, whatever their range, as the worst over exposures that a person might
// choose to look at them with: the greatest over exposures e of FLIP(t(2^e reference), t(2^e test)), pixel by pixel, t
// the tone mapper; 0 .. 1, lower is better, viewing conditions those of FLIP (metrics/flip.h). Limits: the exposures
// follow the reference alone, so a test that is brighter everywhere is held at white; what one exposure shows counts as
// if it were seen at all. Without a positive median, or where the range would end before it starts, there is no value.
// Based on: P. Andersson, J. Nilsson, P. Shirley, T. Akenine-Moeller, "Visualizing errors in rendered high dynamic
// range images", Eurographics short papers, 2021; constants of FLIP 1.6. Differs from the reference tool: a median of 0
// and a range that ends before it starts give no value and say why.
#pragma once
#include <cstdint>
#include <optional>
#include <string>

#include "metrics/flip.h"

namespace crowdbench::metrics {

enum class ToneMapper : uint8_t {
  aces,     // a rational fit of ACES filmic, by component
  hable,    // Hable's filmic curve, by component
  reinhard  // RGB / (1 + luminance)
};

struct HdrFlipSettings {
  FlipSettings flip;
  ToneMapper tone_mapper = ToneMapper::aces;
  // Exposures as powers of two. Where not given: that at which the reference's greatest luminance is mapped to 0.85,
  // and that at which its median is.
  std::optional<double> start, stop;
  std::optional<int> exposures;  // how many, 2 or more (asserted); else one a stop, at least 2
};

// Exposures from `start` to `stop`, evenly.
struct ExposureRange {
  double start = 0;
  double stop = 0;
  int exposures = 2;
  std::string reason;  // why there is none: a median of 0, start above stop; empty where there is one
  double at(int i) const { return start + i * (stop - start) / (exposures - 1); }
};
// reference: linear RGB (BT.709) or grey, finite.
ExposureRange exposure_range(const ImageF& reference, const HdrFlipSettings& settings = {});

struct HdrFlip {
  ExposureRange range;
  ImageF map;       // the greatest FLIP of all exposures, by pixel
  ImageF exposure;  // that exposure's place in the range, 0..1; the first that reached it
};
// Linear RGB (BT.709) or grey, any range, finite (asserted); alpha is ignored. Maps are empty where range.reason says
// why. Throws Error when sizes differ.
HdrFlip hdr_flip(const ImageF& reference, const ImageF& test, const HdrFlipSettings& settings = {});

}  // namespace crowdbench::metrics
