#include "reports/exports/exports.h"

#include <gtest/gtest.h>

#include <map>
#include <nlohmann/json.hpp>
#include <sstream>

#include "core/error.h"
#include "reports/exports/bencher.h"
#include "reports/exports/frame_log.h"
#include "reports/exports/markdown_cell.h"
#include "tests/reports/rows.h"
#include "tests/store/full_rows.h"

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

// Rows with a value of its own in every field, and what each export calls it: a column that is left out, or holds
// another's value, shows here.
StoreContents full_contents() {
  StoreContents all;
  all.runs = {full_run()};
  all.runs[0].id = 3;
  all.measurements = {full_measurement(3)};
  all.measurements[0].id = 4;
  all.ratios = {full_ratio(3)};
  all.ratios[0].id = 5;
  all.controls = {full_control(3)};
  all.controls[0].id = 9;
  all.comparisons = {full_comparison(3)};
  all.comparisons[0].id = 6;
  all.sweeps = {full_sweep()};
  all.sweeps[0].id = 9;
  all.sweep_points = {full_sweep_point(9, 3, 4, 6)};
  all.sweep_points[0].id = 10;
  all.pictures = {full_picture(3, 6)};
  all.curves = {full_curve(3)};
  all.curves[0].id = 7;
  all.thresholds = {full_threshold(3, 7)};
  all.thresholds[0].id = 8;
  all.cause_ranges = {full_cause_range(3)};
  all.cause_ranges[0].id = 11;
  all.pops = {full_pop(3)};
  all.pops[0].id = 12;
  all.tunings = {full_tuning(3)};
  all.tunings[0].id = 15;
  all.stability_cases = {full_stability_case(3)};
  all.stability_cases[0].id = 16;
  all.participants = {full_participant()};
  all.participants[0].id = 13;
  all.answers = {full_answer(13)};
  all.answers[0].id = 14;
  return all;
}

const char* const kFullRun = R"({"id": 3, "command": "bench", "arguments": "crowdbench bench --agents 1,10",
  "started": "2026-01-02T03:04:05Z", "version": "0.1.0", "revision": "abc123", "scenario_name": "a </script> name",
  "scenario": "seed = 7\nname = \"it's\"\n", "scenario_hash": "00ff", "seed": 18446744073709551615,
  "order_seed": 18446744073709551614, "gl_vendor": "Mesa", "gl_renderer": "llvmpipe", "gl_version": "4.5",
  "software": true, "headline": "wall", "cpu_model": "A CPU", "cpu_mhz": 2599.5, "cpu_scaling_enabled": false,
  "cpu_threads": 2, "os": "Linux 6", "timer_cost_ns": 250.5})";
const char* const kFullMeasurement = R"({"id": 4, "run": 3, "representation": "flat:views=64",
  "character": "mannequin + robot.glb", "agents": 250, "width_px": 640, "height_px": 480, "requested_occupancy": 0.15,
  "status": "invalid", "reason": "nothing moved", "reference": "mesh", "achieved_occupancy": 0.1512,
  "covered_px": 46000, "reference_px": 46100, "moved_px": 900, "touched_px": 50000, "agents_wholly": 240,
  "agents_partly": 8, "agents_off": 3, "triangles_per_agent": 7, "rounds": 24, "warmup_frames": 4, "settled": true,
  "frame_ns": 1.5, "frame_ns_low": 2.5, "frame_ns_high": 3.5, "frame_ns_p05": 4.5, "frame_ns_p95": 5.5,
  "frame_ns_p99": 6.5, "cpu_ns": 11.5, "cpu_ns_low": 12.5, "cpu_ns_high": 13.5, "cpu_ns_p05": 14.5,
  "cpu_ns_p95": 15.5, "cpu_ns_p99": 16.5, "main_cpu_ns": 21.5, "main_cpu_ns_low": 22.5, "main_cpu_ns_high": 23.5,
  "main_cpu_ns_p05": 24.5, "main_cpu_ns_p95": 25.5, "main_cpu_ns_p99": 26.5, "gpu_ns": 31.5, "gpu_ns_low": 32.5,
  "gpu_ns_high": 33.5, "gpu_ns_p05": 34.5, "gpu_ns_p95": 35.5, "gpu_ns_p99": 36.5, "low_1_percent_fps": 333.25,
  "vertices_shaded": 1001, "primitives": 1002, "fragments": 1003, "samples_passed": 1004,
  "texture_bytes": 5368709120, "buffer_bytes": 2001, "upload_bytes_per_frame": 2002, "disk_bytes": 2003,
  "shared_bytes": 2004, "bake_seconds": 1.25, "bake_load_seconds": 0.75, "bake_cached": false})";

