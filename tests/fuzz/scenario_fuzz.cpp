// Whatever the text, the scenario parser answers with a scenario that survives its own text, or with one Error.
#include <cstdint>
#include <cstdlib>
#include <string>

#include "core/error.h"
#include "scene/scenario/parse_scenario.h"
#include "scene/scenario/scenario.h"
#include "scene/scenario/scenario_writer.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace crowdbench;
  const std::string text(reinterpret_cast<const char*>(data), size);
  try {
    const scene::Scenario scenario = scene::parse_scenario(text, "fuzz");
    const std::string written = scene::to_toml(scenario);
    if (!(scene::parse_scenario(written, "written") == scenario)) std::abort();
  } catch (const Error& error) {
    const std::string line = error.what();
    if (line.empty() || line.find('\n') != std::string::npos) std::abort();
    if (error.where == "written") std::abort();
  }
  return 0;
}
