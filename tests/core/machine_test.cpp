#include "core/machine.h"

#include <gtest/gtest.h>

#include <filesystem>

#include "core/files.h"
#include "core/version.h"
#include "test_paths.h"
#include "tests/support/scratch_folder.h"

namespace crowdbench {
namespace {

class MachineTest : public testing::Test {
 protected:
  void put(const std::string& path, const std::string& text) const {
    const std::filesystem::path file = folder_.path() / path;
    std::filesystem::create_directories(file.parent_path());
    write_file(file, std::string_view(text));
  }
  Machine read() const { return read_machine(folder_.path()); }

  support::ScratchFolder folder_;
};

TEST_F(MachineTest, WhatTheMachineDoesNotSayIsAbsent) {
  EXPECT_EQ(read().cpu_model, std::nullopt);
  EXPECT_EQ(read().cpu_mhz, std::nullopt);
  EXPECT_EQ(read().cpu_scaling_enabled, std::nullopt);
  // An ARM machine in a virtual one: neither a name nor a clock.
  put("proc/cpuinfo", "processor\t: 0\nBogoMIPS\t: 50.00\nmodel name\t:\nCPU part\t: 0xd0c\ncpu MHz\t\t: unknown\n");
  put("sys/devices/system/cpu/online", "0-1\n");
  EXPECT_EQ(read().cpu_model, std::nullopt);
  EXPECT_EQ(read().cpu_mhz, std::nullopt);
  EXPECT_EQ(read().cpu_scaling_enabled, std::nullopt);
}

TEST_F(MachineTest, ReadsTheFirstProcessor) {
  put("proc/cpuinfo",
      "processor\t: 0\nmodel\t\t: 6\nmodel name\t: A CPU: 8 cores @ 3.00GHz\ncpu MHz\t\t: 2599.998\n\n"
      "processor\t: 1\nmodel name\t: another\ncpu MHz\t\t: 800.0\n");
  EXPECT_EQ(read().cpu_model, "A CPU: 8 cores @ 3.00GHz");
  EXPECT_EQ(read().cpu_mhz, 2599.998);
  EXPECT_EQ(read().cpu_scaling_enabled, std::nullopt);
}

TEST_F(MachineTest, PrefersThePermittedClockToTheOneOfTheMoment) {
  put("proc/cpuinfo", "model name\t: A CPU\ncpu MHz\t\t: 800.0\n");
  put("sys/devices/system/cpu/cpu0/cpufreq/scaling_max_freq", "3600000\n");
  EXPECT_EQ(read().cpu_mhz, 3600.0);
}

TEST_F(MachineTest, OneScalingProcessorIsEnough) {
  put("sys/devices/system/cpu/cpu0/cpufreq/scaling_governor", "performance\n");
  EXPECT_EQ(read().cpu_scaling_enabled, false);
  put("sys/devices/system/cpu/cpu1/cpufreq/scaling_governor", "schedutil\n");
  put("sys/devices/system/cpu/cpu2/cpufreq/scaling_governor", "performance\n");
  EXPECT_EQ(read().cpu_scaling_enabled, true);
}

// One number of the program, in the build, the package and the list of changes.
TEST(Version, IsTheProjects) {
  const std::filesystem::path root = CROWDBENCH_SOURCE_DIR;
  const std::string number(version());
  EXPECT_EQ(std::count(number.begin(), number.end(), '.'), 2) << number;
  EXPECT_NE(read_text(root / "CMakeLists.txt").find("project(crowdbench VERSION " + number + " "), std::string::npos);
  EXPECT_FALSE(git_revision().empty());
  EXPECT_EQ(git_revision().find_first_of(" \n"), std::string_view::npos) << git_revision();
}

}  // namespace
}  // namespace crowdbench