// Columns in this order, which spreadsheets and scripts of others have come to know.
TEST(Exports, JsonHasEveryColumnUnderItsName) {
  const auto all = nlohmann::ordered_json::parse(results_json(full_contents()));
  ASSERT_EQ(all.size(), 15U) << all;
  const auto wanted = [](const char* text) { return nlohmann::ordered_json::parse(text); };
  EXPECT_EQ(all.at("runs").at(0).dump(), wanted(kFullRun).dump());
  auto measurement = all.at("measurements").at(0);
  EXPECT_EQ(measurement.at("samples").dump(), wanted(R"([
    {"round": 5, "tick": 6, "frame_ns": 1000000, "cpu_ns": 3000000, "main_cpu_ns": 2000000, "gpu_ns": 77},
    {"round": 7, "tick": 8, "frame_ns": 1000001, "cpu_ns": 3000001, "main_cpu_ns": 2000001, "gpu_ns": 0}])")
                                                  .dump());
  measurement.erase("samples");
  EXPECT_EQ(measurement.dump(), wanted(kFullMeasurement).dump());
  EXPECT_EQ(all.at("ratios").dump(), wanted(R"([{"id": 5, "run": 3, "kind": "floor", "representation": "flat",
    "character": "mannequin", "agents": 250, "width_px": 640, "height_px": 480, "requested_occupancy": 0.15,
    "to": "mesh", "metric": "cpu", "ratio": 12.5, "ratio_low": 11.5, "ratio_high": 13.5, "pairs": 20}])")
                                         .dump());
  EXPECT_EQ(all.at("controls").dump(), wanted(R"([{"id": 9, "run": 3, "representation": "mesh",
    "character": "mannequin", "agents": 251, "width_px": 641, "height_px": 481, "requested_occupancy": 0.16,
    "metric": "wall", "ratio": 1.25, "ratio_low": 0.75, "ratio_high": 1.75, "p": 0.5, "detectable": 0.03125,
    "pairs": 21}])")
                                           .dump());
  EXPECT_EQ(all.at("curves").dump(), wanted(R"([{"id": 7, "run": 3, "representation": "flat", "reference": "mesh",
    "character": "mannequin", "score": "flip", "against": "height_px", "points": 401, "agents": 201,
    "rank_correlation": -0.25, "display": "standard_fhd: ...", "display_given": true, "bins": [
    {"bin": 0, "x_from": 1.5, "x_to": 2.5, "x": 3.5, "median": 4.5, "median_low": 5.5, "median_high": "inf",
     "points": 200, "agents": 101},
    {"bin": 1, "x_from": 11.5, "x_to": 12.5, "x": 13.5, "median": 14.5, "median_low": 15.5, "median_high": 16.5,
     "points": 202, "agents": 100}]}])")
                                         .dump());
  EXPECT_EQ(all.at("thresholds").dump(), wanted(R"([{"id": 8, "run": 3, "curve": 7, "value": 0.125,
    "status": "reached", "x": 20.5, "x_low": 18.5, "x_high": 22.5}])")
                                             .dump());
  EXPECT_EQ(all.at("sweeps").dump(), wanted(R"([{"id": 9, "plan_name": "textures", "plan_hash": "0123456789abcdef",
    "plan": "[axes]\nseed = [1]\n", "conditions": 31, "repetitions": 3, "points": 60129542144, "shard": 5,
    "shards": 8, "revision": "abc123", "gl_renderer": "llvmpipe", "gl_version": "4.5"}])")
                                         .dump());
  EXPECT_EQ(all.at("sweep_points").dump(), wanted(R"([{"id": 10, "sweep": 9, "run": 3, "condition": 12, "repetition": 2,
    "role": "point", "point_key": "fedcba9876543210", "representation": "flat:texels=64",
    "settings": "{\"seed\":\"1\"}", "state": "invalid", "reason": "nothing moved", "measurement": 4, "comparison": 6,
    "ratio": 1.25, "ratio_low": 1.125, "ratio_high": 1.5, "condition_s": 2.75}])")
                                               .dump());
  EXPECT_EQ(all.at("cause_ranges").dump(), wanted(R"([{"id": 11, "run": 3, "representation": "flat",
    "reference": "mesh", "character": "mannequin", "unit": "agent", "from_px": 15.0, "below_px": 60.0, "units": 21,
    "total": 123456789, "residue": 0.0625, "dominant": "view", "share_low": 0.375, "share_high": 0.5,
    "words": "below 60 pixels: the stored view", "shares": [
    {"cause": "silhouette", "title": "the silhouette", "share": -0.25},
    {"cause": "view", "title": "the stored view", "share": 0.4375}]}])")
                                               .dump());
  EXPECT_EQ(all.at("pops").dump(), wanted(R"json([{"id": 12, "run": 3, "representation": "hybrid(mesh,flat)",
    "character": "mannequin", "from": "mesh", "to": "flat", "agent": 12, "tick": 31, "frames": 4, "complete": false,
    "distance_m": 20.5, "pixels_px": 321, "worst_tick": 33, "display": "standard_fhd: ...", "pop_scores": [
    {"name": "pop_flip", "value": 0.125}, {"name": "pop_luma", "value": null}]}])json")
                                       .dump());
  EXPECT_EQ(all.at("tunings").dump(), wanted(R"json([{"id": 15, "run": 3, "character": "mannequin + fox.glb",
    "score": "ssim", "threshold": 0.875, "pop_score": "psnr", "pop_threshold": 31.5, "budget_ns": 8000000.0,
    "representation": "hybrid(mesh,flat,height=24)", "reason": "a made-up one", "agents": 321.5,
    "reference_over_plan": 3.5, "reference_over_plan_low": 3.25, "reference_over_plan_high": 3.75, "promised": 2.5,
    "promised_low": 2.25, "promised_high": 2.75, "lenses_hold": true, "proof_holds": false,
    "display": "standard_fhd: ...", "display_given": true, "tuned_switches": [
    {"place": 0, "from": "mesh", "to": "flat", "height_px": 24.5, "height_low_px": 20.5, "height_high_px": 28.5,
     "share": 0.9375, "decided": false, "depth_m": 12.25, "pixels_per_texel": 0.5, "pixels_per_error": 1.5,
     "hysteresis": 0.125, "pop": 0.75},
    {"place": 1, "from": "flat", "to": "relief", "height_px": 12.5, "height_low_px": null, "height_high_px": null,
     "share": 0.0, "decided": true, "depth_m": 30.25, "pixels_per_texel": null, "pixels_per_error": null,
     "hysteresis": 0.0, "pop": null}]}])json")
                                          .dump());
  EXPECT_EQ(all.at("stability_cases").dump(),
            wanted(R"json([{"id": 16, "run": 3, "name": "world_1e7", "case_group": "world",
    "representation": "flat:views=hemi-4", "measured": 0.25, "bound": 0.5, "unit": "grey levels", "pass": true,
    "bound_seen": true, "small": true, "place": "pixel (1, 2)", "expected": "(3, 4, 5)", "got": "(6, 7, 8)",
    "note": "one of four", "error": "a made-up one"}])json")
                .dump());
  EXPECT_EQ(all.at("participants").dump(),
            wanted(R"json([{"id": 13, "study": "0a1b", "participant": "2c3d", "list": "4",
    "state": "finished", "token": "4e5f", "started": "2026-01-02T03:04:05Z", "ended": "2026-01-02T03:34:05Z",
    "pixels_per_degree": 36.5, "pixels_per_degree_se": 3.25,
    "begun": "{\"t001\":2}"}])json")
                .dump());
  EXPECT_EQ(all.at("answers").dump(), wanted(R"json([{"id": 14, "participant": 13, "item": "t012", "kind": "catch",
    "stimulus": "s003", "block": 2, "answer": "cannot-tell", "rt_ms": 812.5, "replays": 1, "frames_dropped": 3,
    "hidden": 4, "restarts": 5, "received": "2026-01-02T03:05:05Z", "data": "{\"item\":\"t012\"}"}])json")
                                          .dump());
  EXPECT_EQ(all.at("comparisons").dump(), wanted(R"([{"id": 6, "run": 3, "kind": "agent", "representation": "flat",
    "reference": "mesh", "character": "mannequin", "agents": 9, "requested_occupancy": 0.25, "tick": 11,
    "height_px": 64.5, "azimuth_deg": 45.5, "elevation_deg": 15.5, "clip": "walk", "time_s": 0.75,
    "agent": 12, "distance_m": 23.5, "pixels_per_texel": 0.5, "alone_px": 1300, "visible_px": 1200,
    "state": "counted", "display": "standard_fhd: ...", "display_given": true,
    "scores": {"psnr": "inf", "ssim": null}, "reasons": {"ssim": "smaller than 11 pixels"}}])")
                                              .dump());
}

