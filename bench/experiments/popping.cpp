#include "bench/experiments/popping.h"

#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <tuple>
#include <unordered_map>
#include <utility>

#include "bench/experiments/agent_views.h"
#include "core/error.h"
#include "core/progress.h"
#include "core/statistics.h"
#include "renderers/frame/capture.h"
#include "scene/crowd/crowd.h"

namespace crowdbench::bench {
namespace {

using renderers::AgentShares;
using renderers::Capture;
using Shares = std::vector<float>;

// An agent whose shares differ from the frame before.
struct Step {
  size_t place = 0;  // in the frame's shares
  size_t character = 0;
  const scene::FrameAgent* agent = nullptr;
  Shares before;
};

bool is_fading(const Shares& shares) {
  return std::count_if(shares.begin(), shares.end(), [](float s) { return s > 0; }) > 1;
}

// The component whose share grows most from a to b.
size_t growing(const Shares& a, const Shares& b) {
  size_t most = 0;
  for (size_t k = 1; k < a.size(); ++k)
    if (b[k] - a[k] > b[most] - a[most]) most = k;
  return most;
}

Image8 picture_of(const Image8& rgba, const metrics::Box& box) {
  Image8 out(box.width, box.height, 3);
  for (int y = 0; y < box.height; ++y)
    for (int x = 0; x < box.width; ++x) std::copy_n(rgba.at(box.x + x, box.y + y), 3, out.at(x, y));
  return out;
}

class Measurement {
 public:
  Measurement(gl::Context& context, const scene::Cast& cast, const Staged& staged, const PoppingRequest& request)
      : cast_(cast), staged_(staged), request_(request), renderer_(context, cast) {
    renderers::MakeContext make{.context = context, .cast = cast};
    make.bake_budget = request.bake_budget;
    make.use_cache = request.use_cache;
    representation_ = renderers::make_representation(make, request.representation);
    result_.components = representation_->components();
    if (result_.components.empty())
      throw Error(fmt::format("representation '{}'", request.representation.text()), "its agents never switch",
                  "give one that is made of others, " + example());
  }

  void play_to_first() {
    if (!representation_->has_history()) return;
    Progress progress("playing the ticks before", static_cast<size_t>(request_.tick));
    for (uint64_t tick = 0; tick < request_.tick; ++tick) {
      const scene::Frame frame = frame_at(tick);
      representation_->advance(frame, renderers::all_agents(frame));
      progress.advance();
    }
  }

  void take(uint64_t tick) {
    const scene::Frame frame = frame_at(tick);
    Capture drawn = capture(frame);
    const renderers::AgentLists everybody = renderers::all_agents(frame);
    const std::vector<AgentShares> shares = representation_->shares(frame, everybody);
    result_.agents_in_view += shares.size();
    if (!last_.colour.empty()) {
      const std::vector<Step> steps = steps_of(frame, shares);
      for (const std::vector<size_t>& group : groups_of(frame, steps)) score(frame, drawn, shares, steps, group);
    }
    before_.clear();
    for (const AgentShares& agent : shares) before_[agent.id] = agent.shares;
    last_ = std::move(drawn);
  }

  PoppingResult finish() {
    const auto order = [](const Switch& s) {
      const std::optional<double> value = s.pixels > 0 ? s.values[0] : std::nullopt;
      return std::tuple(!value, visibility(value.value_or(0)), s.tick, s.id);
    };
    std::sort(result_.switches.begin(), result_.switches.end(),
              [&](const Switch& a, const Switch& b) { return order(a) < order(b); });
    return std::move(result_);
  }

 private:
  static std::string example() {
    for (const renderers::RepresentationType& type : renderers::representation_types())
      if (type.components > 0) return renderers::example_spec(type);
    return "";
  }

  // Lower is more visible.
  static double visibility(double value) {
    return metrics::pop_scores()[0].direction == metrics::Direction::higher_is_better ? value : -value;
  }

  scene::Frame frame_at(uint64_t tick) const {
    const scene::Scenario& scenario = staged_.scenario;
    const double seconds = static_cast<double>(tick) / scenario.tick_rate;
    return scene::make_frame(scenario, cast_, staged_.crowd, scenario.camera.at(seconds), tick);
  }

  Capture capture(const scene::Frame& frame) {
    ++result_.drawings;
    return renderer_.capture(frame, *representation_);
  }

  std::vector<Step> steps_of(const scene::Frame& frame, const std::vector<AgentShares>& shares) const {
    std::vector<Step> steps;
    size_t place = 0;
    for (size_t c = 0; c < frame.agents.size(); ++c)
      for (const scene::FrameAgent& agent : frame.agents[c]) {
        const auto before = before_.find(agent.id);
        // A fade without its first step began before the sequence.
        if (before != before_.end() && before->second != shares[place].shares &&
            (!is_fading(before->second) || goes_on(agent.id, frame.tick)))
          steps.push_back({place, c, &agent, before->second});
        ++place;
      }
    return steps;
  }

  // Agents whose boxes do not touch each other's pixels.
  std::vector<std::vector<size_t>> groups_of(const scene::Frame& frame, const std::vector<Step>& steps) const {
    constexpr int kBeyondBounds = 2;  // pixels: an impostor may reach as far beyond the mesh's bounds
    const int apart = (metrics::pop_margin(request_.view) + 1) / 2 + kBeyondBounds;
    std::vector<PixelBox> boxes;
    for (const Step& step : steps) {
      PixelBox box = projected_bounds(frame, *step.agent, *cast_.banks[step.character]);
      box.left -= apart;
      box.top -= apart;
      box.right += apart;
      box.bottom += apart;
      boxes.push_back(box);
    }
    std::vector<std::vector<size_t>> groups = disjoint_groups(boxes);
    for (size_t i = 0; i < boxes.size(); ++i)
      if (!boxes[i].whole) groups.push_back({i});
    return groups;
  }

