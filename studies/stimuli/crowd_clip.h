// One crowd drawn once, losslessly: half of a stimulus, checked while it is drawn.
#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "core/json.h"
#include "renderers/gl/context.h"
#include "renderers/representation.h"
#include "scene/cast/cast.h"
#include "scene/scenario/scenario.h"

namespace crowdbench::studies {

struct CrowdClipRequest {
  std::string name;          // who is to blame in errors: the condition
  scene::Scenario scenario;  // with seed, spacing and camera as they are drawn; even sides
  renderers::Spec spec;
  size_t frames = 0;
  int fps = 30;
  double lead_in_seconds = 0;  // of the scenario's time before the first frame
  double largest_px = 1e9;     // rows that a figure may cover
  bool intersect = false;      // bodies may touch
};

// What was seen while it was drawn, by agent id; rows of the picture.
struct CrowdClip {
  std::vector<std::string> frame_sha256;  // as Clip::frame_sha256
  int tallest_px = 0;
  uint32_t tallest_id = 0;
  size_t tallest_frame = 0;
  double median_px = 0;  // of all figures of all frames, hidden parts not counted
  uint32_t fewest = 0;   // figures seen in a frame
  uint32_t most = 0;
  double bake_seconds = 0;  // spent on baking, or on reading the cache; no property of the clip
};
Json crowd_clip_json(const CrowdClip& clip);

// Ticks of the scenario from one frame to the next. Throws Error where that is no whole number. where: names the rate.
uint64_t ticks_per_frame(const scene::Scenario& scenario, int fps, const std::string& where);

// Draws into `target` (*.mp4, LosslessWriter). Throws Error at the first frame in which a figure is taller than
// allowed, bodies touch, somebody in view jumps (the seam of a loop), or nobody is seen.
CrowdClip draw_crowd_clip(gl::Context& context, const scene::Cast& cast, const CrowdClipRequest& request,
                          const std::filesystem::path& target);

}  // namespace crowdbench::studies
