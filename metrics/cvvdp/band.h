// One band of one frame: from Gaussian levels to visible differences.
#pragma once
#include <functional>
#include <span>
#include <string_view>
#include <vector>

#include "metrics/cvvdp/pyramid.h"
#include "metrics/cvvdp/sensitivity.h"

namespace crowdbench::metrics::vdp {

// Rows of what happens inside, for tests: "log10_Lbkg_test", "log10_Lbkg_ref" (channel 0), "contrast_test",
// "contrast_ref", "S_corrected", "min_masker_blurred", "mask_pooled", "D". Rows of one strip come in order; a row near
// a strip's end may come twice.
using BandProbe = std::function<void(std::string_view stage, size_t channel, int y, std::span<const float> row)>;

// The planes of a level and of the next one, [0] of the test, [1] of the reference.
struct BandInput {
  size_t channels = 0;
  std::array<PerChannel<const FloatPlane*>, 2> fine{}, coarse{};
  bool finest = false;                 // its contrasts count once, those of others twice
  PerChannel<SensitivityLines> lines;  // with the channel's gain
  const BandProbe* probe = nullptr;
};

struct BandOutput {
  PerChannel<std::vector<double>> row_sums;  // of P(D, 2), by row
  FloatPlane* map = nullptr;                 // P(sum over channels of P(D w, 4), 1/4); none: not wanted
  PerChannel<float> map_weight{};            // w
};

// Rows first_row .. last_row - 1 of a band-pass band. Rows are independent of how they are cut into strips.
void band_rows(const BandInput& in, int first_row, int last_row, BandOutput& out);

// The base band, which has neither masking nor gain: Q by channel. fine: the coarsest level.
PerChannel<double> base_band(const BandInput& in, BandOutput& out);

}  // namespace crowdbench::metrics::vdp
