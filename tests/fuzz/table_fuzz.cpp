// Whatever the bytes, a table of answers is rows of as many fields as there are columns, or one Error.
#include <cstdint>
#include <cstdlib>
#include <string_view>

#include "studies/analysis/table.h"
#include "tests/fuzz/fuzz_check.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace crowdbench;
  studies::Table table;
  if (!fuzz::answers([&] { table = studies::parse_table({reinterpret_cast<const char*>(data), size}, "fuzz"); }))
    return 0;
  if (table.rows.empty() || table.columns.empty()) std::abort();
  for (const studies::Table::Row& row : table.rows)
    if (row.fields.size() != table.columns.size()) std::abort();
  return 0;
}