TEST(Exports, CsvHasTheColumnsOfMeasurementAndRun) {
  const std::string csv = results_csv(full_contents());
  size_t at = 0;
  const auto names = record(csv, at);
  const auto values = record(csv, at);
  EXPECT_EQ(at, csv.size());
  std::vector<std::string> wanted_names;
  std::vector<std::string> wanted_values;
  for (const char* text : {kFullMeasurement, kFullRun}) {
    const auto row = nlohmann::ordered_json::parse(text);
    for (const auto& [name, value] : row.items()) {
      if (text == kFullRun && (name == "id" || name == "scenario")) continue;
      wanted_names.push_back(name);
      wanted_values.push_back(value.is_string() ? value.get<std::string>() : value.dump());
    }
  }
  EXPECT_EQ(names, wanted_names);
  EXPECT_EQ(values, wanted_values);
}

TEST(Exports, CsvOfScoresIsOneRecordAScore) {
  const std::string csv = scores_csv(full_contents());
  size_t at = 0;
  const auto names = record(csv, at);
  const auto infinite = record(csv, at);
  const auto absent = record(csv, at);
  EXPECT_EQ(at, csv.size());
  ASSERT_EQ(infinite.size(), names.size());
  ASSERT_EQ(absent.size(), names.size());
  std::map<std::string, std::pair<std::string, std::string>> values;
  for (size_t i = 0; i < names.size(); ++i) values[names[i]] = {infinite[i], absent[i]};
  EXPECT_EQ(values.size(), names.size());
  const auto both = [](const std::string& text) { return std::pair(text, text); };
  EXPECT_EQ(values.at("id"), both("6"));
  EXPECT_EQ(values.at("representation"), both("flat"));
  EXPECT_EQ(values.at("height_px"), both("64.5"));
  EXPECT_EQ(values.at("name"), std::pair(std::string("psnr"), std::string("ssim")));
  EXPECT_EQ(values.at("value"), std::pair(std::string("inf"), std::string()));
  EXPECT_EQ(values.at("reason"), std::pair(std::string(), std::string("smaller than 11 pixels")));
  EXPECT_EQ(values.at("cpu_model"), both("A CPU"));
  EXPECT_FALSE(values.contains("scenario"));
}

