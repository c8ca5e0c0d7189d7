// The documentation of a result file: every table and column, from their one description (store/columns.h).
#pragma once
#include <string>

namespace crowdbench::reports {

// One section a table, one line a column: name, type, unit, whether it may be absent, since which schema, meaning.
std::string results_schema_markdown();

// {"schema_version": N, "tables": [{"name", "rows", "meaning", "since", "owner", "columns": [{"name", "type", "unit",
// "optional", "since", "meaning", "values", "references"}]}]}; null where there is none.
std::string results_schema_json();

}  // namespace crowdbench::reports
