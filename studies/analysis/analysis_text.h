// An analysis in words and tables, each once: what Markdown and the page both show.
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "studies/analysis/analysis.h"

namespace crowdbench::studies {

struct TextTable {
  std::vector<std::string> columns;
  size_t words = 1;  // so many of the first columns hold words, the others numbers
  std::vector<std::vector<std::string>> rows;
};

enum class Topic { shares, equivalence, differences, detection, curves, mixed, ranking, prediction };

// One piece of what is told of a task. Plain text; names from files have lost their control characters.
struct Section {
  Topic topic = Topic::shares;
  std::string heading;
  std::string lead;               // before the table
  std::vector<std::string> list;  // behind it
  std::optional<TextTable> table;
  std::string note;  // at the end
};
struct TaskText {
  std::string name;  // of the task, for a heading
  // The sentences that may be written in a paper, one a condition or finding; what the data do not carry says so.
  std::vector<std::string> verdicts;
  std::vector<Section> sections;
};
struct AnalysisText {
  std::string who;                // "people", "simulated observers", "people and simulated observers"
  std::vector<std::string> lead;  // sentences: what was analysed, who and what was left out, by which rules
  std::vector<TaskText> tasks;
};
AnalysisText analysis_text(const Analysis& analysis);

}  // namespace crowdbench::studies
