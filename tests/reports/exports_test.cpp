#include "reports/exports/exports.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <sstream>

#include "core/error.h"
#include "tests/reports/rows.h"

namespace crowdbench::reports {
namespace {

using nlohmann::json;

// Fields of one record of RFC 4180; `at` moves behind its end.
std::vector<std::string> record(const std::string& csv, size_t& at) {
  std::vector<std::string> fields(1);
  bool quoted = false;
  for (; at < csv.size(); ++at) {
    const char c = csv[at];
    if (quoted && c == '"' && at + 1 < csv.size() && csv[at + 1] == '"') {
      fields.back() += '"';
      ++at;
    } else if (c == '"') {
      quoted = !quoted;
    } else if (!quoted && c == ',') {
      fields.emplace_back();
    } else if (!quoted && c == '\r') {
      at += 2;
      return fields;
    } else {
      fields.back() += c;
    }
  }
  return fields;
}

TEST(Exports, CsvHasOneRecordAMeasurement) {
  const StoreContents contents = made_up_contents();
  const std::string csv = results_csv(contents);
  size_t at = 0;
  const auto header = record(csv, at);
  const auto column = [&](const char* name) {
    return static_cast<size_t>(std::find(header.begin(), header.end(), name) - header.begin());
  };
  ASSERT_LT(column("cpu_ns"), header.size());
  ASSERT_LT(column("gpu_ns"), header.size());
  ASSERT_LT(column("cpu_model"), header.size());
  size_t rows = 0;
  while (at < csv.size()) {
    const auto fields = record(csv, at);
    ASSERT_EQ(fields.size(), header.size());
    const MeasurementRow& row = contents.measurements[rows++];
    EXPECT_EQ(fields[column("representation")], row.key.representation);
    EXPECT_EQ(fields[column("cpu_model")], "A CPU @ \"3\" GHz");
    EXPECT_EQ(fields[column("gpu_ns")], "");
    EXPECT_EQ(fields[column("reason")], row.reason);
    if (row.cpu_ns) {
      EXPECT_EQ(std::stod(fields[column("cpu_ns")]), row.cpu_ns->median);
    } else {
      EXPECT_EQ(fields[column("cpu_ns")], "");
    }
  }
  EXPECT_EQ(rows, contents.measurements.size());
}

TEST(Exports, JsonKeepsAbsenceAndInfinity) {
  const json all = json::parse(results_json(made_up_contents()));
  EXPECT_EQ(all.at("runs").at(0).at("gl_renderer"), "made-up rasteriser");
  EXPECT_TRUE(all.at("measurements").at(0).at("gpu_ns").is_null());
  EXPECT_EQ(all.at("measurements").at(0).at("samples").size(), 3U);
  EXPECT_EQ(all.at("comparisons").back().at("scores").at("psnr"), "inf");
  EXPECT_TRUE(all.at("comparisons").at(0).at("scores").at("psnr").is_null());
  EXPECT_EQ(all.at("comparisons").at(0).at("reasons").at("psnr"), "made up");
}

TEST(Exports, GoogleBenchmarkEntries) {
  const json all = json::parse(google_benchmark_json(made_up_contents()));
  EXPECT_EQ(all.at("context").at("num_cpus"), 2);
  EXPECT_EQ(all.at("context").at("crowdbench_gl_renderer"), "made-up rasteriser");
  size_t iterations = 0;
  size_t errors = 0;
  std::map<std::string, json> aggregates;
  for (const json& entry : all.at("benchmarks")) {
    EXPECT_EQ(entry.at("time_unit"), "ns");
    if (entry.value("error_occurred", false)) {
      ++errors;
      const auto message = entry.at("error_message").get<std::string>();
      EXPECT_TRUE(message.starts_with("stopped: at 250") || message.starts_with("unreachable: 1 agents")) << message;
    } else if (entry.at("run_type") == "iteration") {
      ++iterations;
    }
    if (entry.at("run_name") == "crowd/representation:mesh/character:mannequin/agents:1/occupancy:0.15/640x480" &&
        entry.at("run_type") == "aggregate")
      aggregates[entry.at("aggregate_name")] = entry;
  }
  EXPECT_EQ(errors, 3U);
  EXPECT_EQ(iterations, 17U * 3);
  // Wall times 60000, 61000, 62000 ns; CPU 100000, 102000, 104000.
  EXPECT_DOUBLE_EQ(aggregates.at("median").at("real_time").get<double>(), 61000);
  EXPECT_DOUBLE_EQ(aggregates.at("median").at("cpu_time").get<double>(), 102000);
  EXPECT_NEAR(aggregates.at("mean").at("real_time").get<double>(), 61000, 1e-6);
  EXPECT_NEAR(aggregates.at("stddev").at("real_time").get<double>(), 1000, 1e-6);
  EXPECT_NEAR(aggregates.at("p95").at("real_time").get<double>(), 61900, 1e-6);
  EXPECT_EQ(aggregates.at("median").at("covered_px"), 46080);
}

TEST(Exports, MarkdownHasTheTablesAndEscapesThem) {
  StoreContents contents = made_up_contents();
  contents.runs[0].scenario_name = "a | b <i>";
  const std::string text = report_markdown(contents, "x.sqlite");
  EXPECT_NE(text.find("a \\| b &lt;i>"), std::string::npos);
  EXPECT_NE(text.find("| flat | 1,000 | 15 % | 2.00 ms |"), std::string::npos) << text;
  EXPECT_NE(text.find("stopped: at 250 agents"), std::string::npos);
  EXPECT_NE(text.find("software rasteriser"), std::string::npos);
  EXPECT_THROW(report_markdown({}, "x.sqlite"), Error);
}

}  // namespace
}  // namespace crowdbench::reports
