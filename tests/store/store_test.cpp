#include "store/store.h"

#include <gtest/gtest.h>
#include <sqlite3.h>
#include <sys/resource.h>
#include <unistd.h>

#include <csignal>
#include <fstream>
#include <map>

#include "core/error.h"
#include "tests/store/full_rows.h"

namespace crowdbench {
namespace {

class StoreTest : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = std::filesystem::temp_directory_path() / ("crowdbench_store_" + std::to_string(::getpid()) + "_" +
                                                        testing::UnitTest::GetInstance()->current_test_info()->name());
    std::filesystem::create_directories(folder_);
    file_ = folder_ / "results.sqlite";
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  // The message of the Error that `body` throws; empty when it throws none.
  template <typename Body>
  static std::string error_of(const Body& body) {
    try {
      body();
    } catch (const Error& error) {
      return error.what();
    }
    return {};
  }
  void sql(const std::filesystem::path& path, const std::string& text) {
    sqlite3* database = nullptr;
    ASSERT_EQ(sqlite3_open(path.c_str(), &database), SQLITE_OK);
    ASSERT_EQ(sqlite3_exec(database, text.c_str(), nullptr, nullptr, nullptr), SQLITE_OK) << sqlite3_errmsg(database);
    sqlite3_close(database);
  }

