// `regress`: whether a build draws slower or wronger than another one, from two sets of result files.
//
// What is compared is the ratio of a representation's time to the reference's in the same round of the same run, never
// an absolute time of one run with one of another: another day, clock rate or machine load moves both times of a round.
// The reference itself is held against its own floor, since against itself it is always 1.
#pragma once
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/multiple_tests.h"
#include "core/statistics.h"
#include "metrics/registry.h"
#include "store/store.h"

namespace crowdbench::bench {

// From so many runs a side on, runs are the values: what differs from one to the next is then part of the noise.
inline constexpr size_t kRunsAsValues = 5;

struct RegressLimits {
  double least_effect = 0.01;  // a change of a ratio by less is none: the rank test is of more than this
  double detect = 0.05;        // what the data must be able to exclude; else they are not enough
  double level = 0.01;         // of slower and of faster, after the correction over all points
  Correction correction = Correction::holm;
  size_t least_rounds = 9;  // of either side where rounds are the values; fewer are not enough
  // The standard deviation of a ratio's logarithm from one run to the next, where it is known. Rounds of one run share
  // its load, its memory's layout and its clock rates and say nothing of it: without it no time of fewer than
  // kRunsAsValues runs a side has a verdict.
  std::optional<double> run_scatter;
  double score_share = 0.02;  // a score may move away from "equal" by this share of its distance from there
  std::map<std::string, double> score_tolerances;  // by name, in the score's unit, instead
  double picture_share = 0.001;                    // of a picture's pixels that may differ by more than picture_levels
  int picture_levels = 8;                          // code values of any channel
};

enum class Verdict {
  same,        // no worse; of times the interval lies within the least effect on either side
  indistinct,  // of times: a slow-down of `detect` is excluded, but not one of the least effect
  better,      // faster, or nearer to the reference
  worse,       // slower, wronger, or another picture
  unclear,     // not enough data
};
const char* verdict_name(Verdict verdict);

// A point that both sides have.
struct RegressPoint {
  std::string scenario;  // its name
  std::string what;      // "flat:views=64, mannequin, 250 agents, 15 %, 640x480"
  Verdict verdict = Verdict::same;
  std::string reason;  // why the verdict, one line
};

struct TimePoint : RegressPoint {
  PointKey key;
  std::string yardstick;  // what its time is divided by: the reference's canonical text, or "its floor"
  std::string metric;     // "cpu", "wall" or "gpu"
  std::string unit;       // what the values are of: "rounds", "runs", or "intervals" (of the stored medians, where no
                          // samples are kept)
  size_t baseline_values = 0, current_values = 0;
  size_t baseline_runs = 0, current_runs = 0;
  bool judged = true;      // false: too few runs to know what differs between them; there is no test and no interval
  size_t runs_needed = 0;  // where it is unclear: of each side, so that `detect` is found with 80 %; 0: nothing says
  double baseline = 0, current = 0;   // medians of the ratio
  double change = 0;                  // current / baseline - 1
  Interval interval;                  // of the change, 95 %
  double least_effect = 0;            // that was asked for, or what the controls (A/A) show without any change
  double p_slower = 1, p_faster = 1;  // of a change beyond it; before the correction
  double adjusted_slower = 1, adjusted_faster = 1;
  double detectable = 0;  // the smallest slow-down that is found with 80 % before the correction
};

struct ScorePoint : RegressPoint {
  std::string score;  // name
  std::optional<double> baseline, current;
  double tolerance = 0;
};

struct PicturePoint : RegressPoint {
  std::string role;  // "test" or "reference"
  double share = 0;  // of pixels that differ by more than the limit's levels
  int largest = 0;   // difference of a channel, code values
  const PictureRow* baseline = nullptr;
  const PictureRow* current = nullptr;
};

struct RegressReport {
  RegressLimits limits;
  std::vector<TimePoint> times;
  std::vector<ScorePoint> scores;
  std::vector<PicturePoint> pictures;
  std::vector<std::string> only_baseline, only_current;  // points, as RegressPoint::what
  std::optional<Interval>
      drift;  // of the reference's own time, current over baseline, where processes were interleaved
};
// 0: nothing is worse, and of every time a slow-down of `detect` is excluded; 1: something is worse; 3: nothing is
// worse, but something is unclear, of the baseline's points is missing, or there is no point in common.
int exit_status(const RegressReport& report);
size_t count(const RegressReport& report, Verdict verdict);

// Files of either side, read with samples and pictures; both outlive the report. Where both sides have kRunsAsValues
// runs of a point or more, each run is one value; else the rounds of all runs are, with limits.run_scatter added to
// their noise, and without that there is no verdict on times. Throws Error where the sides were drawn by
// different renderers or are judged by different clocks.
RegressReport regress(std::span<const StoreContents> baseline, std::span<const StoreContents> current,
                      const RegressLimits& limits, metrics::ScoreTable table);

}  // namespace crowdbench::bench
