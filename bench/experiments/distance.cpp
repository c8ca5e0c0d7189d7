#include "bench/experiments/distance.h"

#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <utility>

#include "bench/experiments/cause_chain.h"
#include "bench/experiments/score_rows.h"
#include "core/error.h"
#include "core/progress.h"
#include "metrics/agents.h"
#include "reports/model/distance_series.h"
#include "scene/crowd/crowd.h"

namespace crowdbench::bench {
namespace {

using renderers::Capture;

// The frames of a scenario, and a representation that has seen all ticks before the one it draws.
class Drawn {
 public:
  Drawn(const renderers::MakeContext& make, const renderers::Spec& spec)
      : representation_(renderers::make_representation(make, spec)) {}

  Capture capture(renderers::Renderer& renderer, const std::function<scene::Frame(uint64_t)>& frame_at,
                  const scene::Frame& frame, const renderers::CaptureOptions& options) {
    if (representation_->has_history()) {
      Progress progress("playing the ticks before", static_cast<size_t>(frame.tick - next_));
      for (; next_ < frame.tick; ++next_) {
        const scene::Frame before = frame_at(next_);
        representation_->advance(before, renderers::all_agents(before));
        progress.advance();
      }
    }
    next_ = frame.tick + 1;
    return renderer.capture(frame, *representation_, options);
  }
  renderers::Representation& representation() { return *representation_; }

