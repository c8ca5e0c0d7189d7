// Which clock the timed frames of a context are judged by.
#pragma once
#include <optional>
#include <string>

#include "bench/timing/timing.h"
#include "renderers/gl/context.h"

namespace crowdbench::bench {

// Process CPU time on a software rasteriser; GPU time where the timer passed its self-test; else wall time.
struct TimingMethod {
  Metric headline = Metric::cpu;
  bool gpu_trusted = false;
  std::string gpu_reason;
};
// Draws for some tens of milliseconds.
TimingMethod choose_timing_method(gl::Context& context);
// The hooks for time_interleaved; std::nullopt when the timer is not trusted.
std::optional<GpuTimer> gpu_timer_of(gl::Context& context, const TimingMethod& method);

}  // namespace crowdbench::bench
