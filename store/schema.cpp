#include "store/schema.h"

#include <fmt/format.h>

#include <algorithm>

#include "core/error.h"
#include "store/database.h"
#include "store/store.h"

namespace crowdbench::store {
namespace {

const char* sql_type(ColumnType type) {
  switch (type) {
    case ColumnType::boolean:
    case ColumnType::integer: return "INTEGER";
    case ColumnType::real: return "REAL";
    case ColumnType::seed:
    case ColumnType::text: return "TEXT";
    case ColumnType::bytes: return "BLOB";
  }
  return "BLOB";
}

std::string column_sql(const Column& column) {
  if (column.key) return identifier(column.name) + " INTEGER PRIMARY KEY";
  std::string sql = fmt::format("{} {}", identifier(column.name), sql_type(column.type));
  if (!column.optional) sql += " NOT NULL";
  if (!column.references.empty()) sql += fmt::format(" REFERENCES {} (id)", column.references);
  if (!column.values.empty())
    sql += fmt::format(" CHECK ({} IN ('{}'))", identifier(column.name), fmt::join(column.values, "', '"));
  if (!column.check.empty()) sql += fmt::format(" CHECK ({})", column.check);
  return sql;
}

// name: the table's own, or another that it is made under at first.
std::string table_sql(const TableDescription& table, const std::string& name) {
  std::vector<std::string> lines;
  if (!table.owner.empty()) lines.push_back(fmt::format("{0} INTEGER NOT NULL REFERENCES {0} (id)", table.owner));
  for (const Column& column : table.columns) lines.push_back(column_sql(column));
  if (!table.owner.empty()) lines.push_back(fmt::format("PRIMARY KEY ({}, {})", table.owner, table.within));
  return fmt::format("CREATE TABLE {} ({}){};\n", name, fmt::join(lines, ", "),
                     table.owner.empty() ? "" : " WITHOUT ROWID");
}

std::string index_sql(const TableDescription& table) {
  if (table.index.empty()) return {};
  return fmt::format("CREATE INDEX {0}_key ON {0} ({1});\n", table.name, fmt::join(table.index, ", "));
}

std::string view_sql() {
  std::string columns;
  for (const Column& column : table<RunRow>().description.columns)
    if (!column.key && !column.bulky) columns += ", run." + identifier(column.name);
  return fmt::format(
      "CREATE VIEW results AS SELECT measurement.*{} FROM measurement JOIN run ON run.id = measurement.run;\n",
      columns);
}

bool changed_since(const TableDescription& table, int schema) {
  return std::any_of(table.columns.begin(), table.columns.end(),
                     [&](const Column& column) { return std::max(column.since, column.changed) > schema; });
}

std::string names(const TableDescription& table) {
  std::string list = table.owner;
  for (const Column& column : table.columns) list += (list.empty() ? "" : ", ") + identifier(column.name);
  return list;
}

}  // namespace

std::string create_sql() {
  std::string sql;
  for_each_table([&](const auto& table) {
    sql += table_sql(table.description, table.description.name) + index_sql(table.description);
  });
  return sql + view_sql();
}

bool has_table(const TableDescription& table, int schema) { return table.since <= schema; }

std::string selected(const TableDescription& table, int schema) {
  std::string list = table.owner;
  for (const Column& column : table.columns) {
    if (!list.empty()) list += ", ";
    if (std::max(column.since, column.changed) > schema)
      list += column.before.empty() ? "NULL" : column.before;
    else
      list += identifier(column.name);
  }
  return list;
}

std::string insert_sql(const TableDescription& table) {
  const size_t count = table.columns.size() + (table.owner.empty() ? 0 : 1);
  return fmt::format("INSERT INTO {} ({}) VALUES ({})", table.name, names(table),
                     fmt::join(std::vector<const char*>(count, "?"), ", "));
}

void migrate(sqlite3* database, const std::string& where, int from) {
  execute(database, where, "DROP VIEW results");
  for_each_table([&](const auto& each) {
    const TableDescription& table = each.description;
    if (!has_table(table, from)) {
      execute(database, where, table_sql(table, table.name) + index_sql(table));
    } else if (changed_since(table, from)) {
      // Renaming the new table, not the old, leaves what references the table untouched.
      const std::string made = table.name + "_made";
      execute(
          database, where,
          table_sql(table, made) +
              fmt::format("INSERT INTO {0} ({1}) SELECT {2} FROM {3}; DROP TABLE {3}; ALTER TABLE {0} RENAME TO {3};\n",
                          made, names(table), selected(table, from), table.name) +
              index_sql(table));
    }
  });
  execute(database, where, view_sql() + fmt::format("PRAGMA user_version={}", kStoreSchemaVersion));
  if (Statement(database, where, "PRAGMA foreign_key_check").step())
    throw Error(where, "a row belongs to another that is not there",
                "the file is damaged; measure again into a new one");
}

}  // namespace crowdbench::store
