// Based on: ColorVideoVDP (Mantiuk et al. 2024).
#include "metrics/cvvdp/frame.h"

#include <algorithm>
#include <cmath>

#include "core/parallel.h"
#include "metrics/cvvdp/fast_math.h"

namespace crowdbench::metrics::vdp {
namespace {

constexpr int kSmall = 64 * 1024;  // pixels below which starting threads costs more than they save

// sum[x] = expanded[x] + share * map[x]
CROWDBENCH_VECTORISED
void add_band(const float* __restrict expanded, float share, float* __restrict map, size_t count) {
  for (size_t x = 0; x < count; ++x) map[x] = expanded[x] + share * map[x];
}

void add_coarser(const FloatPlane& coarser, float share, FloatPlane& map) {
  std::vector<float> scratch;
  std::vector<float> row(static_cast<size_t>(map.width));
  for (int y = 0; y < map.height; ++y) {
    expand_row(coarser, y, map.width, scratch, row.data());
    add_band(row.data(), share, map.row(y), row.size());
  }
}

CROWDBENCH_VECTORISED
void to_jod(float* __restrict v, size_t count) {
  constexpr float kStraight = 0.1F;
  const auto exponent = static_cast<float>(kJodExponent);
  const auto a = static_cast<float>(kJodA);
  const float slope = a * fast_pow(kStraight, exponent - 1);
  for (size_t i = 0; i < count; ++i) {
    const float held = v[i] > kStraight ? v[i] : kStraight;
    const float curved = 10 - a * fast_pow(held, exponent);
    const float straight = 10 - slope * v[i];
    v[i] = v[i] > kStraight ? curved : straight;
  }
}

}  // namespace

FrameComparison::FrameComparison(int width, int height, double pixels_per_degree, size_t channels, unsigned threads)
    : channels_(channels), threads_(threads), frequencies_(band_frequencies(width, height, pixels_per_degree)) {
  levels_.resize(frequencies_.size() - 1);
  for (FramePlanes& level : levels_) {
    width = (width + 1) / 2;
    height = (height + 1) / 2;
    for (auto& picture : level)
      for (size_t c = 0; c < channels; ++c) picture[c].resize(width, height);
  }
  for (size_t b = 0; b < frequencies_.size(); ++b) {
    const bool base = b + 1 == frequencies_.size();
    lines_.emplace_back();
    for (size_t c = 0; c < channels; ++c)
      lines_.back()[c] = sensitivity_lines(c, frequencies_[b], base ? 1 : kChannelGain[c]);
  }
}

const FloatPlane& FrameComparison::plane(const FramePlanes& finest, size_t level, size_t picture,
                                         size_t channel) const {
  return (level == 0 ? finest : levels_[level - 1])[picture][channel];
}

void FrameComparison::reduce(const FramePlanes& finest) {
  constexpr int kRows = 64;
  for (size_t l = 0; l < levels_.size(); ++l) {
    const FloatPlane& size = levels_[l][0][0];
    const size_t strips = static_cast<size_t>((size.height + kRows - 1) / kRows);
    const unsigned threads = size.width * size.height < kSmall ? 1 : threads_;
    parallel_for(2 * channels_ * strips, threads, [&](size_t i) {
      const size_t picture = i / strips / channels_;
      const size_t channel = i / strips % channels_;
      const int first = static_cast<int>(i % strips) * kRows;
      reduce_rows(plane(finest, l, picture, channel), levels_[l][picture][channel], first,
                  std::min(first + kRows, size.height));
    });
  }
}

BandInput FrameComparison::input(const FramePlanes& finest, size_t band) const {
  BandInput in;
  in.channels = channels_;
  in.finest = band == 0;
  in.lines = lines_[band];
  for (size_t p = 0; p < 2; ++p)
    for (size_t c = 0; c < channels_; ++c) {
      in.fine[p][c] = &plane(finest, band, p, c);
      if (band < levels_.size()) in.coarse[p][c] = &plane(finest, band + 1, p, c);
    }
  return in;
}

// Every band-pass band, cut into strips.
void FrameComparison::run_bands(const std::vector<BandInput>& inputs, std::vector<BandOutput>& outputs) const {
  struct Item {
    size_t band;
    int first, last;
  };
  std::vector<Item> items;
  int pixels = 0;
  for (size_t b = 0; b + 1 < inputs.size(); ++b) {
    const FloatPlane& size = *inputs[b].fine[0][0];
    pixels += size.width * size.height;
    for (size_t c = 0; c < channels_; ++c) outputs[b].row_sums[c].resize(static_cast<size_t>(size.height));
    constexpr int kLeastRows = 64;  // the 12 rows that neighbours compute twice should stay few
    const int cuts = std::clamp(size.height / kLeastRows, 1, threads_ == 1 ? 1 : static_cast<int>(2 * threads_));
    for (int i = 0; i < cuts; ++i) items.push_back({b, size.height * i / cuts, size.height * (i + 1) / cuts});
  }
  parallel_for(items.size(), pixels < kSmall ? 1 : threads_, [&](size_t i) {
    band_rows(inputs[items[i].band], items[i].first, items[i].last, outputs[items[i].band]);
  });
}

// maps: of the bands, the base band last; out: JOD of all together.
void FrameComparison::collapse(std::vector<FloatPlane>& maps, FloatPlane& out) const {
  for (size_t b = maps.size() - 1; b-- > 0;) add_coarser(maps[b + 1], b == 0 ? 1.0F : 0.5F, maps[b]);
  out = std::move(maps[0]);
  to_jod(out.data.data(), out.data.size());
}

FrameQ FrameComparison::compare(const FramePlanes& planes, FloatPlane* map, const Probe* probe) {
  reduce(planes);
  const size_t bands = frequencies_.size();
  std::vector<BandInput> inputs;
  std::vector<BandOutput> outputs(bands);
  std::vector<FloatPlane> maps(map ? bands : 0);
  std::vector<BandProbe> probes(probe ? bands : 0);
  for (size_t b = 0; b < bands; ++b) {
    inputs.push_back(input(planes, b));
    if (probe)
      probes[b] = [probe, b](std::string_view stage, size_t channel, int y, std::span<const float> row) {
        (*probe)(b, stage, channel, y, row);
      };
    if (probe) inputs[b].probe = &probes[b];
    if (!map) continue;
    maps[b].resize(inputs[b].fine[0][0]->width, inputs[b].fine[0][0]->height);
    outputs[b].map = &maps[b];
    for (size_t c = 0; c < channels_; ++c)
      outputs[b].map_weight[c] = static_cast<float>(weight(c, b + 1 == bands, channels_ == kStillChannels));
  }
  run_bands(inputs, outputs);
  FrameQ q(channels_, std::vector<double>(bands));
  for (size_t b = 0; b + 1 < bands; ++b) {
    const FloatPlane& size = *inputs[b].fine[0][0];
    for (size_t c = 0; c < channels_; ++c) {
      double sum = 0;
      for (const double row : outputs[b].row_sums[c]) sum += row;
      q[c][b] = power(sum / static_cast<double>(size.data.size()), 0.5);
    }
  }
  const PerChannel<double> base = base_band(inputs.back(), outputs.back());
  for (size_t c = 0; c < channels_; ++c) q[c].back() = base[c];
  if (map) collapse(maps, *map);
  return q;
}

}  // namespace crowdbench::metrics::vdp
