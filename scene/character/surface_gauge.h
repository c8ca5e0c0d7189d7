// Whether surfaces stay within a distance of one, for those who try many. Defined beside surface_distance, whose places
// and distances it shares.
#pragma once
#include <memory>

#include "scene/character/surface_distance.h"

namespace crowdbench::scene {

// One surface against others, of which it is asked no more than whether they stay within a distance of it: several
// times quicker than to measure each, as what is near enough need not be the nearest, and the first place that is too
// far is the answer.
class SurfaceGauge {
 public:
  explicit SurfaceGauge(const Surface& surface, const SurfacePlaces& places = {});
  ~SurfaceGauge();
  SurfaceGauge(SurfaceGauge&&) noexcept;
  SurfaceGauge& operator=(SurfaceGauge&&) noexcept;

  // Whether surface_distance(surface, other, places).max is at most `bound`. Remembers the place that was too far last,
  // which is looked at first; so one thread at a time.
  bool is_within(const Surface& other, double bound);

 private:
  struct Kept;
  std::unique_ptr<Kept> kept_;
};

}  // namespace crowdbench::scene
