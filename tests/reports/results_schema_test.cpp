#include "reports/exports/results_schema.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <set>

#include "store/store.h"

namespace crowdbench::reports {
namespace {

using nlohmann::json;

TEST(ResultsSchema, JsonDescribesTablesAndColumns) {
  const json all = json::parse(results_schema_json());
  EXPECT_EQ(all.at("schema_version"), kStoreSchemaVersion);
  std::map<std::string, json> columns;
  std::set<std::string> tables;
  for (const json& table : all.at("tables")) {
    const auto name = table.at("name").get<std::string>();
    tables.insert(name);
    for (const json& column : table.at("columns"))
      EXPECT_TRUE(columns.emplace(name + "." + column.at("name").get<std::string>(), column).second);
  }
  EXPECT_EQ(
      tables,
      (std::set<std::string>{
          "run",         "measurement", "sample",      "ratio",  "control",      "comparison",     "score",
          "picture",     "sweep",       "sweep_point", "curve",  "curve_bin",    "threshold",      "cause_range",
          "cause_share", "pop",         "pop_score",   "tuning", "tuned_switch", "stability_case", "study_participant",
          "study_answer"}));
  EXPECT_EQ(columns.at("run.cpu_mhz").at("unit"), "MHz");
  EXPECT_EQ(columns.at("run.cpu_mhz").at("optional"), true);
  EXPECT_EQ(columns.at("run.cpu_mhz").at("since"), 2);
  EXPECT_EQ(columns.at("run.seed").at("type"), "64 bits");
  EXPECT_EQ(columns.at("run.seed").at("optional"), false);
  EXPECT_TRUE(columns.at("run.seed").at("unit").is_null());
  EXPECT_EQ(columns.at("measurement.frame_ns_p95").at("type"), "real");
  EXPECT_EQ(columns.at("measurement.status").at("values"),
            json({"valid", "invalid", "unreachable", "skipped", "stopped"}));
  EXPECT_EQ(columns.at("sample.measurement").at("references"), "measurement");
  EXPECT_EQ(columns.at("score.value").at("optional"), true);
}

TEST(ResultsSchema, MarkdownHasTheSameColumns) {
  const std::string text = results_schema_markdown();
  const json schema = json::parse(results_schema_json());
  for (const json& table : schema.at("tables")) {
    EXPECT_NE(text.find("\n## `" + table.at("name").get<std::string>() + "`\n"), std::string::npos);
    for (const json& column : table.at("columns"))
      EXPECT_NE(text.find("\n| `" + column.at("name").get<std::string>() + "` | " +
                          column.at("type").get<std::string>() + " |"),
                std::string::npos)
          << column;
  }
  EXPECT_NE(text.find("| `cpu_mhz` | real | MHz | yes | 2 | highest clock"), std::string::npos) << text;
}

}  // namespace
}  // namespace crowdbench::reports
