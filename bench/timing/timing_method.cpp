#include "bench/timing/timing_method.h"

#include <memory>

#include "renderers/gl/counters.h"

namespace crowdbench::bench {

TimingMethod choose_timing_method(gl::Context& context) {
  TimingMethod method;
  const gl::TimerTrust trust = gl::test_gpu_timer(context);
  method.gpu_trusted = trust.trusted && !context.is_software();
  method.gpu_reason = trust.reason;
  method.headline = context.is_software() ? Metric::cpu : method.gpu_trusted ? Metric::gpu : Metric::wall;
  return method;
}

std::optional<GpuTimer> gpu_timer_of(gl::Context& context, const TimingMethod& method) {
  if (!method.gpu_trusted) return std::nullopt;
  auto timer = std::make_shared<gl::GpuTimer>(context);
  return GpuTimer{[timer] { timer->begin(); },
                  [timer] {
                    timer->end();
                    return static_cast<int64_t>(timer->elapsed_ns());
                  }};
}

}  // namespace crowdbench::bench
