#include "bench/timing/run_facts.h"

#include <fmt/chrono.h>
#include <fmt/format.h>
#include <sched.h>
#include <sys/utsname.h>
#include <unistd.h>

#include <algorithm>
#include <ctime>

#include "core/hash.h"
#include "core/machine.h"
#include "core/version.h"
#include "scene/scenario/scenario_writer.h"

namespace crowdbench::bench {
namespace {

int usable_threads() {
  cpu_set_t set;
  CPU_ZERO(&set);
  if (sched_getaffinity(0, sizeof set, &set) == 0) return CPU_COUNT(&set);
  return static_cast<int>(std::max(sysconf(_SC_NPROCESSORS_ONLN), 1L));  // more processors than the set holds
}

}  // namespace

RunRow describe_run(gl::Context& context, const TimingMethod& method, const scene::Scenario& scenario,
                    const std::string& command, const std::string& arguments, uint64_t order_seed) {
  RunRow run;
  run.command = command;
  run.arguments = arguments;
  const std::time_t now = std::time(nullptr);
  run.started = fmt::format("{:%Y-%m-%dT%H:%M:%SZ}", fmt::gmtime(now));
  run.version = version();
  run.revision = git_revision();
  run.scenario_name = scenario.name;
  run.scenario = scene::to_toml(scenario);
  run.scenario_hash = sha256_hex(run.scenario);
  run.seed = scenario.seed;
  run.order_seed = order_seed;
  run.gl_vendor = context.vendor();
  run.gl_renderer = context.renderer();
  run.gl_version = context.version();
  run.software = context.is_software();
  run.headline = metric_name(method.headline);
  const Machine machine = read_machine();
  run.cpu_model = machine.cpu_model;
  run.cpu_mhz = machine.cpu_mhz;
  run.cpu_scaling_enabled = machine.cpu_scaling_enabled;
  run.cpu_threads = usable_threads();
  utsname names{};
  if (uname(&names) == 0) run.os = fmt::format("{} {}", names.sysname, names.release);
  run.timer_cost_ns = timer_cost_ns(system_clocks());
  return run;
}

}  // namespace crowdbench::bench