  // Every column of the first row of FROM ("run WHERE id = 3") as an SQL literal. By name: an order is no meaning.
  using Record = std::map<std::string, std::string>;
  static Record record(const std::filesystem::path& path, const std::string& from) {
    Record all;
    sqlite3* database = nullptr;
    EXPECT_EQ(sqlite3_open_v2(path.c_str(), &database, SQLITE_OPEN_READONLY, nullptr), SQLITE_OK);
    for (const auto& name :
         column(database, "SELECT name FROM pragma_table_info('" + from.substr(0, from.find(' ')) + "')"))
      for (const auto& value : column(database, "SELECT quote(\"" + name + "\") FROM " + from + " LIMIT 1"))
        all[name] = value;
    sqlite3_close(database);
    return all;
  }
  // The first column of what a query gives.
  static std::vector<std::string> column(sqlite3* database, const std::string& query) {
    std::vector<std::string> all;
    sqlite3_stmt* statement = nullptr;
    EXPECT_EQ(sqlite3_prepare_v2(database, query.c_str(), -1, &statement, nullptr), SQLITE_OK)
        << sqlite3_errmsg(database);
    while (sqlite3_step(statement) == SQLITE_ROW) {
      const auto* text = reinterpret_cast<const char*>(sqlite3_column_text(statement, 0));
      all.emplace_back(text != nullptr ? text : "");
    }
    sqlite3_finalize(statement);
    return all;
  }
  static std::string bytes(const std::filesystem::path& path) {
    std::ifstream in(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
  }
  size_t files() const {
    const std::filesystem::directory_iterator all(folder_);
    return static_cast<size_t>(std::distance(begin(all), end(all)));
  }

  std::filesystem::path folder_;
  std::filesystem::path file_;
};

RunRow a_run() { return full_run(); }

MeasurementRow a_measurement(int64_t run) {
  MeasurementRow row;
  row.run = run;
  row.key = {"flat:views=64", "mannequin", 250, 640, 480, 0.15};
  row.reference = "mesh";
  row.frame_ns = TimeSummary{2.0e6, 1.0e6, 3.0e6, 1.1e6, 2.9e6, 2.98e6};
  row.fragments = 0;  // zero is a value, not an absence
  row.samples = {
      {0, 0, 1000000, 3000000, 1, std::nullopt}, {1, 1, 2000000, 4000000, 2, 77}, {2, 2, 3000000, 5000000, 3, 0}};
  return row;
}

// The file itself, by the names of its columns: what was written under a wrong name, and would be read back from there,
// shows here.
TEST_F(StoreTest, EveryFieldIsInTheColumnOfItsName) {
  {
    StoreWriter store(file_);
    store.write(a_run());  // so that ids differ from table to table
    store.write(a_run());
    const int64_t run = store.write(full_run());
    store.write(a_measurement(run));
    store.write(full_measurement(run));
    for (int i = 0; i < 4; ++i) store.write(full_ratio(run));
    for (int i = 0; i < 8; ++i) store.write(full_control(run));
    for (int i = 0; i < 5; ++i) store.write(full_comparison(run));
    for (int i = 0; i < 6; ++i) store.write(full_picture(run, 5));
    for (int i = 0; i < 7; ++i) store.write(full_curve(run));
    for (int i = 0; i < 8; ++i) store.write(full_threshold(run, 7));
  }
  EXPECT_EQ(record(file_, "run WHERE id = 3"), (Record{{"id", "3"},
                                                       {"command", "'bench'"},
                                                       {"arguments", "'crowdbench bench --agents 1,10'"},
                                                       {"started", "'2026-01-02T03:04:05Z'"},
                                                       {"version", "'0.1.0'"},
                                                       {"revision", "'abc123'"},
                                                       {"scenario_name", "'a </script> name'"},
                                                       {"scenario", "'seed = 7\nname = \"it''s\"\n'"},
                                                       {"scenario_hash", "'00ff'"},
                                                       {"seed", "'18446744073709551615'"},
                                                       {"order_seed", "'18446744073709551614'"},
                                                       {"gl_vendor", "'Mesa'"},
                                                       {"gl_renderer", "'llvmpipe'"},
                                                       {"gl_version", "'4.5'"},
                                                       {"software", "1"},
                                                       {"headline", "'wall'"},
                                                       {"cpu_model", "'A CPU'"},
                                                       {"cpu_mhz", "2599.5"},
                                                       {"cpu_scaling_enabled", "0"},
                                                       {"cpu_threads", "2"},
                                                       {"os", "'Linux 6'"},
                                                       {"timer_cost_ns", "250.5"}}));
  EXPECT_EQ(record(file_, "measurement WHERE id = 2"), (Record{{"id", "2"},
                                                               {"run", "3"},
                                                               {"representation", "'flat:views=64'"},
                                                               {"character", "'mannequin + robot.glb'"},
                                                               {"agents", "250"},
                                                               {"width_px", "640"},
                                                               {"height_px", "480"},
                                                               {"requested_occupancy", "0.15"},
                                                               {"status", "'invalid'"},
                                                               {"reason", "'nothing moved'"},
                                                               {"reference", "'mesh'"},
                                                               {"achieved_occupancy", "0.1512"},
                                                               {"covered_px", "46000"},
                                                               {"reference_px", "46100"},
                                                               {"moved_px", "900"},
                                                               {"touched_px", "50000"},
                                                               {"agents_wholly", "240"},
                                                               {"agents_partly", "8"},
                                                               {"agents_off", "3"},
                                                               {"triangles_per_agent", "7"},
                                                               {"rounds", "24"},
                                                               {"warmup_frames", "4"},
                                                               {"settled", "1"},
                                                               {"frame_ns", "1.5"},
                                                               {"frame_ns_low", "2.5"},
                                                               {"frame_ns_high", "3.5"},
                                                               {"frame_ns_p05", "4.5"},
                                                               {"frame_ns_p95", "5.5"},
                                                               {"frame_ns_p99", "6.5"},
                                                               {"cpu_ns", "11.5"},
                                                               {"cpu_ns_low", "12.5"},
                                                               {"cpu_ns_high", "13.5"},
                                                               {"cpu_ns_p05", "14.5"},
                                                               {"cpu_ns_p95", "15.5"},
                                                               {"cpu_ns_p99", "16.5"},
                                                               {"main_cpu_ns", "21.5"},
                                                               {"main_cpu_ns_low", "22.5"},
                                                               {"main_cpu_ns_high", "23.5"},
                                                               {"main_cpu_ns_p05", "24.5"},
                                                               {"main_cpu_ns_p95", "25.5"},
                                                               {"main_cpu_ns_p99", "26.5"},
                                                               {"gpu_ns", "31.5"},
                                                               {"gpu_ns_low", "32.5"},
                                                               {"gpu_ns_high", "33.5"},
                                                               {"gpu_ns_p05", "34.5"},
                                                               {"gpu_ns_p95", "35.5"},
                                                               {"gpu_ns_p99", "36.5"},
                                                               {"low_1_percent_fps", "333.25"},
                                                               {"vertices_shaded", "1001"},
                                                               {"primitives", "1002"},
                                                               {"fragments", "1003"},
                                                               {"samples_passed", "1004"},
                                                               {"texture_bytes", "5368709120"},
                                                               {"buffer_bytes", "2001"},
                                                               {"upload_bytes_per_frame", "2002"},
                                                               {"disk_bytes", "2003"},
                                                               {"shared_bytes", "2004"},
                                                               {"bake_seconds", "1.25"},
                                                               {"bake_load_seconds", "0.75"},
                                                               {"bake_cached", "0"}}));
  EXPECT_EQ(record(file_, "sample WHERE measurement = 2 AND round = 5"), (Record{{"measurement", "2"},
                                                                                 {"round", "5"},
                                                                                 {"tick", "6"},
                                                                                 {"frame_ns", "1000000"},
                                                                                 {"cpu_ns", "3000000"},
                                                                                 {"main_cpu_ns", "2000000"},
                                                                                 {"gpu_ns", "77"}}));
  EXPECT_EQ(record(file_, "ratio WHERE id = 4"), (Record{{"id", "4"},
                                                         {"run", "3"},
                                                         {"kind", "'floor'"},
                                                         {"representation", "'flat'"},
                                                         {"character", "'mannequin'"},
                                                         {"agents", "250"},
                                                         {"width_px", "640"},
                                                         {"height_px", "480"},
                                                         {"requested_occupancy", "0.15"},
                                                         {"to", "'mesh'"},
                                                         {"metric", "'cpu'"},
                                                         {"ratio", "12.5"},
                                                         {"ratio_low", "11.5"},
                                                         {"ratio_high", "13.5"},
                                                         {"pairs", "20"}}));
  EXPECT_EQ(record(file_, "control WHERE id = 8"), (Record{{"id", "8"},
                                                           {"run", "3"},
                                                           {"representation", "'mesh'"},
                                                           {"character", "'mannequin'"},
                                                           {"agents", "251"},
                                                           {"width_px", "641"},
                                                           {"height_px", "481"},
                                                           {"requested_occupancy", "0.16"},
                                                           {"metric", "'wall'"},
                                                           {"ratio", "1.25"},
                                                           {"ratio_low", "0.75"},
                                                           {"ratio_high", "1.75"},
                                                           {"p", "0.5"},
                                                           {"detectable", "0.03125"},
                                                           {"pairs", "21"}}));
  EXPECT_EQ(record(file_, "comparison WHERE id = 5"), (Record{{"id", "5"},
                                                              {"run", "3"},
                                                              {"kind", "'agent'"},
                                                              {"representation", "'flat'"},
                                                              {"reference", "'mesh'"},
                                                              {"character", "'mannequin'"},
                                                              {"agents", "9"},
                                                              {"requested_occupancy", "0.25"},
                                                              {"tick", "11"},
                                                              {"height_px", "64.5"},
                                                              {"azimuth_deg", "45.5"},
                                                              {"elevation_deg", "15.5"},
                                                              {"clip", "'walk'"},
                                                              {"time_s", "0.75"},
                                                              {"agent", "12"},
                                                              {"distance_m", "23.5"},
                                                              {"pixels_per_texel", "0.5"},
                                                              {"alone_px", "1300"},
                                                              {"visible_px", "1200"},
                                                              {"state", "'counted'"},
                                                              {"display", "'standard_fhd: ...'"},
                                                              {"display_given", "1"}}));
  EXPECT_EQ(record(file_, "curve WHERE id = 7"), (Record{{"id", "7"},
                                                         {"run", "3"},
                                                         {"representation", "'flat'"},
                                                         {"reference", "'mesh'"},
                                                         {"character", "'mannequin'"},
                                                         {"score", "'flip'"},
                                                         {"against", "'height_px'"},
                                                         {"points", "401"},
                                                         {"agents", "201"},
                                                         {"rank_correlation", "-0.25"},
                                                         {"display", "'standard_fhd: ...'"},
                                                         {"display_given", "1"}}));
  EXPECT_EQ(record(file_, "curve_bin WHERE curve = 7 AND bin = 1"), (Record{{"curve", "7"},
                                                                            {"bin", "1"},
                                                                            {"x_from", "11.5"},
                                                                            {"x_to", "12.5"},
                                                                            {"x", "13.5"},
                                                                            {"median", "14.5"},
                                                                            {"median_low", "15.5"},
                                                                            {"median_high", "16.5"},
                                                                            {"points", "202"},
                                                                            {"agents", "100"}}));
  EXPECT_EQ(record(file_, "threshold WHERE id = 8"), (Record{{"id", "8"},
                                                             {"run", "3"},
                                                             {"curve", "7"},
                                                             {"value", "0.125"},
                                                             {"status", "'reached'"},
                                                             {"x", "20.5"},
                                                             {"x_low", "18.5"},
                                                             {"x_high", "22.5"}}));
  EXPECT_EQ(
      record(file_, "score WHERE comparison = 5 AND name = 'ssim'"),
      (Record{{"comparison", "5"}, {"name", "'ssim'"}, {"value", "NULL"}, {"reason", "'smaller than 11 pixels'"}}));
  EXPECT_EQ(record(file_, "score WHERE comparison = 5 AND name = 'psnr' AND value > 1e308")["reason"], "''");
  EXPECT_EQ(record(file_, "picture WHERE id = 6"), (Record{{"id", "6"},
                                                           {"run", "3"},
                                                           {"comparison", "5"},
                                                           {"role", "'difference'"},
                                                           {"caption", "'a caption'"},
                                                           {"width_px", "12"},
                                                           {"height_px", "13"},
                                                           {"png", "X'000102FF'"}}));
}

TEST_F(StoreTest, BooleansAreToldApart) {
  {
    StoreWriter store(file_);
    const int64_t run = store.write(full_run());
    for (int i = 0; i < 3; ++i) {
      StabilityCaseRow row = full_stability_case(run);
      row.pass = i == 0;
      row.bound_seen = i == 1;
      row.small = i == 2;
      store.write(row);
      TuningRow tuning;
      tuning.run = run;
      tuning.lenses_hold = i == 0;
      tuning.proof_holds = i == 1;
      tuning.display_given = i == 2;
      store.write(tuning);
    }
  }
  const std::map<std::string, std::vector<std::string>> tables = {
      {"stability_case", {"pass", "bound_seen", "small"}}, {"tuning", {"lenses_hold", "proof_holds", "display_given"}}};
  for (const auto& [table, names] : tables)
    for (size_t i = 0; i < names.size(); ++i) {
      const Record row = record(file_, table + " WHERE id = " + std::to_string(i + 1));
      for (const std::string& name : names)
        EXPECT_EQ(row.at(name), name == names[i] ? "1" : "0") << table << ", " << name << " of row " << i;
    }
}

TEST_F(StoreTest, EveryFieldComesBack) {
  StoreContents wanted;
  {
    StoreWriter store(file_);
    store.write(a_run());
    wanted.runs = {a_run(), full_run()};
    wanted.runs[0].id = 1;
    wanted.runs[1].id = store.write(full_run());
    const int64_t run = wanted.runs[1].id;
    wanted.measurements = {full_measurement(run), MeasurementRow()};
    wanted.measurements[1].run = run;  // and nothing else: absent stays absent
    for (MeasurementRow& row : wanted.measurements) row.id = store.write(row);
    wanted.ratios = {full_ratio(run)};
    wanted.ratios[0].id = store.write(wanted.ratios[0]);
    wanted.controls = {full_control(run)};
    wanted.controls[0].id = store.write(wanted.controls[0]);
    wanted.comparisons = {full_comparison(run), ComparisonRow()};
    wanted.comparisons[1].run = run;
    wanted.comparisons[1].kind = "crowd";
    for (ComparisonRow& row : wanted.comparisons) row.id = store.write(row);
    wanted.sweeps = {full_sweep()};
    wanted.sweeps[0].id = store.write(full_sweep());
    wanted.sweep_points = {full_sweep_point(1, run, 2, 1), SweepPointRow()};
    wanted.sweep_points[1].sweep = 1;
    wanted.sweep_points[1].run = run;
    wanted.sweep_points[1].role = "aa";
    wanted.sweep_points[1].state = "done";
    for (SweepPointRow& row : wanted.sweep_points) row.id = store.write(row);
    wanted.pictures = {full_picture(run, 2), full_picture(run, 1)};
    wanted.pictures[1].comparison = std::nullopt;
    for (PictureRow& row : wanted.pictures) row.id = store.write(row);
    wanted.curves = {full_curve(run), CurveRow()};
    wanted.curves[1].run = run;
    wanted.curves[1].against = "distance_m";
    for (CurveRow& row : wanted.curves) row.id = store.write(row);
    wanted.thresholds = {full_threshold(run, 1), {0, run, 2, 0, "everywhere", {}, {}, {}}};
    for (ThresholdRow& row : wanted.thresholds) row.id = store.write(row);
    wanted.cause_ranges = {full_cause_range(run), CauseRangeRow()};
    wanted.cause_ranges[1].run = run;
    wanted.cause_ranges[1].unit = "view";
    for (CauseRangeRow& row : wanted.cause_ranges) row.id = store.write(row);
    wanted.pops = {full_pop(run), PopRow()};
    wanted.pops[1].run = run;
    for (PopRow& row : wanted.pops) row.id = store.write(row);
    wanted.tunings = {full_tuning(run), TuningRow()};
    wanted.tunings[1].run = run;
    for (TuningRow& row : wanted.tunings) row.id = store.write(row);
    wanted.stability_cases = {full_stability_case(run), StabilityCaseRow()};
    wanted.stability_cases[1].run = run;
    for (StabilityCaseRow& row : wanted.stability_cases) row.id = store.write(row);
    wanted.participants = {full_participant(), full_participant()};
    wanted.participants[1].participant = "";
    wanted.participants[1].state = "withdrawn";
    wanted.participants[1].pixels_per_degree = std::nullopt;
    for (StudyParticipantRow& row : wanted.participants) row.id = store.write(row);
    wanted.answers = {full_answer(1), StudyAnswerRow()};
    wanted.answers[1].participant = 1;
    wanted.answers[1].kind = "page";
    for (StudyAnswerRow& row : wanted.answers) row.id = store.write(row);
    RunRow unknown = full_run();
    unknown.order_seed = std::nullopt;
    unknown.cpu_model = std::nullopt;
    unknown.cpu_mhz = std::nullopt;
    unknown.cpu_scaling_enabled = std::nullopt;
    unknown.id = store.write(unknown);
    wanted.runs.push_back(unknown);
  }
  const StoreContents all = read_store(file_, true);
  EXPECT_TRUE(all.runs == wanted.runs);
  EXPECT_TRUE(all.measurements == wanted.measurements);
  EXPECT_TRUE(all.ratios == wanted.ratios);
  EXPECT_TRUE(all.controls == wanted.controls);
  EXPECT_TRUE(all.comparisons == wanted.comparisons);
  EXPECT_TRUE(all.sweeps == wanted.sweeps);
  EXPECT_TRUE(all.sweep_points == wanted.sweep_points);
  EXPECT_TRUE(all.pictures == wanted.pictures);
  EXPECT_TRUE(all.curves == wanted.curves);
  EXPECT_TRUE(all.thresholds == wanted.thresholds);
  EXPECT_TRUE(all.cause_ranges == wanted.cause_ranges);
  EXPECT_TRUE(all.pops == wanted.pops);
  EXPECT_TRUE(all.tunings == wanted.tunings);
  EXPECT_TRUE(all.stability_cases == wanted.stability_cases);
  EXPECT_TRUE(all.participants == wanted.participants);
  EXPECT_TRUE(all.answers == wanted.answers);
}

TEST_F(StoreTest, SamplesAndPicturesAreReadOnlyWhenAskedFor) {
  StoreWriter store(file_);
  const int64_t run = store.write(a_run());
  store.write(a_measurement(run));
  store.write(PictureRow{0, run, std::nullopt, "hero", "", 1, 1, {1}});
  EXPECT_TRUE(read_store(file_).measurements.at(0).samples.empty());
  EXPECT_EQ(read_store(file_).pictures.size(), 1U);
  EXPECT_TRUE(read_store(file_, false, false).pictures.empty());
}

TEST_F(StoreTest, ContinuesAFileAndFindsTheLatestRowOfAKey) {
  const RunRow run = a_run();
  {
    StoreWriter store(file_);
    const int64_t id = store.write(run);
    MeasurementRow row = a_measurement(id);
    store.write(row);
    row.status = Status::stopped;
    row.reason = "over the budget";
    row.key.agents = 1000;
    store.write(row);
  }
  StoreWriter store(file_);
  const PointKey key = a_measurement(1).key;
  ASSERT_TRUE(store.find(run, key).has_value());
  EXPECT_EQ(store.find(run, key)->frame_ns->median, 2.0e6);
  PointKey other = key;
  other.agents = 1000;
  EXPECT_EQ(store.find(run, other)->status, Status::stopped);
  EXPECT_EQ(store.find(run, other)->reason, "over the budget");
  other.agents = 10;
  EXPECT_FALSE(store.find(run, other).has_value());
  RunRow another = run;
  another.scenario_hash = "11";
  EXPECT_FALSE(store.find(another, key).has_value());
  another = run;
  another.gl_renderer = "a GPU";
  EXPECT_FALSE(store.find(another, key).has_value());
  another = run;
  another.revision = "def";
  EXPECT_FALSE(store.find(another, key).has_value());
  const int64_t second = store.write(run);
  MeasurementRow again = a_measurement(second);
  again.frame_ns->median = 9.0;
  store.write(again);
  EXPECT_EQ(store.find(run, key)->frame_ns->median, 9.0);
}

TEST_F(StoreTest, WhatWasNotCommittedIsTakenBack) {
  {
    StoreWriter store(file_);
    const int64_t run = store.write(a_run());
    store.begin();
    store.write(a_measurement(run));
    store.commit();
    store.begin();
    store.write(a_measurement(run));
    store.write(a_measurement(run));
  }
  EXPECT_EQ(read_store(file_).measurements.size(), 1U);
}

TEST_F(StoreTest, ARowThatBreaksTheSchemaChangesNothing) {
  StoreWriter store(file_);
  const int64_t run = store.write(a_run());
  MeasurementRow row = a_measurement(run);
  row.samples.push_back(row.samples[0]);  // the same round twice
  EXPECT_THROW(store.write(row), Error);
  EXPECT_TRUE(read_store(file_, true).measurements.empty());
  row = a_measurement(run + 5);  // a run that does not exist
  EXPECT_THROW(store.write(row), Error);
  row = a_measurement(run);
  row.status = Status::invalid;  // without a reason
  EXPECT_THROW(store.write(row), Error);
  store.write(a_measurement(run));
  EXPECT_EQ(read_store(file_).measurements.size(), 1U);
}

TEST_F(StoreTest, ReadersSeeFinishedPointsWhileASweepGoesOn) {
  StoreWriter store(file_);
  const int64_t run = store.write(a_run());
  store.begin();
  store.write(a_measurement(run));
  EXPECT_TRUE(read_store(file_).measurements.empty());
  store.commit();
  EXPECT_EQ(read_store(file_).measurements.size(), 1U);
}

TEST_F(StoreTest, RefusesWhatIsNotOurs) {
  std::ofstream(file_) << "this is plain text, long enough to be looked at as a header of a file\n";
  EXPECT_NE(error_of([&] { read_store(file_); }).find("not a SQLite file"), std::string::npos);
  EXPECT_NE(error_of([&] { StoreWriter store(file_); }).find("not a SQLite file"), std::string::npos);

  const auto foreign = folder_ / "foreign.sqlite";
  sql(foreign, "CREATE TABLE t (a); INSERT INTO t VALUES (1)");
  const std::string before = bytes(foreign);
  EXPECT_NE(error_of([&] { read_store(foreign); }).find("another program"), std::string::npos);
  EXPECT_NE(error_of([&] { StoreWriter store(foreign); }).find("another program"), std::string::npos);
  EXPECT_EQ(bytes(foreign), before);

  EXPECT_NE(error_of([&] { read_store(folder_ / "none.sqlite"); }).find("no such file"), std::string::npos);
  EXPECT_FALSE(std::filesystem::exists(folder_ / "none.sqlite"));
  EXPECT_NE(error_of([&] { read_store(folder_); }).find("folder"), std::string::npos);
  EXPECT_NE(error_of([&] { StoreWriter store(folder_); }).find("is a directory"), std::string::npos);
}

TEST_F(StoreTest, RefusesASchemaThatItDoesNotKnow) {
  { StoreWriter store(file_); }
  sql(file_, "PRAGMA user_version=99");
  const std::string before = bytes(file_);
  const std::string reading = error_of([&] { read_store(file_); });
  EXPECT_NE(reading.find("newer"), std::string::npos) << reading;
  EXPECT_NE(reading.find("99"), std::string::npos) << reading;
  EXPECT_NE(reading.find("update crowdbench"), std::string::npos) << reading;
  EXPECT_EQ(error_of([&] { StoreWriter store(file_); }), reading);
  EXPECT_EQ(bytes(file_), before);
  sql(file_, "PRAGMA user_version=0");
  const std::string none = error_of([&] { read_store(file_); });
  EXPECT_NE(none.find("schema 0"), std::string::npos) << none;
  EXPECT_EQ(error_of([&] { StoreWriter store(file_); }), none);
}

TEST_F(StoreTest, RefusesADamagedFile) {
  {
    StoreWriter store(file_);
    const int64_t run = store.write(a_run());
    for (int i = 0; i < 50; ++i) store.write(a_measurement(run));
  }
  const auto size = std::filesystem::file_size(file_);
  ASSERT_GT(size, 16384U);
  {
    std::fstream out(file_, std::ios::binary | std::ios::in | std::ios::out);
    out.seekp(4096);
    out << std::string(static_cast<size_t>(size) - 4096, '\x5a');
  }
  EXPECT_NE(error_of([&] { read_store(file_, true); }), "");
}

// SQLite keeps any text in a column of numbers, and gives 0 for it.
TEST_F(StoreTest, RefusesATextThatStandsForANumber) {
  {
    StoreWriter store(file_);
    store.write(a_run());
  }
  for (const char* text : {"nan", "inf", "fast"}) {
    sql(file_, std::string("UPDATE run SET timer_cost_ns = '") + text + "'");
    const std::string message = error_of([&] { read_store(file_); });
    EXPECT_NE(message.find(std::string("'") + text + "' in column timer_cost_ns is not a number"), std::string::npos)
        << message;
  }
  sql(file_, "UPDATE run SET timer_cost_ns = 1e400");
  EXPECT_EQ(read_store(file_).runs.at(0).timer_cost_ns, std::numeric_limits<double>::infinity());
}

TEST_F(StoreTest, SaysThatAnotherWriterHoldsTheFile) {
  StoreWriter first(file_);
  first.begin();
  const std::string message = error_of([&] { StoreWriter second(file_); });
  EXPECT_NE(message.find("another program is writing"), std::string::npos) << message;
}

TEST_F(StoreTest, SaysThatTheDiskIsFullAndKeepsWhatWasThere) {
  StoreWriter store(file_);
  const int64_t run = store.write(a_run());
  store.write(a_measurement(run));
  // SQLite's own limit stands in for a full disk: the same result code on the same path.
  PictureRow huge{0, run, std::nullopt, "hero", "", 1, 1, std::vector<uint8_t>(8 << 20)};
  store.limit_pages(64);
  const std::string message = error_of([&] { store.write(huge); });
  EXPECT_NE(message.find("disk is full"), std::string::npos) << message;
  EXPECT_EQ(read_store(file_).measurements.size(), 1U);
  EXPECT_TRUE(read_store(file_).pictures.empty());
}

// SQLite writes a page of its own before the first table: a disk that is full then leaves a file that is nobody's.
TEST_F(StoreTest, AFileThatWasOnlyBegunIsBegunAgain) {
  rlimit old{};
  ASSERT_EQ(getrlimit(RLIMIT_FSIZE, &old), 0);
  const auto handler = std::signal(SIGXFSZ, SIG_IGN);  // the write fails, as on a full disk
  const rlimit small{4096, old.rlim_max};
  ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &small), 0);
  const std::string message = error_of([&] { StoreWriter store(file_); });
  ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &old), 0);
  std::signal(SIGXFSZ, handler);
  EXPECT_NE(message, "");
  ASSERT_GT(std::filesystem::file_size(file_), 0U);
  EXPECT_NE(error_of([&] { read_store(file_); }).find("holds nothing"), std::string::npos);
  {
    StoreWriter store(file_);
    store.write(a_measurement(store.write(a_run())));
  }
  EXPECT_EQ(read_store(file_).measurements.size(), 1U);
}

