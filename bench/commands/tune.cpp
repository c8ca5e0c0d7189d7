#include "bench/experiments/tune.h"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <cmath>

#include "bench/commands/command_line.h"
#include "bench/commands/options.h"
#include "bench/commands/scene_options.h"
#include "bench/commands/score_bounds.h"
#include "bench/commands/score_commands.h"
#include "bench/commands/tune_output.h"
#include "bench/stage/low_polygon.h"
#include "bench/stage/stage.h"
#include "core/error.h"
#include "core/progress.h"
#include "scene/cast/cast.h"
#include "scene/pose/normalise.h"

namespace crowdbench::bench {
namespace {

struct Options {
  SceneOptions scene;
  std::vector<std::string> representations;
  std::string clip;
  std::string error, pop;
  std::string azimuths = "0:300:60", elevations = "0,20";
  double nearest_px = 0, farthest_px = 8;
  uint64_t heights = 12;
  uint64_t moments = 2, fade = 0, rounds = 20;
  uint64_t bake_budget_mib = kDefaultBakeBudgetMiB;
  bool no_cache = false;
  bool json = false;
};

// "ssim=0.98": of the score that the table has a threshold of.
std::string default_threshold(metrics::ScoreTable table) {
  const metrics::Score* score = metrics::score_of_threshold(table);
  assert(score != nullptr);
  return fmt::format("{}={:g}", score->name, *score->threshold);
}

// All representations that stand alone and the level of detail that every figure of speed is told against; the
// reference first, asked for or not.
std::vector<renderers::Spec> candidates_of(const Options& options) {
  std::vector<renderers::Spec> wanted = parse_representations(options.representations);
  if (wanted.empty()) {
    for (const renderers::RepresentationType& type : renderers::representation_types())
      if (renderers::stands_alone(type)) wanted.push_back(renderers::parse_spec(type.name));
    wanted.push_back(low_polygon_spec());
  }
  std::vector<renderers::Spec> out{renderers::reference_spec()};
  for (const renderers::Spec& spec : wanted) {
    if (renderers::is_floor(spec)) throw Error("--representation", spec.text() + " is a floor", "leave floor=1 out");
    const bool known = std::any_of(out.begin(), out.end(), [&](const auto& one) { return one.text() == spec.text(); });
    if (!known) out.push_back(spec);
  }
  if (out.size() < 2)
    throw Error("--representation", "only the reference is left to choose from",
                "name another, or leave the option out");
  return out;
}

// Even in log height, from the tallest.
std::vector<double> heights_of(const Options& options, int rows) {
  const double nearest = options.nearest_px > 0 ? options.nearest_px : rows;
  if (options.farthest_px >= nearest)
    throw Error("--farthest-px",
                fmt::format("{:g} is not below the nearest height, {:g}", options.farthest_px, nearest),
                "choose less, or more with --nearest-px");
  std::vector<double> out;
  for (uint64_t i = 0; i < options.heights; ++i)
    out.push_back(nearest * std::pow(options.farthest_px / nearest,
                                     static_cast<double>(i) / static_cast<double>(options.heights - 1)));
  return out;
}

// Agents of the scenario's first frame at each height, each at the next one below its own; those beyond the camera's
// edges cost nothing and are left out.
std::vector<double> agents_by_height(Stage& stage, const std::vector<double>& heights) {
  const scene::Frame& frame = stage.frame(0);
  const glm::dmat3 turn = scene::view_rotation(frame.camera);
  const double slope = std::tan(frame.camera.fov_y / 2);
  const double aspect = static_cast<double>(frame.width) / frame.height;
  std::vector<double> out(heights.size(), 0);
  for (const scene::FrameAgent& agent : frame.agents[0]) {
    const double height = stage.cast().characters[0]->placement.height * agent.scale;
    const glm::dvec3 seen = turn * (glm::dvec3(agent.position) + glm::dvec3(0, height / 2, 0));
    const double depth = -seen.z;
    if (depth < frame.camera.near || std::abs(seen.y) > depth * slope + height / 2 ||
        std::abs(seen.x) > depth * slope * aspect + height / 2)
      continue;
    const double rows = height / scene::pixel_size_at(frame.camera, depth, frame.height);
    size_t bin = 0;
    while (bin + 1 < heights.size() && heights[bin] > rows) ++bin;
    out[bin] += 1;
  }
  return out;
}

TuneRequest read_request(const Options& options, metrics::ScoreTable table, const ChosenScenario& chosen) {
  TuneRequest request;
  request.candidates = candidates_of(options);
  const auto threshold = [&](const std::string& text, const char* option) {
    const ScoreValue value = parse_score_value(text, option, table);
    if (!value.score->compute || (value.score->needs & metrics::kNeedsLinear))
      throw Error(option, fmt::format("{} is not of two pictures", value.score->name),
                  "`crowdbench schema --scores` says what each score needs");
    return TuneThreshold{value.score, value.value};
  };
  request.error = threshold(options.error, "--threshold");
  request.pop = options.pop.empty() ? request.error : threshold(options.pop, "--pop-threshold");
  request.azimuths_deg = parse_numbers(options.azimuths, "--azimuth-deg", -360, 360);
  request.elevations_deg = parse_numbers(options.elevations, "--elevation-deg", -90, 90);
  request.moments = static_cast<size_t>(options.moments);
  request.fade = static_cast<int>(options.fade);
  request.heights_px = heights_of(options, chosen.scenario.height);
  request.display = chosen.display;
  request.seed = chosen.scenario.seed;
  request.cost.width = chosen.scenario.width;
  request.cost.height = chosen.scenario.height;
  request.cost.antialiasing = chosen.scenario.antialiasing;
  request.cost.rounds = static_cast<int>(options.rounds);
  request.cost.bake_budget = options.bake_budget_mib << 20;
  request.cost.use_cache = !options.no_cache;
  return request;
}

// Where a texel of the representation spans a pixel, as it is derived; nothing without texels.
std::optional<double> predicted_height(gl::Context& context, const TuneRequest& request, const renderers::Spec& spec) {
  SwitchRequest one;
  one.character = request.character;
  one.representation = spec;
  one.ratios = {1};
  one.width = request.cost.width;
  one.height = request.cost.height;
  one.fov_y_deg = glm::degrees(request.cost.fov_y);
  one.clip = request.clip;
  one.bake_budget = request.cost.bake_budget;
  one.use_cache = request.cost.use_cache;
  try {
    return measure_switch_distance(context, one).rows[0].height_px;
  } catch (const Error&) {
    return std::nullopt;
  }
}

int run_tune(const Options& options, metrics::ScoreTable table) {
  const ChosenScenario chosen = read_scenario(options.scene);
  TuneReport report;
  report.request = read_request(options, table, chosen);
  {
    Progress progress("tune", 0);
    progress.note("loading the characters");
    const scene::Cast cast = open_cast(chosen.scenario, chosen.folder, chosen.places);
    if (cast.characters.size() != 1)
      throw Error("tune", fmt::format("the scenario has {} characters", cast.characters.size()),
                  "switches are tuned for one: name it with --character");
    report.request.character = cast.characters[0];
    report.request.clip = options.clip.empty() ? cast.characters[0]->placement.default_clip
                                               : scene::require_clip_or_none(*cast.characters[0], options.clip);
    const scene::PoseBank bank(*cast.characters[0], {report.request.clip}, 30);
    report.bounds = glm::dvec3(bank.bounds_max() - bank.bounds_min());
    const auto context = open_context(options.scene.device);
    progress.note(fmt::format("placing {} agents", chosen.scenario.crowd.agents));
    const Staged staged = stage_scenario(chosen.scenario, cast, *context);
    report.request.cost.fov_y = staged.camera.fov_y;
    report.renderer = context->renderer();
    Stage stage(*context, cast);
    stage.show(staged);
    report.request.agents = agents_by_height(stage, report.request.heights_px);
    progress.note("");
    report.result = tune(*context, report.request);
    for (const TuneSwitch& change : report.result.switches)
      report.predicted_px.push_back(
          predicted_height(*context, report.request, report.request.candidates[change.change.to]));
  }
  if (options.json)
    fmt::print("{}\n", tune_json(report).dump(2));
  else
    print_tune(report);
  return report.result.plan ? 0 : 1;
}

void add_view_options(Command& command, Options& options) {
  command.add_option("--azimuth-deg", options.azimuths, "from where it is looked at; 0 = from the front")
      ->type_name("LIST")
      ->capture_default_str();
  command.add_option("--elevation-deg", options.elevations, "positive = from above")
      ->type_name("LIST")
      ->capture_default_str();
  const auto add_count = [&](const char* name, uint64_t& value, uint64_t least, uint64_t most, const char* text) {
    command.add_option(name, value, text)->type_name("N")->capture_default_str()->whole_number(least, most);
  };
  add_count("--moments", options.moments, 1, 100, "of the clip, evenly");
  add_count("--heights", options.heights, 2, 100, "how many, evenly in their logarithm");
  command.add_option("--nearest-px", options.nearest_px, "the tallest height in pixels; 0: the picture's")
      ->type_name("PX")
      ->capture_default_str()
      ->number(0, 4096);
  command.add_option("--farthest-px", options.farthest_px, "the smallest")
      ->type_name("PX")
      ->capture_default_str()
      ->number(2, 4096);
  add_count("--fade", options.fade, 0, 60, "judge a pop by the worst step of a cross-fade of so many ticks; 0: a cut");
  add_count("--rounds", options.rounds, 4, 1000, "in which costs are measured");
}

}  // namespace

void add_tune(Command& app, Run& run) {
  Command* command =
      app.add_subcommand("tune", "Which representation from which distance on, for the least time, without being seen");
  command->footer(
      "The character is drawn at heights from near to far, from several directions and moments, by every candidate, "
      "and\n"
      "scored against the reference: a candidate is allowed where the bad end's 5 % keeps the threshold at the bad end "
      "of\n"
      "its bootstrap interval. A change from one to another must keep the pop threshold where it happens. Of all that "
      "is\n"
      "allowed the cheapest is taken, for the scenario's agents and camera. Exit status 1: nothing is allowed "
      "somewhere.\n\n"
      "Examples:\n"
      "  crowdbench tune --representation flat,relief\n"
      "  crowdbench tune street.toml --character knight.glb --threshold ssim=0.9 --pop-threshold ssim=0.8 --fade 8 "
      "--json");
  auto options = std::make_shared<Options>();
  options->error = default_threshold(metrics::scores());
  add_scene_options(*command, options->scene);
  add_representation_option(
      *command, options->representations,
      "candidates beside the reference; without it all that there are, and a mesh of 500 triangles");
  add_clip_option(*command, options->clip);
  command->add_option("--threshold", options->error, "a score of the picture, and how good it must be")
      ->type_name("SCORE=VALUE")
      ->capture_default_str();
  command->add_option("--pop-threshold", options->pop, "the same for a switch; without it as --threshold")
      ->type_name("SCORE=VALUE");
  add_view_options(*command, *options);
  add_display_option(*command, options->scene.display);
  add_bake_options(*command, options->bake_budget_mib, &options->no_cache);
  add_json_option(*command, options->json);
  command->callback([options, &run] { run = [options] { return run_tune(*options, metrics::scores()); }; });
}

}  // namespace crowdbench::bench
