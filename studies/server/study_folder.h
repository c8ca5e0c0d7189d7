// An exported study as its server sees it: the folder that participants may see, and who is to be shown what.
#pragma once
#include <cstdint>
#include <filesystem>
#include <map>
#include <set>
#include <string>
#include <vector>

namespace crowdbench::studies {

struct StudyTrial {
  std::string trial;     // id within the list
  std::string stimulus;  // empty: chosen by the page from StudyFolder::choices
  std::string kind;      // "training", "main" or "catch"
  uint32_t block = 0;
  size_t turn = 0;  // place in the list, from 0
};

struct StudyFile {
  std::filesystem::path path;
  std::string type;  // for Content-Type
};

struct StudyFolder {
  std::string study;                                                // the plan's hash
  std::string task;                                                 // as the plan calls it
  std::string question;                                             // in words; empty: it does not say
  std::vector<std::string> answers;                                 // values that a trial may be answered with
  std::vector<std::string> lists;                                   // ids, in the order of the file
  std::map<std::string, std::map<std::string, StudyTrial>> trials;  // by list, by trial
  std::set<std::string> choices;  // stimuli that an adaptive method may choose; empty of other methods
  std::string adaptive;           // the method's rule as trials.json has it; empty of other methods
  uint64_t frames = 0;            // of a clip; 0: it does not say
  // What is served: by path ("/index.html", "/clips/s001.mp4"), every regular file below OUT/page and nothing else, so
  // that no request can name another one. Symbolic links are left out.
  std::map<std::string, StudyFile> files;
};

// out: what `study export` made; its page/ holds trials.json and the page. Throws Error naming file and member: no such
// folder, not an exported study, another format, ids that are not ids, trials of a stimulus that is not there, no list.
StudyFolder read_study_folder(const std::filesystem::path& out);

// Letters, digits, '-', '_' and '.', up to 64 of them: what ids of lists, trials and stimuli are made of.
bool is_study_id(std::string_view text);

}  // namespace crowdbench::studies
