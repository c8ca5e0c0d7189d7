// One figure in front of a plain background, reference against test: what `quality` reports.
#pragma once
#include <string_view>
#include <vector>

#include "metrics/registry.h"
#include "metrics/silhouette.h"

namespace crowdbench::metrics {

// The pictures cut to the box around both silhouettes (crop_box), scored there; the region is the union of the
// silhouettes. Where neither draws anything every score that such pictures have is absent.
struct FigureScores {
  std::vector<Scored> scores;  // of the table, in its order
  std::optional<Box> box;      // what was cut out; nothing where nothing is drawn

  // nullopt where the score is not available, or not of the table.
  std::optional<double> value(std::string_view name) const;
};
struct FigureOptions {
  const ChosenDisplay* display = nullptr;  // none: scores that need one are not there
  bool maps = false;                       // fill ScoreResult::map, over the box
};
// Both with ids and codes; depth where there is one. Throws Error when sizes differ.
FigureScores score_figure(ScoreTable table, const Buffers& reference, const Buffers& test,
                          const FigureOptions& options = {});

}  // namespace crowdbench::metrics
