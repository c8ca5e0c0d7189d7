#include "store/joined.h"

#include <algorithm>
#include <iterator>
#include <utility>

#include "store/columns.h"

namespace crowdbench {
namespace {

// The greatest id of any table.
int64_t most_id(const StoreContents& contents) {
  int64_t most = 0;
  for_each_table([&]<typename Row>(const Table<Row>& table) {
    if (table.rows != nullptr)
      for (const Field<Row>& field : table.fields)
        if (field.column.key)
          for (const Row& row : contents.*table.rows) most = std::max(most, std::get<int64_t>(field.get(row)));
  });
  return most;
}

void move_ids(StoreContents& contents, int64_t by) {
  for_each_table([&]<typename Row>(const Table<Row>& table) {
    if (table.rows != nullptr)
      for (const Field<Row>& field : table.fields)
        if (field.column.key || !field.column.references.empty())
          for (Row& row : contents.*table.rows)
            if (const Value id = field.get(row); std::holds_alternative<int64_t>(id))
              field.set(row, std::get<int64_t>(id) + by);
  });
}

}  // namespace

StoreContents joined(std::vector<NamedContents> files) {
  if (files.size() == 1) return std::move(files.front().contents);
  StoreContents out;
  for (NamedContents& file : files) {
    move_ids(file.contents, most_id(out));
    for (const RunRow& run : file.contents.runs) out.sources[run.id] = file.name;
    for_each_table([&]<typename Row>(const Table<Row>& table) {
      if (table.rows == nullptr) return;
      auto& from = file.contents.*table.rows;
      auto& to = out.*table.rows;
      to.insert(to.end(), std::make_move_iterator(from.begin()), std::make_move_iterator(from.end()));
    });
  }
  return out;
}

}  // namespace crowdbench
