// What `stability` prints and writes.
#pragma once
#include <string>
#include <vector>

#include "bench/stability/stability.h"
#include "core/json.h"
#include "store/rows.h"

namespace crowdbench::bench {

struct StabilityReport {
  std::string renderer;
  bool small = false;
  std::vector<StabilityRow> rows;
};
size_t failed(const StabilityReport& report);

// {"renderer", "small", "failed": count,
//  "cases": [{"case", "representation": null where it is asked of none, "measured": null where infinite or nothing was
//             measured, "bound", "unit", "pass", "group", "asked", "bound_from", "bound_seen": the bound was set after
//             seeing, "place", "values": {"expected", "got"}, "note", "error", "seconds"}]}
Json stability_json(const StabilityReport& report);
// The same as rows of the result store, of the run with this id.
std::vector<StabilityCaseRow> stability_rows(const StabilityReport& report, int64_t run);
// A line a row, those that fail with all that is known of them, and how many fail.
std::string stability_text(const StabilityReport& report);
// A table of what holds: a line a case with the worst of the representations, which is named.
std::string stability_markdown(const StabilityReport& report);
// One self-contained page (reports/page/stability_page.h). Throws Error.
std::string stability_page_of(const StabilityReport& report);
// Every case with what is asked, its unit and where its bound comes from.
std::string stability_list(const std::vector<StabilityCase>& cases);

}  // namespace crowdbench::bench
