#include "store/store.h"

#include <gtest/gtest.h>
#include <sqlite3.h>
#include <unistd.h>

#include <cmath>
#include <fstream>
#include <limits>

#include "core/error.h"

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

  std::filesystem::path folder_;
  std::filesystem::path file_;
};

RunRow a_run() {
  RunRow run;
  run.command = "bench";
  run.arguments = "bench --agents 1,10";
  run.started = "2026-01-02T03:04:05Z";
  run.version = "0.1.0";
  run.revision = "abc123";
  run.scenario_name = "a </script> name";
  run.scenario = "seed = 7\n";
  run.scenario_hash = "00ff";
  run.seed = std::numeric_limits<uint64_t>::max();
  run.gl_vendor = "Mesa";
  run.gl_renderer = "llvmpipe";
  run.gl_version = "4.5";
  run.software = true;
  run.headline = "cpu";
  run.cpu_model = "A CPU";
  run.cpu_threads = 2;
  run.os = "Linux 6";
  run.timer_cost_ns = 250.5;
  return run;
}

MeasurementRow a_measurement(int64_t run) {
  MeasurementRow row;
  row.run = run;
  row.key = {"flat:views=64", "mannequin", 250, 640, 480, 0.15};
  row.reference = "mesh";
  row.achieved_occupancy = 0.1512;
  row.covered_px = 46000;
  row.reference_px = 46100;
  row.moved_px = 900;
  row.agents_wholly = 240;
  row.agents_partly = 8;
  row.agents_off = 2;
  row.triangles_per_agent = 2;
  row.rounds = 3;
  row.warmup_frames = 4;
  row.settled = true;
  row.frame_ns = TimeSummary{2.0e6, 1.0e6, 3.0e6, 1.1e6, 2.9e6, 2.98e6};
  row.cpu_ns = TimeSummary{4.0e6, 3.0e6, 5.0e6, 3.1e6, 4.9e6, 4.98e6};
  row.main_cpu_ns = TimeSummary{1, 2, 3, 4, 5, 6};
  row.low_1_percent_fps = 333.25;
  row.vertices_shaded = 1000;
  row.fragments = 0;  // zero is a value, not an absence
  row.texture_bytes = uint64_t{5} << 30;
  row.buffer_bytes = 12;
  row.bake_seconds = 1.5;
  row.bake_cached = false;
  row.samples = {
      {0, 0, 1000000, 3000000, 1, std::nullopt}, {1, 1, 2000000, 4000000, 2, 77}, {2, 2, 3000000, 5000000, 3, 0}};
  return row;
}

