// What the GPU counts and times: pipeline statistics, samples passed, and whether its timer can be trusted.
#pragma once
#include <cstdint>
#include <optional>
#include <string>

#include "renderers/gl/objects.h"

namespace crowdbench::gl {

// Counts of one stretch of commands; std::nullopt where the driver does not count. They do not depend on the machine's
// mood, but definitions differ between vendors (fragment invocations are whole 4x4 blocks before the depth test on
// llvmpipe): compare within one driver only.
struct PipelineCounts {
  std::optional<uint64_t> vertices_submitted;
  std::optional<uint64_t> primitives_submitted;
  std::optional<uint64_t> vertex_invocations;
  std::optional<uint64_t> clipping_input;
  std::optional<uint64_t> clipping_output;
  std::optional<uint64_t> fragment_invocations;
  std::optional<uint64_t> compute_invocations;
  std::optional<uint64_t> samples_passed;  // after the depth test and discard
};

class PipelineCounter {
 public:
  explicit PipelineCounter(Context& context);
  void begin();
  void end();
  PipelineCounts result() const;  // waits

 private:
  static constexpr int kKinds = 8;
  Query queries_[kKinds];
  bool statistics_ = false;  // GL_ARB_pipeline_statistics_query
};

// Nanoseconds of GPU time between begin and end (GL_TIME_ELAPSED).
class GpuTimer {
 public:
  explicit GpuTimer(Context& context);
  void begin() const { query_.begin(); }
  void end() const { query_.end(); }
  uint64_t elapsed_ns() const { return query_.result(); }  // waits

 private:
  Query query_;
};

// What a heavy draw of known wall time says of the driver's timer.
struct TimerTrust {
  bool trusted = false;
  double gpu_ns = 0;   // what the timer said
  double wall_ns = 0;  // from an idle pipeline to a finished one
  std::string reason;  // one line, for people
};
// Draws for some tens of milliseconds. Trusted when the timer accounts for 0.5 to 1.1 of the wall time, and never on a
// software rasteriser: llvmpipe times some of its tiles only, and gets a simple draw right by luck.
TimerTrust test_gpu_timer(Context& context);

}  // namespace crowdbench::gl
