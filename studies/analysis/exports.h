// The analysed answers in the forms of other tools, so that somebody else can repeat the analysis: files by name and
// text; whoever calls writes them.
//
//   README.md                      what is what
//   dataset_description.json       with data/study_answers_data.csv: a data set in the manner of Psych-DS
//   pwcmp/TASK.csv                 Observer,Session,Scene,Condition_1,Condition_2,Selection: of comparisons, by choice
//   psignifit/TASK-CONDITION.csv   level,correct,total: of answers with levels
//   analysis.R                     the mixed models by lme4, beside what this program estimated
//   estimates.csv                  what it estimated
// Names in CSV files stand as text::spreadsheet_safe() has them.
#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "studies/analysis/analysis.h"

namespace crowdbench::studies {

struct ExportedFile {
  std::string name;  // with folders, by '/'
  std::string text;
};
std::vector<ExportedFile> export_files(const Analysis& analysis);
// Writes them below `folder`, made where it is missing. Throws Error as write_file().
void write_exports(const Analysis& analysis, const std::filesystem::path& folder);

}  // namespace crowdbench::studies
