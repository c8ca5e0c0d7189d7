#include "core/machine.h"

#include <charconv>
#include <fstream>

namespace crowdbench {
namespace {

std::optional<std::string> first_line(const std::filesystem::path& path) {
  std::ifstream in(path);
  std::string line;
  if (!std::getline(in, line) || line.empty()) return std::nullopt;
  return line;
}

// A number above 0.
std::optional<double> number(const std::optional<std::string>& text) {
  if (!text) return std::nullopt;
  double value = 0;
  const auto [end, failed] = std::from_chars(text->data(), text->data() + text->size(), value);
  if (failed != std::errc() || end != text->data() + text->size() || !(value > 0)) return std::nullopt;
  return value;
}

// The first "key : value" of /proc/cpuinfo; other architectures than x86 have other keys, or none.
std::optional<std::string> cpuinfo(const std::filesystem::path& root, const std::string& key) {
  std::ifstream in(root / "proc/cpuinfo");
  for (std::string line; std::getline(in, line);) {
    const size_t colon = line.find(':');
    if (colon == std::string::npos) continue;
    const size_t end = line.find_last_not_of(" \t", colon == 0 ? 0 : colon - 1);
    if (end == std::string::npos || line.substr(0, end + 1) != key) continue;
    const size_t start = line.find_first_not_of(" \t", colon + 1);
    if (start == std::string::npos) return std::nullopt;
    return line.substr(start);
  }
  return std::nullopt;
}

}  // namespace

Machine read_machine(const std::filesystem::path& root) {
  Machine machine;
  machine.cpu_model = cpuinfo(root, "model name");
  const std::filesystem::path processors = root / "sys/devices/system/cpu";
  if (const auto khz = number(first_line(processors / "cpu0/cpufreq/scaling_max_freq")))
    machine.cpu_mhz = *khz / 1000;
  else
    machine.cpu_mhz = number(cpuinfo(root, "cpu MHz"));
  std::error_code failed;
  for (std::filesystem::directory_iterator at(processors, failed), end; !failed && at != end; at.increment(failed)) {
    const auto governor = first_line(at->path() / "cpufreq/scaling_governor");
    if (governor)
      machine.cpu_scaling_enabled = machine.cpu_scaling_enabled.value_or(false) || *governor != "performance";
  }
  return machine;
}

}  // namespace crowdbench