TEST(Exports, JsonKeepsAbsenceAndInfinity) {
  const json all = json::parse(results_json(made_up_contents()));
  EXPECT_EQ(all.at("runs").at(0).at("gl_renderer"), "made-up rasteriser");
  EXPECT_TRUE(all.at("measurements").at(0).at("gpu_ns").is_null());
  EXPECT_EQ(all.at("measurements").at(0).at("samples").size(), 3U);
  EXPECT_EQ(all.at("comparisons").back().at("scores").at("psnr"), "inf");
  EXPECT_TRUE(all.at("comparisons").at(0).at("scores").at("psnr").is_null());
  EXPECT_EQ(all.at("comparisons").at(0).at("reasons").at("psnr"), "made up");
  const json described = json::parse(results_json(made_up_contents(), made_up_scores())).at("scores");
  ASSERT_EQ(described.size(), made_up_scores().size());
  EXPECT_EQ(described.at(3), json::parse(R"({"name": "psnr", "title": "PSNR", "unit": "dB", "better": "higher",
                                             "equal": "inf", "computes": "signal to noise"})"));
}

TEST(Exports, GoogleBenchmarkEntries) {
  const json all = json::parse(google_benchmark_json(made_up_contents()));
  EXPECT_EQ(all.at("context").at("num_cpus"), 2);
  // The made-up machine did not say how fast it is: nothing is invented.
  EXPECT_FALSE(all.at("context").contains("mhz_per_cpu"));
  EXPECT_FALSE(all.at("context").contains("cpu_scaling_enabled"));
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

TEST(Exports, GoogleBenchmarkSaysWhatTheMachineSaid) {
  StoreContents contents = full_contents();
  const json all = json::parse(google_benchmark_json(contents));
  EXPECT_EQ(all.at("context").at("mhz_per_cpu"), 2600);
  EXPECT_EQ(all.at("context").at("cpu_scaling_enabled"), false);
  EXPECT_EQ(all.at("context").at("crowdbench_order_seed"), 18446744073709551614U);
  EXPECT_FALSE(all.at("context").contains("crowdbench_scenario"));
  // Counters: whatever is a number and may be absent, but for times.
  const json& entry = all.at("benchmarks").at(0);
  EXPECT_EQ(entry.at("touched_px"), 50000);
  EXPECT_EQ(entry.at("shared_bytes"), 2004);
  EXPECT_EQ(entry.at("low_1_percent_fps"), 333.25);
  EXPECT_FALSE(entry.contains("frame_ns"));
  EXPECT_FALSE(entry.contains("rounds"));
  contents.runs[0].cpu_scaling_enabled = true;
  EXPECT_EQ(json::parse(google_benchmark_json(contents)).at("context").at("cpu_scaling_enabled"), true);
}

TEST(Exports, MarkdownHasTheTablesAndEscapesThem) {
  StoreContents contents = made_up_contents();
  contents.runs[0].scenario_name = "a | b <i>";
  const std::string text = report_markdown(contents, "x.sqlite");
  EXPECT_NE(text.find("a \\| b &lt;i>"), std::string::npos);
  EXPECT_NE(text.find("| flat | 1,000 | 15 % | 2.00 ms |"), std::string::npos) << text;
  EXPECT_NE(text.find("stopped: at 250 agents"), std::string::npos);
  EXPECT_NE(text.find("software rasteriser"), std::string::npos);
  // Every score, every column of the largest crowds and of the run.
  EXPECT_NE(text.find("| representation | agents | occupancy | mae | psnr | ssim |"), std::string::npos) << text;
  EXPECT_NE(text.find("| flat | 100 | 15 % | 1.2500 | ∞ | 0.9500 |"), std::string::npos) << text;
  EXPECT_NE(text.find("| flat | 64 | 3 | 0.5000 (0.5000) | 0.8850 (0.8400) | 0.8350 (0.7900) |"), std::string::npos)
      << text;
  EXPECT_NE(text.find("| texture_bytes | 5.3 MiB | 170.7 MiB |"), std::string::npos) << text;
  EXPECT_EQ(text.find("| reason |"), std::string::npos) << text;  // nothing to say of either
  EXPECT_NE(text.find("| settled | yes | yes |"), std::string::npos) << text;
  EXPECT_NE(text.find("| cpu_threads | 2 threads |"), std::string::npos) << text;
  EXPECT_NE(text.find("| cpu_mhz | – |"), std::string::npos) << text;
  EXPECT_THROW(report_markdown({}, "x.sqlite"), Error);
  const std::string described = report_markdown(contents, "x.sqlite", made_up_scores());
  EXPECT_NE(described.find("| representation | height, px | views | Silhouette IoU | SSIM | SSIM in the figure |"),
            std::string::npos)
      << described;
  EXPECT_NE(described.find("| flat | 64 | 3 | 0.885 (0.840) | 0.835 (0.790) |"), std::string::npos) << described;
  EXPECT_NE(described.find("| flat | 100 | 15 % | 0.950 | ∞ | 1.25 |"), std::string::npos) << described;
}

TEST(Exports, BencherHasTimesWithTheirIntervalsRatiosAndScores) {
  const json all = json::parse(bencher_json(made_up_contents()));
  EXPECT_EQ(all.size(), 17U) << "every point that was timed";
  const json& point = all.at("crowd/representation:flat/character:mannequin/agents:100/occupancy:0.15/640x480");
  EXPECT_EQ(point.at("cpu-time").at("value"), 1.1e6);
  EXPECT_LT(point.at("cpu-time").at("lower_value"), point.at("cpu-time").at("value"));
  const double speed = 1e7 / 1.1e6;
  EXPECT_NEAR(point.at("times-as-slow-as-reference-cpu").at("value").get<double>(), 1 / speed, 1e-12);
  EXPECT_NEAR(point.at("times-as-slow-as-reference-cpu").at("upper_value").get<double>(), 1 / (0.97 * speed), 1e-12);
  EXPECT_EQ(point.at("score-ssim").at("value"), 0.95);
  EXPECT_FALSE(point.contains("score-psnr")) << "an infinite value is none there";
  EXPECT_FALSE(point.contains("gpu-time"));
}

TEST(Exports, TheFrameLogHasALineAFrame) {
  StoreContents all = full_contents();
  const std::string csv = frame_log_csv(all);
  EXPECT_EQ(csv.substr(0, csv.find("\r\n")),
            "Application,MsBetweenPresents,MsCPUBusy,MsGPUTime,Run,Round,Tick,MsProcessCPU,Agents,OccupiedPx");
  EXPECT_NE(csv.find("\"crowd/representation:flat:views=64/character:mannequin + robot.glb/agents:250/occupancy:0.15/"
                     "640x480\",1.000000,2.000000,0.000077,3,5,6,3.000000,250,46000\r\n"),
            std::string::npos)
      << csv;
  all.measurements[0].samples[0].gpu_ns = std::nullopt;
  EXPECT_NE(frame_log_csv(all).find(",2.000000,,3,5,6,"), std::string::npos) << "not available is empty";
}

TEST(MarkdownCell, StaysOnItsLineAndInItsCell) {
  EXPECT_EQ(markdown_cell(""), "");
  EXPECT_EQ(markdown_cell("flat"), "flat");
  EXPECT_EQ(markdown_cell("a|b\r\nc"), "a\\|b  c");
  EXPECT_EQ(markdown_cell("<b> & |"), "&lt;b> & \\|");
}

}  // namespace
}  // namespace crowdbench::reports