 private:
  std::unique_ptr<renderers::Representation> representation_;
  uint64_t next_ = 0;
};

metrics::Needs needs_of(const std::vector<const metrics::Score*>& scores) {
  metrics::Needs needs = 0;
  for (const metrics::Score* score : scores) needs |= score->needs;
  return needs;
}

std::optional<double> x_of(const DistanceResult& result, const AgentView& view, size_t representation,
                           Against against) {
  switch (against) {
    case Against::distance: return view.distance;
    case Against::height: return view.height_px;
    case Against::texel: return pixels_per_texel(result, view, representation);
  }
  return std::nullopt;
}

}  // namespace

std::vector<const metrics::Score*> agent_scores(metrics::ScoreTable table, bool linear) {
  metrics::Needs offered =
      metrics::kNeedsCodes | metrics::kNeedsIds | metrics::kNeedsDepth | metrics::kNeedsRegion | metrics::kNeedsDisplay;
  if (linear) offered |= metrics::kNeedsLinear;
  std::vector<const metrics::Score*> out;
  for (const metrics::Score* score : table)
    if (score->by_agent && (score->needs & ~offered) == 0) out.push_back(score);
  return out;
}

std::vector<AgentValues> score_views(const std::vector<AgentView>& views, const DistanceRequest& request,
                                     const Capture& reference, const Capture& test) {
  metrics::ScoreInput input{buffers_of(reference), buffers_of(test)};
  metrics::look_at(request.display, input);
  metrics::Shared shared;
  const metrics::AgentScores scored = metrics::score_agents(request.scores, input, shared);
  std::vector<AgentValues> out;
  for (const AgentView& view : views) {
    AgentValues& values = out.emplace_back(request.scores.size());
    const auto row = std::lower_bound(scored.agents.begin(), scored.agents.end(), view.id,
                                      [](const metrics::AgentRow& r, uint32_t id) { return r.id < id; });
    if (row == scored.agents.end() || row->id != view.id) continue;
    for (size_t s = 0; s < scored.scores.size(); ++s) {
      const auto place = std::find(request.scores.begin(), request.scores.end(), scored.scores[s]);
      values[static_cast<size_t>(place - request.scores.begin())] = row->values[s];
    }
  }
  return out;
}

namespace {

double tallest(const scene::Cast& cast) {
  double height = 0;
  for (size_t c = 0; c < cast.characters.size(); ++c) {
    const double own = cast.characters[c]->placement.height;
    const scene::PoseBank& bank = *cast.banks[c];
    height = std::max(height, own > 0 ? own : static_cast<double>(bank.bounds_max().y - bank.bounds_min().y));
  }
  return height;
}

// right: the reference's picture without supersampling.
metrics::CauseErrors causes_in_frame(const Drawer& mesh, const Drawer& test, const scene::Frame& frame,
                                     const Capture& right, const StoredWhat& stored) {
  scene::Frame posed = frame;
  if (!stored.of_several) show_stored_frames(posed, test.cast, test.representation);
  return draw_causes({right, posed, frame, tallest(test.cast)}, mesh, test, stored).errors;
}

}  // namespace

DistanceResult measure_distance(gl::Context& context, const scene::Cast& cast, const Staged& staged,
                                const DistanceRequest& request) {
  const scene::Scenario& scenario = staged.scenario;
  const std::function<scene::Frame(uint64_t)> frame_at = [&](uint64_t tick) {
    const double seconds = static_cast<double>(tick) / scenario.tick_rate;
    return scene::make_frame(scenario, cast, staged.crowd, scenario.camera.at(seconds), tick);
  };
  if (request.causes && !renderers::representation_type(request.reference.name).reference)
    throw Error("--causes", fmt::format("'{}' is not what shows every surface", request.reference.text()),
                "leave --reference out");
  renderers::MakeContext make{.context = context, .cast = cast};
  make.bake_budget = request.bake_budget;
  make.use_cache = request.use_cache;
  const size_t count = request.representations.size();
  Progress progress("distance", static_cast<size_t>(request.frames) * (count + 1));
  progress.note("making " + request.reference.text());
  Drawn reference(make, request.reference);
  std::vector<Drawn> tests;
  std::vector<StoredWhat> stored;
  DistanceResult result;
  for (const renderers::Spec& spec : request.representations) {
    progress.note("making " + spec.text());
    tests.emplace_back(make, spec);
    if (request.causes) stored.push_back(stored_by(spec, cast));
    std::vector<double>& texels = result.texels.emplace_back();
    for (size_t c = 0; c < cast.characters.size(); ++c) texels.push_back(tests.back().representation().texel_metres(c));
  }
  renderers::Renderer renderer(context, cast);
  const bool linear = (needs_of(request.scores) & metrics::kNeedsLinear) != 0;
  const renderers::CaptureOptions options{.linear = linear};
  for (uint64_t f = 0; f < request.frames; ++f) {
    const scene::Frame frame = frame_at(request.tick + f * request.step);
    progress.note(fmt::format("tick {}, {}", frame.tick, request.reference.text()));
    const Capture right = reference.capture(renderer, frame_at, frame, options);
    const std::vector<AgentView> views =
        view_agents(context, renderer, reference.representation(), frame, cast, right.ids, request.least_visible);
    progress.advance();
    const size_t first = result.agents.size();
    for (const AgentView& view : views) result.agents.push_back({view, {}});
    for (size_t r = 0; r < count; ++r) {
      progress.note(fmt::format("tick {}, {}", frame.tick, request.representations[r].text()));
      const Capture test = tests[r].capture(renderer, frame_at, frame, options);
      std::vector<AgentValues> values = score_views(views, request, right, test);
      for (size_t i = 0; i < values.size(); ++i) result.agents[first + i].values.push_back(std::move(values[i]));
      if (request.causes) {
        const Drawer mesh{context, cast, renderer, reference.representation()};
        const Drawer drawer{context, cast, renderer, tests[r].representation()};
        scene::Frame sharp = frame;  // causes are told apart by what one sample a pixel shows
        sharp.antialiasing = {};
        const bool same = frame.antialiasing == sharp.antialiasing;
        std::optional<Capture> anew;
        const Capture& plain = same ? right : anew.emplace(renderer.capture(sharp, mesh.representation));
        result.causes.push_back({r, frame.tick, causes_in_frame(mesh, drawer, sharp, plain, stored[r])});
      }
      progress.advance();
    }
  }
  return result;
}

std::vector<CauseRange> distance_causes(const DistanceResult& result, size_t representation, uint64_t seed) {
  std::vector<CauseUnit> units;
  for (const DistanceCauses& frame : result.causes) {
    if (frame.representation != representation) continue;
    for (const DistanceAgent& agent : result.agents)
      if (agent.view.tick == frame.tick && agent.view.state == AgentState::counted)
        if (const metrics::CauseRow* row = frame.errors.agent(agent.view.id))
          units.push_back({agent.view.height_px, agent.view.id, *row});
  }
  return causes_by_height(units, seed);
}

std::optional<double> pixels_per_texel(const DistanceResult& result, const AgentView& view, size_t representation) {
  const double texel = result.texels[representation][view.character];
  if (!(texel > 0) || !(view.pixels_per_metre > 0)) return std::nullopt;
  return texel * view.scale * view.pixels_per_metre;
}

const std::vector<AgainstText>& all_against() {
  static const std::vector<AgainstText> all = [] {
    std::vector<AgainstText> texts;
    for (const reports::DistanceAxis& axis : reports::distance_axes())
      texts.push_back({static_cast<Against>(texts.size()), axis.name, axis.title, axis.unit});
    return texts;
  }();
  return all;
}

std::vector<DistanceCurve> distance_curves(const DistanceResult& result, const DistanceRequest& request, size_t bins,
                                           uint64_t seed, const std::vector<DistanceThreshold>& thresholds) {
  std::vector<DistanceCurve> out;
  for (size_t r = 0; r < request.representations.size(); ++r)
    for (size_t s = 0; s < request.scores.size(); ++s)
      for (const AgainstText& text : all_against()) {
        throw_if_interrupted();
        std::vector<CurvePoint> points;
        for (const DistanceAgent& agent : result.agents) {
          if (agent.view.state != AgentState::counted || !agent.values[r][s]) continue;
          if (const std::optional<double> x = x_of(result, agent.view, r, text.against))
            points.push_back({agent.view.id, *x, *agent.values[r][s]});
        }
        if (points.empty()) continue;
        DistanceCurve& curve = out.emplace_back();
        curve.representation = r;
        curve.score = s;
        curve.against = text.against;
        curve.curve = make_curve(std::move(points), bins, seed, text.against != Against::distance);
        for (const DistanceThreshold& threshold : thresholds)
          if (threshold.score == request.scores[s])
            curve.thresholds.emplace_back(threshold.value,
                                          threshold_place(curve.curve, *threshold.score, threshold.value));
      }
  return out;
}

}  // namespace crowdbench::bench
