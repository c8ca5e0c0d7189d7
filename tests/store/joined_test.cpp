#include "store/joined.h"

#include <gtest/gtest.h>

#include <set>

namespace crowdbench {
namespace {

// Two runs, of which the second measured and compared one point that a sweep planned.
StoreContents contents() {
  StoreContents out;
  out.runs.resize(2);
  out.runs[0].id = 1;
  out.runs[1].id = 2;
  out.measurements.resize(1);
  out.measurements[0].id = 7;
  out.measurements[0].run = 2;
  out.sweeps.resize(1);
  out.sweeps[0].id = 1;
  out.sweep_points.resize(1);
  out.sweep_points[0].id = 1;
  out.sweep_points[0].sweep = 1;
  out.sweep_points[0].measurement = 7;
  out.pictures.resize(2);
  out.pictures[0] = {.id = 1, .run = 2};
  out.pictures[1] = {.id = 2, .run = 2};
  return out;
}

TEST(Joined, IdsMeetNobodyElsesAndReferencesFollow) {
  const StoreContents all = joined({{"a", contents()}, {"b", contents()}, {"c", contents()}});
  ASSERT_EQ(all.runs.size(), 6U);
  std::set<int64_t> runs;
  for (const RunRow& run : all.runs) runs.insert(run.id);
  EXPECT_EQ(runs.size(), 6U);
  EXPECT_EQ(all.runs[0].id, 1) << "the first file's stay";
  for (size_t file = 0; file < 3; ++file) {
    EXPECT_EQ(all.measurements[file].run, all.runs[2 * file + 1].id);
    EXPECT_EQ(all.sweep_points[file].measurement, all.measurements[file].id);
    EXPECT_EQ(all.sweep_points[file].sweep, all.sweeps[file].id);
    EXPECT_EQ(all.pictures[2 * file].run, all.runs[2 * file + 1].id);
    EXPECT_EQ(all.pictures[2 * file].comparison, std::nullopt);
    EXPECT_EQ(all.sources.at(all.runs[2 * file].id), std::string(1, static_cast<char>('a' + file)));
  }
}

TEST(Joined, OneFileIsAsItWas) {
  const StoreContents all = joined({{"a", contents()}});
  EXPECT_EQ(all.runs[1].id, 2);
  EXPECT_TRUE(all.sources.empty());
}

}  // namespace
}  // namespace crowdbench
