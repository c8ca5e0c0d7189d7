// Scores of two sequences of frames: each frame's where a score is of pictures, one for the whole where it is over
// time.
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "metrics/registry.h"

namespace crowdbench::bench {

// One score of a sequence.
struct ClipScore {
  const metrics::Score* score = nullptr;
  // Of the whole sequence. Over time: as the score itself pools. Else of the frames that have a finite value: the mean
  // of `value`, and of every pooled figure the mean, the least or the greatest, as it says (ScoreFigure::over_frames);
  // infinite where all are. Nothing where a frame has none because its pixels are not finite.
  metrics::ScoreResult result;
  bool over_time = false;
  std::vector<std::optional<double>> by_frame;  // empty where the score is over time and has none
  size_t infinite = 0;                          // frames of an infinite value (equal pictures, for some scores)
  size_t absent = 0;                            // frames without a value
  size_t not_finite = 0;                        // of these, frames with pixels that are not finite
  std::optional<size_t> worst_frame;  // the first of the worst value; nothing where all are as of equal frames
  metrics::ScoreResult worst;         // there: its value, map and drawings
};

// The finite values of one figure, frame by frame.
struct FigureOverFrames {
  double sum = 0, least = 0, greatest = 0;
  size_t frames = 0;

  void add(double value);
  double pooled(metrics::OverFrames how, double otherwise) const;  // `otherwise`: without a frame
};

// While frames are shown to it, in order and one at a time.
class ClipComparison {
 public:
  // table: of scores that outlive it. also: as score_pictures().
  ClipComparison(metrics::ScoreTable table, metrics::Needs also);
  // A score that is over time is not computed of single frames too. frame.maps: keep the map of each score's worst.
  void take(const metrics::ScoreInput& frame);
  // In the table's order.
  std::vector<ClipScore> finish();
  size_t frames() const { return frames_; }

 private:
  std::vector<const metrics::Score*> still_, moving_;
  metrics::Needs also_;
  metrics::ClipScores over_time_;
  metrics::ScoreTable table_;
  std::vector<ClipScore> by_frame_;
  std::vector<std::vector<FigureOverFrames>> pooled_;  // by score: its value, then its pooled figures
  size_t frames_ = 0;
};

// "mean over frames", "over time, ...": how the value of `result` follows from the frames.
std::string pooling_text(const ClipScore& score);
// The same of its pooled figures too: "mean over frames; min the least and max the greatest of all frames".
std::string pooling_of_figures_text(const ClipScore& score);

}  // namespace crowdbench::bench
