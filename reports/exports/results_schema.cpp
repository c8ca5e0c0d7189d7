#include "reports/exports/results_schema.h"

#include <fmt/format.h>

#include "core/json.h"
#include "store/columns.h"
#include "store/store.h"

namespace crowdbench::reports {
namespace {

// The columns as SQL has them: those of rows that belong to another begin with its id.
std::vector<Column> documented(const TableDescription& description) {
  std::vector<Column> columns = description.columns;
  if (!description.owner.empty()) {
    Column owner{.name = description.owner,
                 .meaning = fmt::format("the {} that it belongs to", description.owner),
                 .references = description.owner,
                 .since = description.since};
    owner.type = ColumnType::integer;
    columns.insert(columns.begin(), owner);
  }
  return columns;
}

Json text_or_null(const std::string& text) { return text.empty() ? Json(nullptr) : Json(text); }

}  // namespace

std::string results_schema_markdown() {
  std::string out = fmt::format(
      "# Columns of a result file\n\nSQLite, schema {}. What was not available is NULL (null in JSON, empty in CSV), "
      "never 0. The view `results` has one row a measurement, what is known of its run included.\n",
      kStoreSchemaVersion);
  for_each_table([&](const auto& table) {
    const TableDescription& description = table.description;
    out += fmt::format(
        "\n## `{}`\n\n{}\n\n| column | type | unit | may be absent | since | meaning |\n|---|---|---|---|--:|---|\n",
        description.name, description.meaning);
    for (const Column& column : documented(description)) {
      const std::string values =
          column.values.empty() ? "" : fmt::format(" (one of `{}`)", fmt::join(column.values, "`, `"));
      out += fmt::format("| `{}` | {} | {} | {} | {} | {}{} |\n", column.name, type_name(column.type), column.unit,
                         column.optional ? "yes" : "no", column.since, column.meaning, values);
    }
  });
  return out;
}

std::string results_schema_json() {
  Json tables = Json::array();
  for_each_table([&](const auto& table) {
    const TableDescription& description = table.description;
    Json columns = Json::array();
    for (const Column& column : documented(description))
      columns.push_back({{"name", column.name},
                         {"type", type_name(column.type)},
                         {"unit", text_or_null(column.unit)},
                         {"optional", column.optional},
                         {"since", column.since},
                         {"meaning", column.meaning},
                         {"values", column.values.empty() ? Json(nullptr) : Json(column.values)},
                         {"references", text_or_null(column.references)}});
    tables.push_back({{"name", description.name},
                      {"rows", description.rows},
                      {"meaning", description.meaning},
                      {"since", description.since},
                      {"owner", text_or_null(description.owner)},
                      {"columns", std::move(columns)}});
  });
  const Json all = {{"schema_version", kStoreSchemaVersion}, {"tables", std::move(tables)}};
  return all.dump(2) + "\n";
}

}  // namespace crowdbench::reports
