// Based on: ColorVideoVDP (Mantiuk et al. 2024).
#include "metrics/cvvdp/window.h"

#include <algorithm>

#include "core/parallel.h"
#include "metrics/cvvdp/fast_math.h"

namespace crowdbench::metrics::vdp {
namespace {

// The weights of one frame that is kept.
struct Tap {
  const std::array<OpponentPlanes, 2>* frame = nullptr;
  PerChannel<double> weight{};
};

CROWDBENCH_VECTORISED
void add_weighted(const float* __restrict in, float weight, float* __restrict out, size_t count) {
  for (size_t x = 0; x < count; ++x) out[x] += weight * in[x];
}

// Achromatic planes feed two channels.
CROWDBENCH_VECTORISED
void add_weighted_twice(const float* __restrict in, float first, float second, float* __restrict out,
                        float* __restrict other, size_t count) {
  for (size_t x = 0; x < count; ++x) {
    out[x] += first * in[x];
    other[x] += second * in[x];
  }
}

void filter_row(const std::vector<Tap>& taps, size_t picture, int y, size_t count, PerChannel<FloatPlane>& out) {
  for (FloatPlane& plane : out) std::fill_n(plane.row(y), count, 0.0F);
  for (const Tap& tap : taps) {
    const OpponentPlanes& planes = (*tap.frame)[picture];
    const auto weight = [&](size_t c) { return static_cast<float>(tap.weight[c]); };
    add_weighted_twice(planes[0].row(y), weight(0), weight(3), out[0].row(y), out[3].row(y), count);
    for (size_t c = 1; c < kStillChannels; ++c) add_weighted(planes[c].row(y), weight(c), out[c].row(y), count);
  }
}

}  // namespace

FrameWindow::FrameWindow(double fps, Padding padding) : taps_(temporal_taps(fps)), padding_(padding) {
  places_.resize(length());
}

std::array<OpponentPlanes, 2>& FrameWindow::place(size_t frame) { return places_[frame % length()]; }

void FrameWindow::filter(size_t frame, size_t frames, FramePlanes& out, unsigned threads) const {
  // Newest first; frames that stand for several places add their weights.
  std::vector<Tap> taps;
  for (size_t t = 0; t < length(); ++t) {
    const size_t source =
        padded_frame(static_cast<int64_t>(frame) - static_cast<int64_t>(t), frames, padding_) % length();
    auto found = std::find_if(taps.begin(), taps.end(), [&](const Tap& tap) { return tap.frame == &places_[source]; });
    if (found == taps.end()) found = taps.insert(taps.end(), Tap{&places_[source]});
    for (size_t c = 0; c < kChannels; ++c) found->weight[c] += taps_[c][t];
  }
  const FloatPlane& size = (*taps[0].frame)[0][0];
  for (auto& picture : out)
    for (FloatPlane& plane : picture) plane.resize(size.width, size.height);
  parallel_for(2 * static_cast<size_t>(size.height), threads, [&](size_t i) {
    filter_row(taps, i % 2, static_cast<int>(i / 2), static_cast<size_t>(size.width), out[i % 2]);
  });
}

}  // namespace crowdbench::metrics::vdp