  void score(const scene::Frame& frame, const Capture& drawn, const std::vector<AgentShares>& shares,
             const std::vector<Step>& steps, const std::vector<size_t>& group) {
    std::vector<AgentShares> as_before = shares;
    for (const size_t i : group) as_before[steps[i].place].shares = steps[i].before;
    representation_->hold(as_before);
    const Capture held = capture(frame);
    representation_->hold({});
    const metrics::PopFrames frames{&last_.colour, &drawn.colour, &held.colour, &drawn.ids, &held.ids};
    for (const size_t i : group) {
      throw_if_interrupted();
      Switch& of = switch_of(frame.tick, steps[i], shares[steps[i].place].shares);
      const std::optional<metrics::Pop> pop = metrics::score_pop(frames, of.id, request_.view);
      if (!pop || !keep_worst(of, *pop, frame.tick) || request_.pictures == 0) continue;
      of.pictures = {pop->box, picture_of(last_.colour, pop->box), picture_of(drawn.colour, pop->box),
                     picture_of(held.colour, pop->box)};
      drop_pictures();
    }
  }

  // Whether the agent's latest switch reached to the frame before.
  bool goes_on(uint32_t id, uint64_t tick) const {
    const auto latest = latest_.find(id);
    return latest != latest_.end() &&
           result_.switches[latest->second].tick + result_.switches[latest->second].steps == tick;
  }

  // The one that this step begins or goes on with.
  Switch& switch_of(uint64_t tick, const Step& step, const Shares& now) {
    const uint32_t id = step.agent->id;
    if (!is_fading(step.before)) {
      Switch begun;
      begun.id = id;
      begun.character = step.character;
      begun.tick = begun.worst_tick = tick;
      begun.from = growing(now, step.before);
      begun.distance = static_cast<double>(glm::length(step.agent->position));
      begun.values.resize(metrics::pop_scores().size());
      latest_[id] = result_.switches.size();
      result_.switches.push_back(std::move(begun));
    } else {
      ++result_.switches[latest_[id]].steps;
    }
    Switch& of = result_.switches[latest_[id]];
    of.to = growing(step.before, now);
    of.complete = !is_fading(now);
    return of;
  }

  // Whether this step is the most visible so far.
  static bool keep_worst(Switch& of, const metrics::Pop& pop, uint64_t tick) {
    const std::span<const metrics::PopScore> scores = metrics::pop_scores();
    const bool worst = of.pixels == 0 ||
                       (pop.values[0] && of.values[0] && metrics::is_worse(scores[0], *pop.values[0], *of.values[0]));
    for (size_t s = 0; s < scores.size(); ++s)
      if (pop.values[s] && (!of.values[s] || metrics::is_worse(scores[s], *pop.values[s], *of.values[s])))
        of.values[s] = pop.values[s];
    if (worst) {
      of.pixels = pop.pixels;
      of.worst_tick = tick;
    }
    return worst;
  }

  // The least visible switch loses its pictures where there are more than asked for.
  void drop_pictures() {
    Switch* least = nullptr;
    size_t count = 0;
    for (Switch& s : result_.switches) {
      if (!s.pictures.kept()) continue;
      ++count;
      if (!least || visibility(s.values[0].value_or(0)) > visibility(least->values[0].value_or(0))) least = &s;
    }
    if (count > request_.pictures) least->pictures = {};
  }

  const scene::Cast& cast_;
  const Staged& staged_;
  const PoppingRequest& request_;
  renderers::Renderer renderer_;
  std::unique_ptr<renderers::Representation> representation_;
  PoppingResult result_;
  Capture last_;
  std::unordered_map<uint32_t, Shares> before_;  // by id, of the frame before
  std::unordered_map<uint32_t, size_t> latest_;  // by id: its latest switch
};

}  // namespace

PoppingResult measure_popping(gl::Context& context, const scene::Cast& cast, const Staged& staged,
                              const PoppingRequest& request) {
  Progress progress("popping", static_cast<size_t>(request.frames));
  progress.note("making " + request.representation.text());
  Measurement measurement(context, cast, staged, request);
  measurement.play_to_first();
  for (uint64_t f = 0; f < request.frames; ++f) {
    progress.note(fmt::format("tick {}", request.tick + f));
    measurement.take(request.tick + f);
    progress.advance();
  }
  return measurement.finish();
}

std::optional<PopQuantiles> pop_quantiles(const std::vector<Switch>& switches, size_t place) {
  std::vector<double> values;
  for (const Switch& s : switches)
    if (s.pixels > 0 && s.values[place]) values.push_back(*s.values[place]);
  if (values.empty()) return std::nullopt;
  const bool higher = metrics::pop_scores()[place].direction == metrics::Direction::higher_is_better;
  const auto [least, most] = std::minmax_element(values.begin(), values.end());
  return PopQuantiles{median(values), quantile(values, higher ? 0.05 : 0.95), higher ? *least : *most};
}

size_t seen_switches(const std::vector<Switch>& switches) {
  return static_cast<size_t>(
      std::count_if(switches.begin(), switches.end(), [](const Switch& s) { return s.pixels > 0; }));
}

}  // namespace crowdbench::bench
