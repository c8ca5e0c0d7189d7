// What the rows of causes and of switches say: sentences, and tables.
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "reports/model/score_doc.h"
#include "store/rows.h"

namespace crowdbench::reports {

// "flat against mesh, views of one agent of mannequin: the error is dominated by: below 60 pixels: the stored view
// (...)": one for each representation whose causes the run has, in the order of the rows.
std::vector<std::string> cause_sentences(const StoreContents& contents, int64_t run);

// "hybrid(mesh,flat,distance=20): 14 switches of 9 agents, 12 of them seen. The most visible: ...": one for each
// representation whose switches the run has. docs: of the scores of switches, the one that sorts them first.
std::vector<std::string> pop_sentences(const StoreContents& contents, int64_t run, const std::vector<ScoreDoc>& docs);

// The shares of the causes by height: a row a representation and range, a column a cause that any range has.
struct CauseTableRow {
  const CauseRangeRow* range = nullptr;
  std::vector<std::string> shares;  // "62 %"; "–" where it has none
};
struct CauseTable {
  std::vector<std::string> titles;  // of the causes
  std::vector<CauseTableRow> rows;
};
CauseTable cause_table(const StoreContents& contents, int64_t run);
// "60 to 120", "below 15", "480 and more": pixels.
std::string height_range_text(const CauseRangeRow& range);

// The most visible switches of a representation, best known first by docs[0].
struct PopList {
  std::string representation, display;
  size_t switches = 0, seen = 0;
  std::vector<const PopRow*> worst;
};
// most: rows of each list.
std::vector<PopList> pop_lists(const StoreContents& contents, int64_t run, const std::vector<ScoreDoc>& docs,
                               size_t most);
std::optional<double> score_of(const PopRow& pop, const std::string& name);

}  // namespace crowdbench::reports
