// The report: one self-contained HTML page that opens without a network.
#pragma once
#include <string>
#include <vector>

#include "reports/model/answer.h"
#include "reports/model/score_doc.h"
#include "store/store.h"

namespace crowdbench::reports {

struct PageOptions {
  std::string source;            // the result file's name, for the footer
  std::vector<ScoreDoc> scores;  // what is known of scores, in the order in which they are shown
  FloorTexts floors = {};        // what the floors of representations are
  // The same of the scores of switches; the one that sorts them first.
  std::vector<ScoreDoc> pop_scores = {};
};
// The page's bytes, UTF-8. Everything is inside: data, pictures (PNG as data URIs), the chart library. The page's own
// content security policy forbids it to load anything. contents: read with pictures. Throws Error when the program was
// built without the chart library, or when the file holds nothing that a page tells of: measurements, curves, single
// agents, causes, switches or tuned rules. Contents of several files (store/joined.h) are set side by side.
std::string report_page(const StoreContents& contents, const PageOptions& options = {});

}  // namespace crowdbench::reports
