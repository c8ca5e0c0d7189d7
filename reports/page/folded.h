// Tables of many rows are folded: a page with all of them in sight would take long to open.
#pragma once
#include <vector>

#include "reports/model/number_text.h"
#include "reports/model/shown.h"
#include "reports/page/html_template.h"

namespace crowdbench::reports {

// What a template's `folded` is given: nothing where a table of so many rows stays open.
inline std::vector<TemplateValues> folded_rows(size_t rows) {
  if (rows <= kMostRowsOpen) return {};
  return {{{"count", count_text(rows)}}};
}

}  // namespace crowdbench::reports
