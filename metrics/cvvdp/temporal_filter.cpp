// Based on: ColorVideoVDP (Mantiuk et al. 2024). The filters are defined by their gain over frequency and sampled there
// at (taps + 1) / 2 frequencies from 0 to half the frame rate, both ends included; that grid is the reference's.
#include "metrics/cvvdp/temporal_filter.h"

#include <cmath>
#include <numbers>

namespace crowdbench::metrics::vdp {
namespace {

double gain(size_t channel, double frequency) {
  const double beta = kTemporalBeta[channel];
  const double sigma = kTemporalSigma[channel];
  const double w = std::pow(frequency, beta);
  if (channel < kStillChannels) return std::exp(-w / sigma);
  const double off = w - std::pow(kTransientPeak, beta);
  return std::exp(-off * off / sigma);
}

}  // namespace

PerChannel<std::vector<double>> temporal_taps(double fps) {
  const auto half = static_cast<size_t>(std::ceil(kFilterSeconds / 2 * fps));
  const size_t taps = 2 * half + 1;
  PerChannel<std::vector<double>> out;
  for (size_t c = 0; c < kChannels; ++c) {
    out[c].resize(taps);
    for (size_t t = 0; t < taps; ++t) {
      const double shift = static_cast<double>(t) - static_cast<double>(half);
      double sum = gain(c, 0);
      for (size_t k = 1; k <= half; ++k) {
        const double frequency = static_cast<double>(k) * (fps / 2) / static_cast<double>(half);
        sum += 2 * gain(c, frequency) *
               std::cos(2 * std::numbers::pi * static_cast<double>(k) * shift / static_cast<double>(taps));
      }
      out[c][t] = sum / static_cast<double>(taps);
    }
  }
  return out;
}

size_t padded_frame(int64_t i, size_t frames, Padding padding) {
  if (i >= 0) return static_cast<size_t>(i);
  if (padding == Padding::replicate) return 0;
  const auto period = static_cast<int64_t>(frames) - 1;
  const int64_t back = -i - 1;
  if (back / period % 2 == 0) return static_cast<size_t>(back % period + 1);
  return static_cast<size_t>((i % period + period) % period);
}

}  // namespace crowdbench::metrics::vdp
