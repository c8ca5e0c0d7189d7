// What the page of a study shows: texts and tables as the analysis worded them, and the numbers of its charts. Plain
// data; bench/commands fills it.
#pragma once
#include <optional>
#include <string>
#include <vector>

namespace crowdbench::reports {

// A value with the ends of its interval; an end that is nothing is not drawn.
struct StudyPoint {
  std::string name;
  double value = 0;
  std::optional<double> low, high;
  std::string text;  // what a pointer over it is told
};

// How often which of the three answers was given.
struct StudyShares {
  std::string name;
  double yes = 0, ties = 0, no = 0;  // counts
};

struct StudyCurve {
  std::string name;
  struct At {
    double x = 0;
    double share = 0;
    std::optional<double> low, high;
  };
  std::vector<At> points;  // answers, with exact intervals
  std::vector<At> line;    // the fitted function
  std::optional<double> threshold, threshold_low, threshold_high;
  double level = 0;  // at which the threshold is
};

struct StudyTable {
  std::vector<std::string> columns;
  size_t words = 1;  // so many of the first columns hold words
  std::vector<std::vector<std::string>> rows;
};
// What a section's chart is of.
enum class StudyChart { none, shares, curves, ranking, prediction };
struct StudySection {
  std::string heading, lead, note;
  std::vector<std::string> list;
  StudyTable table;  // no columns: none
  StudyChart chart = StudyChart::none;
};

struct StudyTask {
  std::string name;
  std::vector<std::string> verdicts;
  std::vector<StudySection> sections;
  std::vector<StudyShares> shares;
  std::string axis = "level";  // of the curves: "height_px (pixels)"
  std::vector<StudyCurve> curves;
  std::vector<StudyPoint> ranking, prediction;
};

struct StudyPageModel {
  std::string title = "What people answered";
  std::string source;                 // the files that were analysed
  bool planned = false;               // the analysis is the one that was frozen before the first answer
  std::string standing_title;         // where it is not: in a few words
  std::vector<std::string> standing;  // sentences on that; empty: nothing is claimed
  std::vector<std::string> lead;
  std::vector<StudyTask> tasks;
};

}  // namespace crowdbench::reports
