// The section of the report that tells of the rules that `tune` found.
#pragma once
#include <vector>

#include "reports/model/score_doc.h"
#include "reports/page/html_template.h"
#include "store/rows.h"

namespace crowdbench::reports {

// Empty where the contents have none.
Html tuning_section(const StoreContents& contents, const std::vector<ScoreDoc>& scores);

}  // namespace crowdbench::reports
