#include "bench/experiments/clip_scores.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>
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
  of.by_frame = of.result.by_frame;
  for (size_t f = 0; f < of.by_frame.size(); ++f) {
    const std::optional<double>& value = of.by_frame[f];
    if (!value) {
      ++of.absent;
      continue;
    }
    if (of.worst_frame && !metrics::is_worse(*of.score, *value, *of.worst.value)) continue;
    of.worst_frame = f;
    of.worst.value = value;
  }
  if (of.worst_frame) of.worst.map = of.result.map;
}

// Whether the worst frame is worse than equal pictures are, and a frame of the whole.
void keep_worst(ClipScore& of) {
  if (!of.worst_frame || (of.not_finite == 0 && *of.worst.value != metrics::best_value(*of.score))) return;
  of.worst_frame.reset();
  of.worst = {};
}

// No score of the whole where pixels of a frame are not finite: reasons are of the first such frame.
void give_up(ClipScore& of) {
  std::string reason = std::move(of.result.reason);
  if (of.not_finite > 1) reason += fmt::format("; so it is in {} of {} frames", of.not_finite, of.by_frame.size());
  of.result = metrics::absent_not_finite(std::move(reason));
}

// "; min the least and max the greatest of all frames"
std::string extremes_text(const metrics::ScoreResult& result) {
  std::string text;
  for (const metrics::ScoreFigure& of : result.pooled) {
    if (of.over_frames == metrics::OverFrames::mean) continue;
    text += text.empty() ? "; " : " and ";
    text += of.name + (of.over_frames == metrics::OverFrames::least ? " the least" : " the greatest");
  }
  return text.empty() ? text : text + " of all frames";
}

}  // namespace

void FigureOverFrames::add(double value) {
  if (!std::isfinite(value)) return;
  sum += value;
  least = frames == 0 ? value : std::min(least, value);
  greatest = frames == 0 ? value : std::max(greatest, value);
  ++frames;
}

double FigureOverFrames::pooled(metrics::OverFrames how, double otherwise) const {
  if (frames == 0) return otherwise;
  switch (how) {
    case metrics::OverFrames::least: return least;
    case metrics::OverFrames::greatest: return greatest;
    case metrics::OverFrames::mean: break;
  }
  return sum / static_cast<double>(frames);
}

ClipComparison::ClipComparison(metrics::ScoreTable table, metrics::Needs also)
    : still_(those(table, false)), moving_(those(table, true)), also_(also), over_time_(moving_), table_(table) {}

void ClipComparison::take(const metrics::ScoreInput& frame) {
  metrics::Shared shared;
  auto scored = metrics::score_pictures(still_, frame, shared, also_);
  if (frames_ == 0) {
    by_frame_.resize(scored.size());
    pooled_.resize(scored.size());
  }
  for (size_t i = 0; i < std::min(scored.size(), by_frame_.size()); ++i) {
    ClipScore& of = by_frame_[i];
    metrics::ScoreResult& result = scored[i].result;
    of.score = scored[i].score;
    of.by_frame.push_back(result.value);
    if (!result.value) {
      ++of.absent;
      if (result.not_finite && of.not_finite++ == 0)
        of.result.reason = fmt::format("frame {}: {}", frames_, result.reason);
      else if (of.result.reason.empty())
        of.result.reason = result.reason;
      continue;
    }
    if (std::isinf(*result.value)) ++of.infinite;
    of.result.conditions = result.conditions;
    pooled_[i].resize(1 + result.pooled.size());
    pooled_[i][0].add(*result.value);
    for (size_t k = 0; k < result.pooled.size(); ++k) pooled_[i][k + 1].add(result.pooled[k].value);
    of.result.pooled = result.pooled;
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
    if (all[i].not_finite > 0) give_up(all[i]);
    if (!all[i].worst_frame || all[i].not_finite > 0) continue;
    result.reason.clear();
    // Where no frame has a finite value all are infinite, and so is the worst.
    result.value = pooled_[i][0].pooled(metrics::OverFrames::mean, *all[i].worst.value);
    for (size_t k = 0; k < result.pooled.size(); ++k) {
      metrics::ScoreFigure& of = result.pooled[k];
      of.value = pooled_[i][k + 1].pooled(of.over_frames, all[i].worst.pooled[k].value);
    }
  }
  for (metrics::Scored& scored : over_time_.finish()) {
    ClipScore& of = all.emplace_back();
    of.score = scored.score;
    of.result = std::move(scored.result);
    of.over_time = true;
    keep_frames_over_time(of);
  }
  for (ClipScore& of : all) keep_worst(of);
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

std::string pooling_of_figures_text(const ClipScore& score) {
  return pooling_text(score) + (score.over_time ? std::string() : extremes_text(score.result));
}

}  // namespace crowdbench::bench
