#include "bench/experiments/clip_scores.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace crowdbench::bench {
namespace {

std::vector<const metrics::Score*> those(metrics::ScoreTable table, bool over_time) {
  std::vector<const metrics::Score*> out;
  for (const metrics::Score* score : table)
    if ((score->over_time != nullptr) == over_time) out.push_back(score);
  return out;
}

// The frames of a score over time that says what each adds.
void keep_frames_over_time(ClipScore& of) {
  const std::vector<double>& values = of.result.by_frame;
  of.by_frame.assign(values.begin(), values.end());
  for (size_t f = 0; f < values.size(); ++f) {
    if (of.worst_frame && !metrics::is_worse(*of.score, values[f], *of.worst.value)) continue;
    of.worst_frame = f;
    of.worst.value = values[f];
  }
  if (of.worst_frame) of.worst.map = of.result.map;
}

}  // namespace

ClipComparison::ClipComparison(metrics::ScoreTable table, metrics::Needs also)
    : still_(those(table, false)), moving_(those(table, true)), also_(also), over_time_(moving_), table_(table) {}

void ClipComparison::take(const metrics::ScoreInput& frame) {
  metrics::Shared shared;
  auto scored = metrics::score_pictures(still_, frame, shared, also_);
  if (frames_ == 0) {
    by_frame_.resize(scored.size());
    pooled_.resize(scored.size());
    counts_.resize(scored.size());
  }
  for (size_t i = 0; i < std::min(scored.size(), by_frame_.size()); ++i) {
    ClipScore& of = by_frame_[i];
    metrics::ScoreResult& result = scored[i].result;
    of.score = scored[i].score;
    of.by_frame.push_back(result.value);
    if (!result.value) {
      ++of.absent;
      if (of.result.reason.empty()) of.result.reason = result.reason;
      continue;
    }
    if (std::isinf(*result.value)) ++of.infinite;
    of.result.conditions = result.conditions;
    pooled_[i].resize(1 + result.pooled.size());
    counts_[i].resize(1 + result.pooled.size());
    of.result.pooled.resize(result.pooled.size());
    for (size_t k = 0; k <= result.pooled.size(); ++k) {
      const double value = k == 0 ? *result.value : result.pooled[k - 1].second;
      if (k > 0) of.result.pooled[k - 1].first = result.pooled[k - 1].first;
      if (!std::isfinite(value)) continue;
      pooled_[i][k] += value;
      ++counts_[i][k];
    }
    if (of.worst_frame && !metrics::is_worse(*of.score, *result.value, *of.worst.value)) continue;
    of.worst_frame = frames_;
    of.worst = std::move(result);
  }
  if (!moving_.empty()) over_time_.take(frame);
  ++frames_;
}

std::vector<ClipScore> ClipComparison::finish() {
  std::vector<ClipScore> all = std::move(by_frame_);
  for (size_t i = 0; i < all.size(); ++i) {
    metrics::ScoreResult& result = all[i].result;
    if (!all[i].worst_frame) continue;
    result.reason.clear();
    // Where no frame has a finite value all are infinite, and so is the worst.
    const auto mean = [&](size_t k, double otherwise) {
      return counts_[i][k] > 0 ? pooled_[i][k] / static_cast<double>(counts_[i][k]) : otherwise;
    };
    result.value = mean(0, *all[i].worst.value);
    for (size_t k = 0; k < result.pooled.size(); ++k)
      result.pooled[k].second = mean(k + 1, all[i].worst.pooled[k].second);
  }
  for (metrics::Scored& scored : over_time_.finish()) {
    ClipScore& of = all.emplace_back();
    of.score = scored.score;
    of.result = std::move(scored.result);
    of.over_time = true;
    keep_frames_over_time(of);
  }
  const auto place = [&](const ClipScore& of) { return std::find(table_.begin(), table_.end(), of.score); };
  std::stable_sort(all.begin(), all.end(), [&](const ClipScore& a, const ClipScore& b) { return place(a) < place(b); });
  return all;
}

std::string pooling_text(const ClipScore& score) {
  if (score.over_time) return "over time, as the score itself pools";
  return score.infinite > 0 && score.infinite + score.absent < score.by_frame.size()
             ? "mean over frames that are finite"
             : "mean over frames";
}

}  // namespace crowdbench::bench
