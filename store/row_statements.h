// Rows through prepared statements: their columns in the order in which schema.h names them.
#pragma once
#include "store/columns.h"
#include "store/database.h"

namespace crowdbench::store {

// The row of a statement that selects all columns of its table (selected() of schema.h) and has stepped to a row.
template <typename Row>
Row read_row(Statement& statement) {
  Row row;
  for (const Field<Row>& field : table<Row>().fields) field.set(row, statement.read(field.column.type));
  return row;
}

// For a statement that inserts all columns (insert_sql() of schema.h); the row's id is left to SQLite.
template <typename Row>
void bind_row(Statement& statement, const Row& row) {
  for (const Field<Row>& field : table<Row>().fields)
    statement.bind(field.column.type, field.column.key ? Value() : field.get(row));
}

}  // namespace crowdbench::store
