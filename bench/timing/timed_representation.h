// A representation on a stage, drawn for the clock and, untimed, for everything that is said of its frames.
#pragma once
#include <cstdint>
#include <memory>
#include <string>

#include "bench/stage/stage.h"
#include "bench/timing/timing.h"
#include "renderers/gl/counters.h"
#include "renderers/representation.h"

namespace crowdbench::bench {

// One representation on one stage, with the target that its timed frames go to (no ids).
class TimedRepresentation {
 public:
  // Bakes; its pictures are of the scenario's size and samples. The averaging of supersamples is not timed, that of
  // multisamples is. Throws Error.
  TimedRepresentation(Stage& stage, const renderers::Spec& spec, const scene::Scenario& scenario, uint64_t bake_budget);
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
  // Fills in its bytes, its bake and its triangles.
  void put_footprint(MeasurementRow& row) const;

 private:
  Stage& stage_;
  std::string name_;
  bool floor_ = false;
  std::unique_ptr<renderers::Representation> representation_;
  renderers::Target target_;
};

}  // namespace crowdbench::bench
