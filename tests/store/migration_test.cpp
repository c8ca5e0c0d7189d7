// Files of older schemas. tests/data/store/schema-1.sqlite was written by the last crowdbench of schema 1:
//   for seed in 1 2; do crowdbench bench --representations flat:views=hemi-4 --agents 1,2 --rounds 10
//     --occupancy 0.15,0.99 --size 64x48 --picture-agents 0 --seed $seed --device software --out schema-1.sqlite; done
// and tests/data/store/schema-2.sqlite by the last of schema 2:
//   crowdbench bench --representation flat:views=hemi-4 --agents 1,2 --rounds 10 --occupancy 0.15 --size 64x48
//     --picture-agents 1 --device software --out schema-2.sqlite
// and tests/data/store/schema-3.sqlite to schema-8.sqlite by the last of schema 3 to 8 with the same one.
#include <gtest/gtest.h>
#include <sqlite3.h>
#include <sys/resource.h>

#include <algorithm>
#include <csignal>
#include <fstream>
#include <map>

#include "core/error.h"
#include "store/store.h"
#include "test_paths.h"
#include "tests/store/full_rows.h"
#include "tests/support/scratch_folder.h"

namespace crowdbench {
namespace {

class MigrationTest : public testing::Test {
 protected:
  void SetUp() override { take("schema-1.sqlite"); }

