#include "metrics/temporal.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <memory>

#include "metrics/intermediates.h"
#include "metrics/sizes.h"

namespace crowdbench::metrics {
namespace {

// Luma of the test less luma of the reference. Differences over time of T - R are those of T less those of R.
Plane error_of(const Plane& reference, const Plane& test) {
  require_same_size(reference, test);
  Plane error = test;
  for (size_t i = 0; i < error.data.size(); ++i) error.data[i] -= reference.data[i];
  return error;
}

}  // namespace

void Flicker::take(const Plane& reference, const Plane& test, const Mask* silhouette) {
  Frame& now = last_[frames_ % 3];
  now.error = error_of(reference, test);
  now.silhouette = silhouette ? *silhouette : Mask();
  if (silhouette) require_same_size(now.error, now.silhouette);
  if (frames_ > 0) require_same_size(now.error, last_[(frames_ + 2) % 3].error);
  by_frame_.emplace_back();
  if (++frames_ < 3) return;
  double sum = 0;
  uint64_t count = 0;
  for (size_t i = 0; i < now.error.data.size(); ++i) {
    if (!counts(i)) continue;
    sum += change(i);
    ++count;
  }
  if (count > 0) by_frame_.back() = sum / static_cast<double>(count);
  sum_ += sum;
  count_ += count;
}

bool Flicker::counts(size_t pixel) const {
  return std::any_of(last_.begin(), last_.end(),
                     [&](const Frame& frame) { return frame.silhouette.empty() || frame.silhouette.data[pixel] != 0; });
}

double Flicker::change(size_t pixel) const {
  const auto error = [&](size_t frame) { return last_[frame % 3].error.data[pixel]; };
  return std::abs(error(frames_ - 1) - 2 * error(frames_ - 2) + error(frames_ - 3));
}

Plane Flicker::map() const {
  assert(frames_ >= 3);
  Plane out(last_[0].error.width, last_[0].error.height, 1);
  for (size_t i = 0; i < out.data.size(); ++i)
    out.data[i] = counts(i) ? change(i) : std::numeric_limits<double>::quiet_NaN();
  return out;
}

std::optional<double> Flicker::value() const {
  if (count_ == 0) return std::nullopt;
  return sum_ / static_cast<double>(count_);
}

std::optional<double> flicker(std::span<const Image8> reference, std::span<const Image8> test,
                              std::span<const Mask> silhouettes) {
  assert(reference.size() == test.size());
  assert(silhouettes.empty() || silhouettes.size() == reference.size());
  Flicker running;
  for (size_t t = 0; t < reference.size(); ++t)
    running.take(luma601(reference[t]), luma601(test[t]), silhouettes.empty() ? nullptr : &silhouettes[t]);
  return running.value();
}

std::vector<double> step_difference(std::span<const Image8> reference, std::span<const Image8> test) {
  assert(reference.size() == test.size());
  std::vector<double> steps;
  Plane before;
  for (size_t t = 0; t < reference.size(); ++t) {
    Plane error = error_of(luma601(reference[t]), luma601(test[t]));
    if (t > 0) {
      require_same_size(error, before);
      double sum = 0;
      for (size_t i = 0; i < error.data.size(); ++i) sum += std::abs(error.data[i] - before.data[i]);
      steps.push_back(sum / static_cast<double>(error.data.size()));
    }
    before = std::move(error);
  }
  return steps;
}

namespace {

constexpr std::string_view kTooFew = "fewer than three frames, or nothing is drawn";
constexpr double kWorstDrawn = 255;  // red, as in the map of differences; one frame that is half as far off is as red

// A clip, and the map of the first of its frames that flicker most.
struct RunningFlicker {
  Flicker flicker;
  std::optional<double> worst;
  Plane map;

  void take(const ScoreInput& frame, Shared& shared) {
    const LumaPair& luma = luma_pair(frame, shared);
    flicker.take(luma.reference, luma.test, frame.region);
    const std::optional<double>& value = flicker.by_frame().back();
    if (!frame.maps || !value || (worst && *value <= *worst)) return;
    worst = value;
    map = flicker.map();
  }
  ScoreResult finish() const {
    ScoreResult result;
    result.value = flicker.value();
    result.by_frame = flicker.by_frame();
    if (!result.value) result.reason = kTooFew;
    if (worst) result.map = ScoreMap{map, 0, 0, 0, kWorstDrawn, "code values", true};
    return result;
  }
};

FrameScore start_flicker() {
  auto running = std::make_shared<RunningFlicker>();
  return {[running](const ScoreInput& frame, Shared& shared) { running->take(frame, shared); },
          [running] { return running->finish(); }};
}

}  // namespace

extern const Score score_flicker = {
    .name = "flicker",
    .title = "flicker",
    .column = "flicker",
    .unit = "code values",
    .direction = Direction::lower_is_better,
    .digits = 3,
    .least = 0,
    .greatest = 1020,
    .needs = kNeedsCodes | kNeedsFrames,
    .scope = Scope::region,
    .computes =
        "mean of abs of the second difference in time of luma, less the reference's, over three frames' regions",
    .source = "",
    .absence = kTooFew,
    .map_file = "flicker_map",
    .over_time = start_flicker,
};

}  // namespace crowdbench::metrics
