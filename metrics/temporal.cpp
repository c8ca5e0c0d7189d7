#include "metrics/temporal.h"

#include <cassert>
#include <cmath>
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
  if (++frames_ < 3) return;
  const Frame& before = last_[(frames_ + 1) % 3];
  const Frame& first = last_[frames_ % 3];
  const auto inside = [](const Frame& frame, size_t i) {
    return frame.silhouette.empty() || frame.silhouette.data[i] != 0;
  };
  for (size_t i = 0; i < now.error.data.size(); ++i) {
    if (!inside(now, i) && !inside(before, i) && !inside(first, i)) continue;
    sum_ += std::abs(now.error.data[i] - 2 * before.error.data[i] + first.error.data[i]);
    ++count_;
  }
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

FrameScore start_flicker() {
  auto running = std::make_shared<Flicker>();
  FrameScore out;
  out.take = [running](const ScoreInput& frame, Shared& shared) {
    const LumaPair& luma = luma_pair(frame, shared);
    running->take(luma.reference, luma.test, frame.region);
  };
  out.finish = [running] {
    ScoreResult result;
    result.value = running->value();
    if (!result.value) result.reason = kTooFew;
    return result;
  };
  return out;
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
    .over_time = start_flicker,
};

}  // namespace crowdbench::metrics