TEST_F(StoreTest, EveryFieldComesBack) {
  int64_t comparison_id = 0;
  {
    StoreWriter store(file_);
    const int64_t run = store.write(a_run());
    store.write(a_measurement(run));
    store.write(
        RatioRow{0, run, "speed", {"flat", "mannequin", 250, 640, 480, 0.15}, "mesh", "cpu", 12.5, 11.0, 13.5, 20});
    ComparisonRow comparison;
    comparison.run = run;
    comparison.kind = "agent";
    comparison.representation = "flat";
    comparison.reference = "mesh";
    comparison.character = "mannequin";
    comparison.height_px = 64.0;
    comparison.clip = "walk";
    comparison.scores = {{"psnr", std::numeric_limits<double>::infinity(), ""},
                         {"ssim", std::nullopt, "smaller than 11 pixels"}};
    comparison_id = store.write(comparison);
    store.write(PictureRow{0, run, comparison_id, "difference", "a caption", 2, 1, {0, 1, 2, 255}});
  }
  const StoreContents all = read_store(file_, true);
  ASSERT_EQ(all.runs.size(), 1U);
  EXPECT_EQ(all.runs[0].seed, std::numeric_limits<uint64_t>::max());
  EXPECT_EQ(all.runs[0].scenario_name, "a </script> name");
  EXPECT_EQ(all.runs[0].scenario, "seed = 7\n");
  EXPECT_EQ(all.runs[0].gl_renderer, "llvmpipe");
  EXPECT_TRUE(all.runs[0].software);
  EXPECT_EQ(all.runs[0].cpu_threads, 2);
  EXPECT_EQ(all.runs[0].os, "Linux 6");
  EXPECT_DOUBLE_EQ(all.runs[0].timer_cost_ns, 250.5);

  ASSERT_EQ(all.measurements.size(), 1U);
  const MeasurementRow& row = all.measurements[0];
  const MeasurementRow wanted = a_measurement(all.runs[0].id);
  EXPECT_EQ(row.run, all.runs[0].id);
  EXPECT_EQ(row.key, wanted.key);
  EXPECT_EQ(row.status, Status::valid);
  EXPECT_EQ(row.achieved_occupancy, 0.1512);
  EXPECT_EQ(row.covered_px, 46000U);
  EXPECT_EQ(row.reference_px, 46100U);
  EXPECT_EQ(row.moved_px, 900U);
  EXPECT_FALSE(row.touched_px.has_value());
  EXPECT_EQ(row.agents_wholly, 240U);
  EXPECT_EQ(row.agents_partly, 8U);
  EXPECT_EQ(row.agents_off, 2U);
  EXPECT_EQ(row.triangles_per_agent, 2U);
  EXPECT_EQ(row.rounds, 3);
  EXPECT_EQ(row.warmup_frames, 4);
  EXPECT_TRUE(row.settled);
  ASSERT_TRUE(row.frame_ns && row.cpu_ns && row.main_cpu_ns);
  EXPECT_EQ(row.frame_ns->median, 2.0e6);
  EXPECT_EQ(row.frame_ns->low, 1.0e6);
  EXPECT_EQ(row.frame_ns->high, 3.0e6);
  EXPECT_EQ(row.frame_ns->p05, 1.1e6);
  EXPECT_EQ(row.frame_ns->p95, 2.9e6);
  EXPECT_EQ(row.frame_ns->p99, 2.98e6);
  EXPECT_EQ(row.cpu_ns->median, 4.0e6);
  EXPECT_EQ(row.main_cpu_ns->p99, 6.0);
  EXPECT_FALSE(row.gpu_ns.has_value());
  EXPECT_EQ(row.low_1_percent_fps, 333.25);
  EXPECT_EQ(row.vertices_shaded, 1000U);
  EXPECT_EQ(row.fragments, 0U);
  EXPECT_FALSE(row.primitives.has_value());
  EXPECT_EQ(row.texture_bytes, uint64_t{5} << 30);
  EXPECT_EQ(row.bake_cached, false);
  EXPECT_FALSE(row.disk_bytes.has_value());
  ASSERT_EQ(row.samples.size(), 3U);
  EXPECT_FALSE(row.samples[0].gpu_ns.has_value());
  EXPECT_EQ(row.samples[1].gpu_ns, 77);
  EXPECT_EQ(row.samples[2].gpu_ns, 0);
  EXPECT_EQ(row.samples[2].cpu_ns, 5000000);

  ASSERT_EQ(all.ratios.size(), 1U);
  EXPECT_EQ(all.ratios[0].to, "mesh");
  EXPECT_EQ(all.ratios[0].ratio, 12.5);
  EXPECT_EQ(all.ratios[0].low, 11.0);
  EXPECT_EQ(all.ratios[0].pairs, 20);
  ASSERT_EQ(all.comparisons.size(), 1U);
  EXPECT_EQ(all.comparisons[0].height_px, 64.0);
  EXPECT_FALSE(all.comparisons[0].azimuth_deg.has_value());
  ASSERT_EQ(all.comparisons[0].scores.size(), 2U);
  EXPECT_TRUE(std::isinf(all.comparisons[0].scores[0].value.value()));
  EXPECT_FALSE(all.comparisons[0].scores[1].value.has_value());
  EXPECT_EQ(all.comparisons[0].scores[1].reason, "smaller than 11 pixels");
  ASSERT_EQ(all.pictures.size(), 1U);
  EXPECT_EQ(all.pictures[0].comparison, comparison_id);
  EXPECT_EQ(all.pictures[0].png, (std::vector<uint8_t>{0, 1, 2, 255}));
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
  const auto bytes = [](const std::filesystem::path& path) {
    std::ifstream in(path, std::ios::binary);
    return std::string(std::istreambuf_iterator<char>(in), {});
  };
  const std::string before = bytes(foreign);
  EXPECT_NE(error_of([&] { read_store(foreign); }).find("another program"), std::string::npos);
  EXPECT_NE(error_of([&] { StoreWriter store(foreign); }).find("another program"), std::string::npos);
  EXPECT_EQ(bytes(foreign), before);

  EXPECT_NE(error_of([&] { read_store(folder_ / "none.sqlite"); }).find("no such file"), std::string::npos);
  EXPECT_FALSE(std::filesystem::exists(folder_ / "none.sqlite"));
  EXPECT_NE(error_of([&] { read_store(folder_); }).find("folder"), std::string::npos);
  EXPECT_NE(error_of([&] { StoreWriter store(folder_); }).find("folder"), std::string::npos);
}

TEST_F(StoreTest, RefusesANewerSchema) {
  { StoreWriter store(file_); }
  sql(file_, "PRAGMA user_version=99");
  const std::string reading = error_of([&] { read_store(file_); });
  EXPECT_NE(reading.find("newer"), std::string::npos) << reading;
  EXPECT_NE(reading.find("99"), std::string::npos) << reading;
  EXPECT_NE(error_of([&] { StoreWriter store(file_); }).find("newer"), std::string::npos);
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
  size_t files = 0;
  for ([[maybe_unused]] const auto& entry : std::filesystem::directory_iterator(folder_)) ++files;
  EXPECT_EQ(files, 1U);
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