  static std::string bytes(const std::filesystem::path& path) {
    std::ifstream in(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
  }
  // The rows that a query gives, their columns joined by "|".
  static std::vector<std::string> rows(const std::filesystem::path& path, const std::string& query) {
    std::vector<std::string> all;
    sqlite3* database = nullptr;
    EXPECT_EQ(sqlite3_open(path.c_str(), &database), SQLITE_OK);
    sqlite3_stmt* statement = nullptr;
    EXPECT_EQ(sqlite3_prepare_v2(database, query.c_str(), -1, &statement, nullptr), SQLITE_OK)
        << sqlite3_errmsg(database);
    while (sqlite3_step(statement) == SQLITE_ROW) {
      std::string row;
      for (int i = 0; i < sqlite3_column_count(statement); ++i) {
        const auto* text = reinterpret_cast<const char*>(sqlite3_column_text(statement, i));
        if (i > 0) row += '|';
        row += text != nullptr ? text : "NULL";
      }
      all.push_back(row);
    }
    sqlite3_finalize(statement);
    EXPECT_EQ(sqlite3_close(database), SQLITE_OK);
    return all;
  }
  static std::string schema(const std::filesystem::path& path) { return rows(path, "PRAGMA user_version").at(0); }
  static void expect_equal(const StoreContents& a, const StoreContents& b) {
    EXPECT_TRUE(a.runs == b.runs);
    EXPECT_TRUE(a.measurements == b.measurements);
    EXPECT_TRUE(a.ratios == b.ratios);
    EXPECT_TRUE(a.controls == b.controls);
    EXPECT_TRUE(a.comparisons == b.comparisons);
    EXPECT_TRUE(a.pictures == b.pictures);
    EXPECT_TRUE(a.curves == b.curves);
    EXPECT_TRUE(a.thresholds == b.thresholds);
    EXPECT_TRUE(a.cause_ranges == b.cause_ranges);
    EXPECT_TRUE(a.pops == b.pops);
    EXPECT_TRUE(a.tunings == b.tunings);
    EXPECT_TRUE(a.stability_cases == b.stability_cases);
    EXPECT_TRUE(a.participants == b.participants);
    EXPECT_TRUE(a.answers == b.answers);
  }
  void take(const char* name) {
    std::filesystem::copy_file(std::filesystem::path(CROWDBENCH_TEST_DATA) / "store" / name, file_,
                               std::filesystem::copy_options::overwrite_existing);
    std::filesystem::permissions(file_, std::filesystem::perms::owner_read | std::filesystem::perms::owner_write);
  }
  static std::map<std::string, std::string> statements(const std::filesystem::path& path) {
    std::map<std::string, std::string> all;
    // White space apart; a table that was renamed has its name in quotes.
    for (const std::string& row : rows(path, "SELECT name, sql FROM sqlite_master WHERE sql IS NOT NULL")) {
      std::string text;
      for (const char c : row.substr(row.find('|') + 1))
        if (c != ' ' && c != '\n' && c != '"') text += c;
      all[row.substr(0, row.find('|'))] = text;
    }
    return all;
  }

  support::ScratchFolder folder_;
  std::filesystem::path file_ = folder_ / "old.sqlite";
};

TEST_F(MigrationTest, AnOlderFileIsReadAndLeftAsItIs) {
  const std::string before = bytes(file_);
  const StoreContents all = read_store(file_, true);
  EXPECT_EQ(bytes(file_), before);
  EXPECT_FALSE(std::filesystem::exists(file_.string() + "-wal"));

  ASSERT_EQ(all.runs.size(), 2U);
  EXPECT_EQ(all.runs[0].seed, 1U);
  EXPECT_EQ(all.runs[1].seed, 2U);
  EXPECT_EQ(all.runs[1].arguments, "bench flat:views=hemi-4");
  EXPECT_EQ(all.runs[1].cpu_model, "AMD EPYC");
  EXPECT_EQ(all.runs[1].revision, "92177b2f4c6c");
  EXPECT_EQ(all.runs[1].order_seed, std::nullopt);
  EXPECT_EQ(all.runs[1].cpu_mhz, std::nullopt);
  EXPECT_EQ(all.runs[1].cpu_scaling_enabled, std::nullopt);
  ASSERT_EQ(all.measurements.size(), 16U);
  EXPECT_EQ(all.measurements[11].key, (PointKey{"flat:views=hemi-4", "mannequin", 2, 64, 48, 0.15}));
  EXPECT_EQ(all.measurements[11].samples.size(), 10U);
  EXPECT_EQ(all.measurements[15].status, Status::unreachable);
  EXPECT_EQ(all.measurements[15].reason, "2 agents cover 60.87 % at most, 99 % were asked for");
  EXPECT_EQ(all.ratios.size(), 24U);
  ASSERT_EQ(all.comparisons.size(), 4U);
  ASSERT_EQ(all.comparisons[3].scores.size(), 5U);
  EXPECT_EQ(all.comparisons[3].scores[4].name, "ssim");
  EXPECT_NEAR(all.comparisons[3].scores[4].value.value(), 0.87529420202297, 1e-12);
  EXPECT_EQ(all.pictures.size(), 6U);
}

TEST_F(MigrationTest, AWriterBringsItForwardAndGoesOn) {
  const StoreContents before = read_store(file_, true);
  MeasurementRow added = full_measurement(0);
  {
    StoreWriter store(file_);
    expect_equal(read_store(file_, true), before);
    // `bench` continues where the older program ended.
    const auto found = store.find(before.runs[1], before.measurements[10].key);
    ASSERT_TRUE(found.has_value());
    EXPECT_EQ(found->id, before.measurements[10].id);
    added.run = store.write(full_run());
    added.id = store.write(added);
  }
  EXPECT_EQ(schema(file_), std::to_string(kStoreSchemaVersion));
  const StoreContents after = read_store(file_, true);
  ASSERT_EQ(after.runs.size(), 3U);
  RunRow wanted = full_run();
  wanted.id = 3;
  EXPECT_TRUE(after.runs[2] == wanted);
  ASSERT_EQ(after.measurements.size(), 17U);
  EXPECT_TRUE(after.measurements[16] == added);
  EXPECT_TRUE(std::equal(before.measurements.begin(), before.measurements.end(), after.measurements.begin()));
  EXPECT_EQ(rows(file_, "SELECT order_seed, gl_renderer FROM results WHERE id IN (16, 17)"),
            (std::vector<std::string>{"NULL|" + before.runs[1].gl_renderer, "18446744073709551614|llvmpipe"}));
}

// Whoever changes a column, a check or an index without a new schema, or a table that migration then forgets, fails
// here.
TEST_F(MigrationTest, ABroughtForwardFileHasTheSchemaOfANewOne) {
  const auto fresh = folder_ / "new.sqlite";
  { StoreWriter store(fresh); }
  const auto wanted = statements(fresh);
  EXPECT_TRUE(wanted.contains("run") && wanted.contains("measurement_key") && wanted.contains("results"));
  for (const char* older : {"schema-1.sqlite", "schema-2.sqlite", "schema-3.sqlite", "schema-4.sqlite",
                            "schema-5.sqlite", "schema-6.sqlite", "schema-7.sqlite", "schema-8.sqlite"}) {
    take(older);
    { StoreWriter store(file_); }
    EXPECT_EQ(statements(file_), wanted) << older;
  }
}

// Schema 2 knew neither displays nor agents of a crowd, nor curves.
TEST_F(MigrationTest, SchemaTwoGainsCurvesAndKeepsItsScores) {
  take("schema-2.sqlite");
  const StoreContents before = read_store(file_, true);
  ASSERT_EQ(before.comparisons.size(), 2U);
  EXPECT_EQ(before.comparisons[1].display, std::nullopt);
  EXPECT_EQ(before.comparisons[1].agent, std::nullopt);
  EXPECT_EQ(before.comparisons[1].scores.size(), 19U);
  EXPECT_EQ(before.pictures.size(), 3U);
  EXPECT_TRUE(before.curves.empty());
  CurveRow curve = full_curve(1);
  ComparisonRow agent = full_comparison(1);
  agent.kind = "agent_in_crowd";
  {
    StoreWriter store(file_);
    expect_equal(read_store(file_, true), before);
    curve.id = store.write(curve);
    agent.id = store.write(agent);
  }
  EXPECT_EQ(schema(file_), std::to_string(kStoreSchemaVersion));
  const StoreContents after = read_store(file_, true);
  ASSERT_EQ(after.curves.size(), 1U);
  EXPECT_TRUE(after.curves[0] == curve);
  ASSERT_EQ(after.comparisons.size(), 3U);
  EXPECT_TRUE(after.comparisons[1] == before.comparisons[1]);
  EXPECT_TRUE(after.comparisons[2] == agent);
}

// Schema 3 knew no controls.
TEST_F(MigrationTest, SchemaThreeGainsControls) {
  take("schema-3.sqlite");
  const StoreContents before = read_store(file_, true);
  EXPECT_EQ(before.measurements.size(), 4U);
  EXPECT_TRUE(before.controls.empty());
  ControlRow control = full_control(1);
  {
    StoreWriter store(file_);
    expect_equal(read_store(file_, true), before);
    control.id = store.write(control);
  }
  const StoreContents after = read_store(file_, true);
  ASSERT_EQ(after.controls.size(), 1U);
  EXPECT_TRUE(after.controls[0] == control);
  EXPECT_TRUE(after.measurements == before.measurements);
}

// Schema 3 knew no sweeps.
TEST_F(MigrationTest, SchemaThreeGainsSweepsAndKeepsItsRows) {
  take("schema-3.sqlite");
  const StoreContents before = read_store(file_, true);
  ASSERT_EQ(before.measurements.size(), 4U);
  ASSERT_EQ(before.comparisons.size(), 2U);
  EXPECT_TRUE(before.comparisons[0].display.has_value());
  EXPECT_TRUE(before.sweeps.empty());
  SweepRow sweep = full_sweep();
  SweepPointRow point = full_sweep_point(1, 1, 2, 1);
  {
    StoreWriter store(file_);
    expect_equal(read_store(file_, true), before);
    sweep.id = store.write(sweep);
    point.id = store.write(point);
  }
  EXPECT_EQ(schema(file_), std::to_string(kStoreSchemaVersion));
  const StoreContents after = read_store(file_, true);
  ASSERT_EQ(after.sweeps.size(), 1U);
  EXPECT_TRUE(after.sweeps[0] == sweep);
  ASSERT_EQ(after.sweep_points.size(), 1U);
  EXPECT_TRUE(after.sweep_points[0] == point);
  EXPECT_TRUE(after.measurements == before.measurements);
  EXPECT_TRUE(after.pictures == before.pictures);
}

// Schema 4 knew no studies.
TEST_F(MigrationTest, SchemaFourGainsAnswersOfStudies) {
  take("schema-4.sqlite");
  const StoreContents before = read_store(file_, true);
  ASSERT_EQ(before.measurements.size(), 4U);
  EXPECT_TRUE(before.answers.empty());
  StudyParticipantRow who = full_participant();
  StudyAnswerRow answer = full_answer(1);
  {
    StoreWriter store(file_);
    expect_equal(read_store(file_, true), before);
    who.id = store.write(who);
    answer.id = store.write(answer);
  }
  const StoreContents after = read_store(file_, true);
  ASSERT_EQ(after.participants.size(), 1U);
  EXPECT_TRUE(after.participants[0] == who);
  ASSERT_EQ(after.answers.size(), 1U);
  EXPECT_TRUE(after.answers[0] == answer);
  EXPECT_TRUE(after.measurements == before.measurements);
}

// Schema 5 knew no tuned rules.
TEST_F(MigrationTest, SchemaFiveGainsTunedRules) {
  take("schema-5.sqlite");
  const StoreContents before = read_store(file_, true);
  ASSERT_EQ(before.measurements.size(), 4U);
  EXPECT_TRUE(before.tunings.empty());
  TuningRow tuning = full_tuning(1);
  {
    StoreWriter store(file_);
    expect_equal(read_store(file_, true), before);
    tuning.id = store.write(tuning);
  }
  const StoreContents after = read_store(file_, true);
  ASSERT_EQ(after.tunings.size(), 1U);
  EXPECT_TRUE(after.tunings[0] == tuning);
  EXPECT_TRUE(after.measurements == before.measurements);
}

// Schema 6 knew no cases of the stability battery.
TEST_F(MigrationTest, SchemaSixGainsStabilityCases) {
  take("schema-6.sqlite");
  const StoreContents before = read_store(file_, true);
  ASSERT_EQ(before.measurements.size(), 4U);
  EXPECT_TRUE(before.stability_cases.empty());
  StabilityCaseRow row = full_stability_case(1);
  {
    StoreWriter store(file_);
    expect_equal(read_store(file_, true), before);
    row.id = store.write(row);
  }
  const StoreContents after = read_store(file_, true);
  ASSERT_EQ(after.stability_cases.size(), 1U);
  EXPECT_TRUE(after.stability_cases[0] == row);
  EXPECT_TRUE(after.measurements == before.measurements);
}

// Schema 7 did not know how often a participant began each trial.
TEST_F(MigrationTest, SchemaSevenGainsWhatWasBegun) {
  take("schema-7.sqlite");
  rows(file_,
       "INSERT INTO study_participant (id, study, participant, list, state, token, started) VALUES (1, 'a', 'b', '1', "
       "'started', 'c', '2026-01-02T03:04:05Z')");
  const StoreContents before = read_store(file_, true);
  ASSERT_EQ(before.participants.size(), 1U);
  EXPECT_EQ(before.participants[0].begun, std::nullopt);
  StudyParticipantRow who = full_participant();
  {
    StoreWriter store(file_);
    expect_equal(read_store(file_, true), before);
    who.id = store.write(who);
  }
  const StoreContents after = read_store(file_, true);
  ASSERT_EQ(after.participants.size(), 2U);
  EXPECT_TRUE(after.participants[0] == before.participants[0]);
  EXPECT_TRUE(after.participants[1] == who);
}

// Schema 8 had one time for making a bake and for reading it.
TEST_F(MigrationTest, SchemaEightsTimesOfBakesAreOfMakingOrOfReading) {
  take("schema-8.sqlite");
  rows(file_, "UPDATE measurement SET bake_seconds = 3.5, bake_cached = 1 WHERE id = 1");
  rows(file_, "UPDATE measurement SET bake_seconds = 4.5, bake_cached = 0 WHERE id = 2");
  rows(file_, "UPDATE measurement SET bake_seconds = NULL, bake_cached = NULL WHERE id = 3");
  const StoreContents before = read_store(file_, true);
  EXPECT_EQ(before.measurements.at(0).bake_seconds, std::nullopt) << "what making it took was not kept";
  EXPECT_EQ(before.measurements.at(0).bake_load_seconds, 3.5);
  EXPECT_EQ(before.measurements.at(1).bake_seconds, 4.5);
  EXPECT_EQ(before.measurements.at(1).bake_load_seconds, std::nullopt);
  EXPECT_EQ(before.measurements.at(2).bake_seconds, std::nullopt);
  EXPECT_EQ(before.measurements.at(2).bake_load_seconds, std::nullopt);
  { StoreWriter store(file_); }
  EXPECT_EQ(schema(file_), std::to_string(kStoreSchemaVersion));
  expect_equal(read_store(file_, true), before);
}

TEST_F(MigrationTest, AnInventedProcessorBecomesAbsent) {
  rows(file_, "UPDATE run SET cpu_model = 'unknown processor' WHERE id = 1");
  const StoreContents before = read_store(file_);
  EXPECT_EQ(before.runs[0].cpu_model, std::nullopt);
  EXPECT_EQ(before.runs[1].cpu_model, "AMD EPYC");
  { StoreWriter store(file_); }
  EXPECT_EQ(rows(file_, "SELECT cpu_model FROM run"), (std::vector<std::string>{"NULL", "AMD EPYC"}));
}

TEST_F(MigrationTest, AFullDiskLeavesTheOlderFile) {
  // So long a text that the log of the migration cannot hold it under the limit below.
  rows(file_, "UPDATE run SET scenario = hex(zeroblob(40000))");
  const StoreContents before = read_store(file_, true);
  rlimit old{};
  ASSERT_EQ(getrlimit(RLIMIT_FSIZE, &old), 0);
  const auto handler = std::signal(SIGXFSZ, SIG_IGN);  // the write fails, as on a full disk
  const rlimit small{32768, old.rlim_max};             // enough for the log to begin
  ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &small), 0);
  std::string message;
  try {
    StoreWriter store(file_);
  } catch (const Error& error) {
    message = error.what();
  }
  ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &old), 0);
  std::signal(SIGXFSZ, handler);
  EXPECT_NE(message.find("what was finished before is kept"), std::string::npos) << message;
  EXPECT_EQ(schema(file_), "1");
  expect_equal(read_store(file_, true), before);
  { StoreWriter store(file_); }
  EXPECT_EQ(schema(file_), std::to_string(kStoreSchemaVersion));
  expect_equal(read_store(file_, true), before);
}

TEST_F(MigrationTest, ADamagedOlderFileIsLeftAsItIs) {
  rows(file_, "DELETE FROM run WHERE id = 1");  // its measurements stay
  const StoreContents before = read_store(file_, true);
  std::string message;
  try {
    StoreWriter store(file_);
  } catch (const Error& error) {
    message = error.what();
  }
  EXPECT_NE(message.find("damaged"), std::string::npos) << message;
  EXPECT_EQ(schema(file_), "1");
  expect_equal(read_store(file_, true), before);
}

}  // namespace
}  // namespace crowdbench
