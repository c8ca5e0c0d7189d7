// One frame compared: the pyramids of test and reference, band by band.
#pragma once
#include <vector>

#include "metrics/cvvdp/band.h"
#include "metrics/cvvdp/pooling.h"

namespace crowdbench::metrics::vdp {

// Planes of a frame's channels, [0] of the test, [1] of the reference.
using FramePlanes = std::array<PerChannel<FloatPlane>, 2>;

// Buffers and tables for frames of one size, kept between frames.
class FrameComparison {
 public:
  // Both sides at least 2. threads: at least 1.
  FrameComparison(int width, int height, double pixels_per_degree, size_t channels, unsigned threads);

  // Q of the frame. planes: of the size and channels given above. map: if not null, becomes JOD by pixel. probe: told
  // of every band; with one thread only.
  using Probe =
      std::function<void(size_t band, std::string_view stage, size_t channel, int y, std::span<const float> row)>;
  FrameQ compare(const FramePlanes& planes, FloatPlane* map, const Probe* probe = nullptr);

  const std::vector<double>& frequencies() const { return frequencies_; }
  // The planes of a level above 0 as the last frame left them.
  const FramePlanes& level(size_t l) const { return levels_.at(l - 1); }

 private:
  const FloatPlane& plane(const FramePlanes& finest, size_t level, size_t picture, size_t channel) const;
  void reduce(const FramePlanes& finest);
  BandInput input(const FramePlanes& finest, size_t band) const;
  void run_bands(const std::vector<BandInput>& inputs, std::vector<BandOutput>& outputs) const;
  void collapse(std::vector<FloatPlane>& maps, FloatPlane& out) const;

  size_t channels_;
  unsigned threads_;
  std::vector<double> frequencies_;
  std::vector<PerChannel<SensitivityLines>> lines_;  // by band
  std::vector<FramePlanes> levels_;                  // of level 1, 2, ...
};

}  // namespace crowdbench::metrics::vdp