TEST_F(StoreTest, ReadsFromAFolderThatCannotBeWritten) {
  {
    StoreWriter store(file_);
    store.write(a_measurement(store.write(a_run())));
  }
  std::filesystem::permissions(file_, std::filesystem::perms::owner_read);
  std::filesystem::permissions(folder_, std::filesystem::perms::owner_read | std::filesystem::perms::owner_exec);
  EXPECT_EQ(read_store(file_).measurements.size(), 1U);
  if (::geteuid() != 0) {  // root may write anywhere
    EXPECT_NE(error_of([&] { StoreWriter store(file_); }).find("cannot be written"), std::string::npos);
  }
  std::filesystem::permissions(folder_, std::filesystem::perms::owner_all);
}

TEST_F(StoreTest, ReadingLeavesNothingBeside) {
  {
    StoreWriter store(file_);
    store.write(a_measurement(store.write(a_run())));
  }
  EXPECT_EQ(read_store(file_).measurements.size(), 1U);
  EXPECT_EQ(files(), 1U);
}

TEST_F(StoreTest, TheViewIsOneRowAMeasurementWithProvenance) {
  {
    StoreWriter store(file_);
    store.write(a_measurement(store.write(a_run())));
  }
  sqlite3* database = nullptr;
  ASSERT_EQ(sqlite3_open(file_.c_str(), &database), SQLITE_OK);
  sqlite3_stmt* statement = nullptr;
  ASSERT_EQ(sqlite3_prepare_v2(database,
                               "SELECT revision, gl_renderer, scenario_hash, seed, cpu_model, frame_ns, gpu_ns IS NULL "
                               "FROM results",
                               -1, &statement, nullptr),
            SQLITE_OK);
  ASSERT_EQ(sqlite3_step(statement), SQLITE_ROW);
  EXPECT_STREQ(reinterpret_cast<const char*>(sqlite3_column_text(statement, 0)), "abc123");
  EXPECT_STREQ(reinterpret_cast<const char*>(sqlite3_column_text(statement, 3)), "18446744073709551615");
  EXPECT_EQ(sqlite3_column_double(statement, 5), 2.0e6);
  EXPECT_EQ(sqlite3_column_int(statement, 6), 1);
  EXPECT_EQ(sqlite3_step(statement), SQLITE_DONE);
  sqlite3_finalize(statement);
  sqlite3_close(database);
}

TEST(StatusNames, RoundTrip) {
  for (const Status status : {Status::valid, Status::invalid, Status::unreachable, Status::skipped, Status::stopped})
    EXPECT_EQ(status_of(status_name(status)), status);
  EXPECT_THROW(status_of("fine"), Error);
}

}  // namespace
}  // namespace crowdbench
