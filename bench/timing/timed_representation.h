// A crowd in front of a camera, the representations that draw it in turn, and the check of their pictures.
#pragma once
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "bench/timing/timing.h"
#include "renderers/frame/capture.h"
#include "renderers/gl/context.h"
#include "renderers/gl/counters.h"
#include "renderers/representation.h"
#include "scene/crowd/crowd.h"
#include "scene/crowd/occupancy.h"

namespace crowdbench::bench {

// One cast with its renderer, a crowd and a camera, and the posed frame of the latest tick asked for. What it refers to
// must outlive it.
class Stage {
 public:
  Stage(gl::Context& context, const scene::Cast& cast);
  // What frames show from now on; `scenario` and `crowd` must stay where they are.
  void show(const scene::Scenario& scenario, const scene::Crowd& crowd, const scene::Camera& camera);
  const scene::Frame& frame(uint64_t tick);
  const scene::Frame& latest() const { return frame_; }
  renderers::Renderer& renderer() { return renderer_; }
  gl::Context& context() { return context_; }
  const scene::Cast& cast() const { return cast_; }

 private:
  gl::Context& context_;
  const scene::Cast& cast_;
  const scene::Scenario* scenario_ = nullptr;
  const scene::Crowd* crowd_ = nullptr;
  scene::Camera camera_;
  renderers::Renderer renderer_;
  scene::Frame frame_;
  std::optional<uint64_t> tick_;
};

// One representation on one stage, with the target that its timed frames go to (no ids).
class TimedRepresentation {
 public:
  // Bakes; its pictures are width x height. Throws Error.
  TimedRepresentation(Stage& stage, const renderers::Spec& spec, int width, int height, uint64_t bake_budget);
  const std::string& name() const { return name_; }  // canonical text
  bool is_floor() const { return floor_; }
  renderers::Representation& representation() { return *representation_; }
  Stage& stage() { return stage_; }
  // For time_interleaved: `prepare` poses, `draw` goes from the frame in hand to finished colour and depth.
  Variant variant();
  // An untimed frame with ids.
  renderers::Capture capture(uint64_t tick);
  // Pixels that any fragment of an untimed frame reaches, discarded or not (the boxes and polygons, not the figures).
  uint64_t touched_px(uint64_t tick);
  // Pipeline statistics of one untimed frame.
  gl::PipelineCounts count(uint64_t tick);

 private:
  Stage& stage_;
  std::string name_;
  bool floor_ = false;
  std::unique_ptr<renderers::Representation> representation_;
  renderers::Target target_;
};

// Two pictures of one representation at two ticks, held against the reference's at the first.
struct ImageCheck {
  uint64_t covered_px = 0;  // pixels with an agent id, first tick
  uint64_t moved_px = 0;    // pixels whose colour differs between the ticks
  std::string fault;        // empty: passed
};
// A floor is allowed to cover more and to stand still: that is its work removed. All others must cover the
// reference's number of pixels within this fraction of it (what impostors lose or add at their outlines stays far
// below; a crowd that vanished into its mipmaps or a wrong camera does not), and must move where the reference moves.
constexpr double kCoverageBound = 0.15;
ImageCheck check_pictures(const renderers::Capture& first, const renderers::Capture& second, bool floor,
                          const std::optional<ImageCheck>& reference);

// What the timed frames of this context are judged by: process CPU time on a software rasteriser; GPU time where the
// timer passed its self-test; else wall time. Draws for some tens of milliseconds.
struct TimingMethod {
  Metric headline = Metric::cpu;
  bool gpu_trusted = false;
  std::string gpu_reason;
};
TimingMethod choose_timing_method(gl::Context& context);
// The hooks for time_interleaved; std::nullopt when the timer is not trusted.
std::optional<GpuTimer> gpu_timer_of(gl::Context& context, const TimingMethod& method);

// The scenario's crowd and camera, solved for its occupancy by drawing the mesh where one is asked for, as they stand
// where none is. Throws Error.
scene::Solved solve_scene(gl::Context& context, const scene::Scenario& scenario, const scene::Cast& cast);

// The same crowd played by the built-in character with 500 triangles: every figure of speed against the mesh is also
// told against what a user would reach for instead.
struct LowPolygonCast {
  scene::Scenario scenario;
  scene::Cast cast;
  scene::Crowd crowd;
};
LowPolygonCast low_polygon_cast(const scene::Scenario& scenario, const scene::Crowd& crowd);

// "mannequin" or "a.glb + b.glb": how rows and tables call a cast.
std::string cast_name(const scene::Cast& cast);

}  // namespace crowdbench::bench
