#include "studies/stimuli/crowd_clip.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "core/error.h"
#include "core/progress.h"
#include "renderers/frame/capture.h"
#include "scene/crowd/crowd.h"
#include "studies/stimuli/bodies.h"
#include "studies/stimuli/clip.h"

namespace crowdbench::studies {
namespace {

// Faster than this nobody moves: whoever seems to has passed a seam.
constexpr double kFastest = 20;  // metres a second

struct Rows {
  int first = 0;
  int last = -1;
};

// The rows that each id covers.
std::map<uint32_t, Rows> rows_by_id(const ImageU32& ids) {
  std::vector<Rows> rows;
  for (int y = 0; y < ids.height; ++y) {
    const uint32_t* const row = ids.at(0, y);
    for (int x = 0; x < ids.width; ++x) {
      const uint32_t id = row[x];
      if (id == 0) continue;
      if (id >= rows.size()) rows.resize(id + 1);
      if (rows[id].last < 0) rows[id].first = y;
      rows[id].last = y;
    }
  }
  std::map<uint32_t, Rows> out;
  for (size_t id = 1; id < rows.size(); ++id)
    if (rows[id].last >= 0) out.emplace(static_cast<uint32_t>(id), rows[id]);
  return out;
}

// Holds every frame to what a stimulus promises.
class FrameChecks {
 public:
  FrameChecks(const CrowdClipRequest& request, const scene::Cast& cast) : request_(request), cast_(cast) {}

  void take(size_t index, const scene::Frame& frame, const ImageU32& ids) {
    const std::map<uint32_t, Rows> seen = rows_by_id(ids);
    for (const auto& [id, rows] : seen) {
      const int height = rows.last - rows.first + 1;
      heights_.push_back(height);
      if (height > clip_.tallest_px) {
        clip_.tallest_px = height;
        clip_.tallest_id = id;
        clip_.tallest_frame = index;
      }
      if (height > request_.largest_px)
        fail(fmt::format("agent {} is {} pixels tall in frame {}, more than `largest_px` = {:g}", id, height, index,
                         request_.largest_px),
             "move the camera away (camera.eye, `height_px`), or raise [stimulus] `largest_px`");
    }
    if (!request_.intersect)
      if (const auto touching = touching_bodies(frame, cast_))
        fail(fmt::format("agents {} and {} may stand in each other in frame {}", touching->first, touching->second,
                         index),
             "leave crowd.spacing out, raise it, or allow it with [stimulus] intersect = true");
    check_steps(index, frame, seen);
    const auto count = static_cast<uint32_t>(seen.size());
    clip_.fewest = index == 0 ? count : std::min(clip_.fewest, count);
    clip_.most = std::max(clip_.most, count);
  }

  CrowdClip finish() {
    if (clip_.most == 0) fail("nobody is seen in any frame", "point the camera at the crowd");
    const auto middle = heights_.begin() + static_cast<ptrdiff_t>(heights_.size() / 2);
    std::nth_element(heights_.begin(), middle, heights_.end());
    clip_.median_px = *middle;
    return clip_;
  }

 private:
  [[noreturn]] void fail(const std::string& wrong, const std::string& advice) const {
    throw Error(request_.name, wrong, advice);
  }

  // Nobody who is seen before or after a step has jumped in it.
  void check_steps(size_t index, const scene::Frame& frame, const std::map<uint32_t, Rows>& seen) {
    std::map<uint32_t, glm::dvec3> places;
    for (const auto& agents : frame.agents)
      for (const scene::FrameAgent& agent : agents) places[agent.id] = frame.origin + glm::dvec3(agent.position);
    for (const auto& [id, place] : places) {
      const auto before = places_.find(id);
      if (before == places_.end() || (!seen.contains(id) && !seen_.contains(id))) continue;
      if (glm::length(place - before->second) > kFastest / request_.fps)
        fail(fmt::format("agent {} jumps in view at frame {}", id, index),
             "its way ends there and begins anew: use crowd.motion = \"lanes\", or a shorter clip");
    }
    places_ = std::move(places);
    seen_ = seen;
  }

  const CrowdClipRequest& request_;
  const scene::Cast& cast_;
  CrowdClip clip_;
  std::vector<int> heights_;
  std::map<uint32_t, glm::dvec3> places_;
  std::map<uint32_t, Rows> seen_;
};

}  // namespace

uint64_t ticks_per_frame(const scene::Scenario& scenario, int fps, const std::string& where) {
  const double ticks = scenario.tick_rate / fps;
  if (ticks < 1 || ticks != std::floor(ticks))
    throw Error(where, fmt::format("{} ticks a second do not divide into {} frames", scenario.tick_rate, fps),
                fmt::format("choose a rate that divides {}, or make the scenario's `tick_rate` a multiple of {}",
                            scenario.tick_rate, fps));
  return static_cast<uint64_t>(ticks);
}

Json crowd_clip_json(const CrowdClip& clip) {
  return {{"tallest_px", clip.tallest_px},    {"tallest_id", clip.tallest_id}, {"tallest_frame", clip.tallest_frame},
          {"median_px", clip.median_px},      {"fewest_figures", clip.fewest}, {"most_figures", clip.most},
          {"frame_sha256", clip.frame_sha256}};
}

CrowdClip draw_crowd_clip(gl::Context& context, const scene::Cast& cast, const CrowdClipRequest& request,
                          const std::filesystem::path& target) {
  const scene::Scenario& scenario = request.scenario;
  const uint64_t ticks = ticks_per_frame(scenario, request.fps, request.name);
  const auto lead = static_cast<uint64_t>(std::llround(request.lead_in_seconds * request.fps)) * ticks;
  const scene::Crowd crowd = scene::make_crowd(scenario, cast, scene::stage_view(scenario));
  const auto frame_at = [&](uint64_t tick) {
    const double since = (static_cast<double>(tick) - static_cast<double>(lead)) / scenario.tick_rate;
    return scene::make_frame(scenario, cast, crowd, scenario.camera.at(std::max(0.0, since)), tick);
  };
  renderers::Renderer renderer(context, cast);
  const auto representation = renderers::make_representation({context, cast}, request.spec);
  Progress progress("drawing " + request.name, request.frames);
  if (representation->has_history())
    for (uint64_t tick = 0; tick < lead; tick += ticks) {
      const scene::Frame frame = frame_at(tick);
      representation->advance(frame, renderers::all_agents(frame));
      throw_if_interrupted();
    }
  LosslessWriter writer(target, scenario.width, scenario.height, request.fps);
  FrameChecks checks(request, cast);
  for (size_t f = 0; f < request.frames; ++f) {
    const scene::Frame frame = frame_at(lead + f * ticks);
    const renderers::Capture capture = renderer.capture(frame, *representation);
    checks.take(f, frame, capture.ids);
    writer.add(capture.colour);
    progress.advance();
  }
  CrowdClip clip = checks.finish();
  clip.bake_seconds = representation->bake_info().seconds;
  clip.frame_sha256 = writer.finish();
  return clip;
}

}  // namespace crowdbench::studies
