// What a tuning found of one character, by distance, as its page and its charts show it.
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "reports/model/score_doc.h"

namespace crowdbench::reports {

// One candidate at one height of the figure.
struct TunePoint {
  double height_px = 0;
  double depth = 0;  // metres along the view axis, through the tuning's lens
  // Of the error's score at the bad end's 5 %, with its 95 % interval; absent where it has no score. May be infinite.
  std::optional<double> tail, low, high;
  bool allowed = false;
  bool chosen = false;  // by the rule for all characters
};
// What one more agent of a height takes, as it was timed.
struct TuneCost {
  double height_px = 0, depth = 0;
  double ns = 0;
  std::optional<double> low_ns, high_ns;  // 95 %; absent where it is within the noise
};
struct TuneCurve {
  std::string representation;
  std::vector<TunePoint> points;  // from near to far, as are the costs
  std::vector<TuneCost> costs;    // empty where it was not timed
};
// Where the rule changes from one to another, and where a rule of thumb would.
struct TuneMark {
  std::string representation;  // that draws from here on
  double depth = 0;            // metres
  bool predicted = false;
  std::string text;  // "from 24.1 px (31.2 m) on", for people
};
struct TuneGraph {
  ScoreDoc doc;
  double threshold = 0;
  bool bounded = true;            // errors had to keep the threshold: no budget instead
  std::vector<TuneCurve> curves;  // the reference first
  std::vector<TuneMark> marks;
};

}  // namespace crowdbench::reports
