// What the machine says of its processor, for the provenance of what was measured. Nothing is made up: what the machine
// does not say is std::nullopt.
#pragma once
#include <filesystem>
#include <optional>
#include <string>

namespace crowdbench {

struct Machine {
  std::optional<std::string> cpu_model;
  std::optional<double> cpu_mhz;            // highest clock that the kernel permits; else the one that it reports
  std::optional<bool> cpu_scaling_enabled;  // a frequency governor other than "performance" rules some processor
};

// Reads ROOT/proc/cpuinfo and ROOT/sys/devices/system/cpu (Linux). Never throws: what cannot be read is absent.
Machine read_machine(const std::filesystem::path& root = "/");

}  // namespace crowdbench
