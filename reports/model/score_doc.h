// What reports know of a score: the program that makes them hands it over, since a result file has names and values
// alone.
#pragma once
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace crowdbench::reports {

struct ScoreDoc {
  std::string name;      // as in the result file
  std::string title;     // in the middle of a sentence
  std::string unit;      // empty for a pure number
  std::string computes;  // the formula in a line
  bool higher_is_better = true;
  int digits = 4;                         // after the point
  std::optional<double> best;             // what two equal pictures score; infinite for some
  bool headline = false;                  // said in the answer and under pictures
  bool charted = false;                   // drawn against the height of the figure
  bool ranking = false;                   // the one that the worst place is found by
  std::optional<double> least, greatest;  // its range, ends infinite for some; nothing: not known
};

// The description of a name. "name.pooled" is the score's with the pooled figure's name; a name that nobody described
// is its own title.
ScoreDoc doc_of(const std::vector<ScoreDoc>& docs, std::string_view name);

// "SSIM in the figure", "PSNR, dB", "Mean absolute error, code values": the head of a column. A name that nobody
// described stands as it is.
std::string heading(const ScoreDoc& doc);
// The value at the score's digits, "∞" for infinity.
std::string score_text(const ScoreDoc& doc, double value);
// ", 1 is equal"; empty where that is not known.
std::string best_text(const ScoreDoc& doc);

}  // namespace crowdbench::reports
