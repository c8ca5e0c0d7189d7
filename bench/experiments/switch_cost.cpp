#include "bench/experiments/switch_cost.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <memory>
#include <numbers>

#include "bench/timing/timing_method.h"
#include "core/progress.h"
#include "core/random.h"
#include "renderers/frame/capture.h"

namespace crowdbench::bench {
namespace {

enum Purpose : uint64_t { kAcross = 1, kUpright, kHeading, kPhase };
constexpr size_t kMostAgents = 2000;
constexpr double kCovered = 0.35;  // of the picture, by agents half as wide as they are tall
constexpr uint64_t kPlaces = 7;    // seed of places, headings and phases

size_t agents_for(const SwitchCostRequest& request, double height_px) {
  const double pixels = kCovered * request.width * request.height / (0.5 * height_px * height_px);
  return std::clamp<size_t>(static_cast<size_t>(pixels), 4, kMostAgents);
}

// All at one depth before a camera at the origin that looks along -Z; what is drawn of them lies within the picture but
// for what sticks out at its edge.
scene::Frame crowd_of_height(const SwitchCostRequest& request, const scene::Cast& cast, double height_px,
                             size_t count) {
  const double height = std::max(cast.characters[0]->placement.height, 1e-3);
  const double slope = 2 * std::tan(request.fov_y / 2);
  const double depth = height * request.height / (height_px * slope);
  const double tall = depth * slope;
  const double wide = tall * request.width / request.height;
  scene::Frame frame;
  frame.camera.eye = {0, 0, 0};
  frame.camera.target = {0, 0, -1};
  frame.camera.fov_y = request.fov_y;
  frame.camera.near = std::min(0.1, depth / 100);
  frame.origin = frame.camera.eye;
  frame.width = request.width;
  frame.height = request.height;
  frame.antialiasing = request.antialiasing;
  frame.outfits.resize(1);
  for (glm::vec4& colour : frame.outfits[0].colours) colour = glm::vec4(1.0F);
  frame.agents.resize(1);
  for (size_t i = 0; i < count; ++i) {
    scene::FrameAgent agent;
    const double x = (random_unit(kPlaces, i, kAcross) - 0.5) * std::max(wide - 0.5 * height, 0.0);
    const double y = (random_unit(kPlaces, i, kUpright) - 0.5) * std::max(tall - height, 0.0) - height / 2;
    const double heading = 2 * std::numbers::pi * random_unit(kPlaces, i, kHeading);
    agent.position = glm::vec3(glm::dvec3(x, y, -depth));
    agent.heading = {static_cast<float>(std::sin(heading)), static_cast<float>(std::cos(heading))};
    agent.id = static_cast<uint32_t>(i + 1);
    frame.agents[0].push_back(agent);
  }
  return frame;
}

// A walk of one phase step a tick, each agent from a phase of its own.
void pose(scene::Frame& frame, const scene::PoseBank& bank, uint64_t tick) {
  frame.tick = tick;
  for (size_t i = 0; i < frame.agents[0].size(); ++i) {
    scene::FrameAgent& agent = frame.agents[0][i];
    const double phase = random_unit(kPlaces, i, kPhase) + 0.03 * static_cast<double>(tick % 1000);
    agent.phase = static_cast<float>(phase - std::floor(phase));
    agent.pose = bank.sample(0, agent.phase);
  }
}

struct Drawn {
  renderers::Renderer renderer;
  renderers::Target target;
  std::vector<std::unique_ptr<renderers::Representation>> representations;
  scene::Frame full, quarter;
};

AgentCost cost_of(std::span<const SampleRow> full, std::span<const SampleRow> quarter, Metric metric, size_t agents,
                  size_t fewer) {
  const std::vector<double> whole = values_of(full, metric);
  const std::vector<double> less = values_of(quarter, metric);
  assert(!whole.empty() && whole.size() == less.size());
  std::vector<double> each;
  for (size_t i = 0; i < whole.size(); ++i) each.push_back((whole[i] - less[i]) / static_cast<double>(agents - fewer));
  AgentCost cost{median(each), bootstrap_median(each, kBootstrapSeed), true, each};
  if (cost.ns > 0) return cost;
  cost.resolved = false;
  cost.ns = median(whole) / static_cast<double>(agents);
  return cost;
}

// Variants of one height: each representation with all agents, then with a quarter of them.
std::vector<Variant> variants_of(Drawn& drawn, const SwitchCostRequest& request, const scene::PoseBank& bank) {
  std::vector<Variant> variants;
  for (size_t r = 0; r < drawn.representations.size(); ++r) {
    for (scene::Frame* frame : {&drawn.full, &drawn.quarter}) {
      variants.push_back({request.representations[r].text(),
                          [frame, &bank](uint64_t tick) { pose(*frame, bank, tick); },
                          [frame, &drawn, r] {
                            drawn.renderer.draw(*frame, *drawn.representations[r], drawn.target);
                            drawn.renderer.finish();
                          }});
    }
  }
  return variants;
}

}  // namespace

SwitchCosts measure_switch_costs(gl::Context& context, const scene::Cast& cast, const SwitchCostRequest& request) {
  assert(cast.characters.size() == 1);
  const TimingMethod method = choose_timing_method(context);
  const std::optional<GpuTimer> gpu = gpu_timer_of(context, method);
  const int samples = request.antialiasing.supersample;
  Drawn drawn{renderers::Renderer(context, cast),
              renderers::Target(context, request.width * samples, request.height * samples,
                                renderers::Pass{.samples = request.antialiasing.samples}),
              {},
              {},
              {}};
  for (const renderers::Spec& spec : request.representations) {
    renderers::MakeContext make{.context = context, .cast = cast};
    make.bake_budget = request.bake_budget;
    make.use_cache = request.use_cache;
    drawn.representations.push_back(renderers::make_representation(make, spec));
  }
  SwitchCosts out;
  out.clock = metric_name(method.headline);
  out.costs.resize(request.representations.size());
  out.frame_ns.resize(request.representations.size());
  TimingPlan plan;
  plan.rounds = plan.least_rounds = request.rounds;
  plan.metric = method.headline;
  plan.order_seed = request.order_seed;
  Progress progress("timing heights", request.heights_px.size());
  for (const double height_px : request.heights_px) {
    const size_t agents = agents_for(request, height_px);
    const size_t fewer = agents / 4;
    drawn.full = crowd_of_height(request, cast, height_px, agents);
    drawn.quarter = crowd_of_height(request, cast, height_px, fewer);
    const std::vector<VariantTimes> times = time_interleaved(variants_of(drawn, request, *cast.banks[0]), plan,
                                                             system_clocks(), gpu, [] { throw_if_interrupted(); });
    out.agents.push_back(agents);
    for (size_t r = 0; r < request.representations.size(); ++r) {
      out.costs[r].push_back(cost_of(times[2 * r].samples, times[2 * r + 1].samples, method.headline, agents, fewer));
      out.frame_ns[r].push_back(median(values_of(times[2 * r].samples, method.headline)));
    }
    progress.advance();
  }
  progress.end();
  return out;
}

std::vector<double> costs_at(const std::vector<double>& heights_px, const std::vector<AgentCost>& costs,
                             const std::vector<double>& wanted) {
  assert(!heights_px.empty() && heights_px.size() == costs.size());
  std::vector<double> out;
  for (const double height : wanted) {
    size_t far = 0;  // the first measured height that is not above it
    while (far < heights_px.size() && heights_px[far] > height) ++far;
    if (far == 0 || far == heights_px.size()) {
      out.push_back(costs[far == 0 ? 0 : far - 1].ns);
      continue;
    }
    const double t = std::log(heights_px[far - 1] / height) / std::log(heights_px[far - 1] / heights_px[far]);
    out.push_back(std::exp((1 - t) * std::log(costs[far - 1].ns) + t * std::log(costs[far].ns)));
  }
  return out;
}

}  // namespace crowdbench::bench
