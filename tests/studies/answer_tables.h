// Answers of a table that stands in the test.
#pragma once
#include <string>

#include "studies/analysis/answers.h"

namespace crowdbench::studies::test {

// columns: empty: those that have the names of roles.
inline Answers answers_of(const std::string& text, const std::string& columns = "") {
  const Table table = parse_table(text, "t.csv");
  Answers out;
  add_answers(out, table, columns.empty() ? columns_by_name(table) : parse_column_map(columns, "--columns"));
  return out;
}

}  // namespace crowdbench::studies::test
