// The scores of comparisons, gathered, and how they are written.
#pragma once
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "reports/model/scene.h"

namespace crowdbench::reports {

// Mean, least and greatest of one score over the agent comparisons of a representation at one height in pixels.
struct ScoreByHeight {
  std::string representation;
  double height_px = 0;
  double mean = 0, least = 0, greatest = 0;
  size_t views = 0;
};
std::vector<ScoreByHeight> scores_by_height(const Scene& scene, const std::string& score);

// std::nullopt where the comparison lacks it.
std::optional<double> score_of(const ComparisonRow& comparison, const std::string& name);

// How a score is written: its heading in a table (with its unit), and whether the worst of several values is the
// greatest. A name that is not known is its own heading.
struct ScoreStyle {
  std::string title;
  int digits = 3;
  bool worst_is_greatest = false;
};
ScoreStyle score_style(std::string_view name);
// "0.987", "31.2", "∞": without the unit, with the score's own digits.
std::string score_text(std::string_view name, double value);

}  // namespace crowdbench::reports
