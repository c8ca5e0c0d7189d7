#include "bench/experiments/popping.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <memory>
#include <optional>
#include <utility>
#include <variant>

#include "bench/commands/command_line.h"
#include "bench/commands/commands.h"
#include "bench/commands/options.h"
#include "bench/commands/popping_output.h"
#include "bench/commands/scene_options.h"
#include "bench/experiments/cause_rows.h"
#include "bench/experiments/frame_pairs.h"
#include "bench/stage/cast_name.h"
#include "bench/timing/run_facts.h"
#include "core/command_line.h"
#include "core/counted.h"
#include "core/error.h"
#include "core/progress.h"
#include "renderers/gl/context.h"
#include "scene/cast/cast.h"

namespace crowdbench::bench {
namespace {

struct PoppingOptions {
  SceneOptions scene;
  std::string representation;
  std::string sequence;
  std::string out;
  std::string results;
  std::vector<std::string> sweeps;
  uint64_t worst = 10;
  uint64_t rows = 20;
  uint64_t bake_budget_mib = kDefaultBakeBudgetMiB;
  bool no_cache = false;
  bool json = false;
  PoppingRequest request;
};

struct Sweep {
  std::string key;
  std::vector<std::string> values;
};

Sweep parse_sweep(const std::string& text) {
  const size_t equals = text.find('=');
  Sweep sweep{text.substr(0, equals), {}};
  std::string value;
  for (size_t at = equals; at != std::string::npos && at < text.size();) {
    const size_t end = text.find(',', at + 1);
    sweep.values.push_back(text.substr(at + 1, end == std::string::npos ? end : end - at - 1));
    at = end;
  }
  if (sweep.key.empty() || sweep.values.empty() ||
      std::any_of(sweep.values.begin(), sweep.values.end(), [](const std::string& v) { return v.empty(); }))
    throw Error("--sweep", fmt::format("'{}' is not an option with values", printable(text)),
                "write it as fade=0,4,8: an option of the representation and the values that it shall have");
  return sweep;
}

// The spec with the option set to the value, whatever it was; what makes the representation checks the value. Throws
// Error where it has none of that name.
renderers::Spec with_option(renderers::Spec spec, const std::string& key, const std::string& value) {
  std::vector<std::string> keys;
  for (const renderers::OptionDoc& doc : renderers::option_docs(renderers::representation_type(spec.name)))
    keys.push_back(doc.key);
  if (std::find(keys.begin(), keys.end(), key) == keys.end()) {
    const std::string near = nearest_name(key, keys);
    throw Error(
        "--sweep", fmt::format("'{}' has no option '{}'", spec.name, printable(key)),
        near.empty() ? fmt::format("it has {}", fmt::join(keys, ", ")) : fmt::format("did you mean '{}'?", near));
  }
  std::erase_if(spec.options, [&](const auto& option) { return option.first == key; });
  spec.options.emplace_back(key, value);
  return spec;
}

// Every combination, the last option changing fastest.
std::vector<PoppingRun> runs_of(const renderers::Spec& spec, const std::vector<std::string>& sweeps) {
  std::vector<PoppingRun> runs = {{spec, {}, {}}};
  for (const std::string& text : sweeps) {
    const Sweep sweep = parse_sweep(text);
    std::vector<PoppingRun> more;
    for (const PoppingRun& run : runs)
      for (const std::string& value : sweep.values) {
        more.push_back({with_option(run.representation, sweep.key, value), run.setting, {}});
        more.back().setting.emplace_back(sweep.key, value);
      }
    runs = std::move(more);
  }
  return runs;
}

void require_switches(const std::vector<PoppingRun>& runs) {
  for (const PoppingRun& run : runs)
    if (renderers::representation_type(run.representation.name).components == 0)
      throw Error("--representation", fmt::format("the agents of '{}' never switch", run.representation.text()),
                  "give one that is made of others; `crowdbench info --representations` has them");
}

void write_pops(StoreWriter& store, const PoppingReport& report, const RunRow& run) {
  store.begin();
  const int64_t id = store.write(run);
  for (const PoppingRun& one : report.runs)
    for (const PopRow& row :
         pop_rows(id, one.representation.text(), report.cast, metrics::display_text(report.display), one.result))
      store.write(row);
  store.commit();
}

int run_scenario(const PoppingOptions& options) {
  PoppingReport report;
  report.rows = options.rows;
  ChosenScenario chosen = read_scenario(options.scene);
  report.display = chosen.display;
  override_representation(chosen, options.representation);
  report.runs = runs_of(representation_of(chosen), options.sweeps);
  require_switches(report.runs);
  report.request = options.request;
  PoppingRequest& request = report.request;
  constexpr double kFastest = 1000;  // frames a second that ColorVideoVDP takes
  if (chosen.scenario.tick_rate > kFastest)
    throw Error("tick_rate", fmt::format("{:g} frames a second are more than are scored", chosen.scenario.tick_rate),
                fmt::format("give at most {:g}", kFastest));
  request.view = {&report.display.display, !report.display.given, chosen.scenario.tick_rate};
  std::optional<StoreWriter> store;
  if (!options.results.empty()) store.emplace(options.results);  // refused before anything is drawn
  request.pictures = options.out.empty() ? 0 : options.worst;
  request.bake_budget = options.bake_budget_mib << 20;
  request.use_cache = !options.no_cache;
  {
    Progress progress("popping", report.runs.size());
    progress.note("loading the characters");
    const scene::Cast cast = open_cast(chosen.scenario, chosen.folder, chosen.places);
    const auto context = open_context(options.scene.device);
    progress.note(fmt::format("placing {}", counted(chosen.scenario.crowd.agents, "agent", "agents")));
    const Staged staged = stage_scenario(chosen.scenario, cast, *context);
    report.scenario = staged.scenario;
    report.cast = cast_name(cast);
    report.renderer = context->renderer();
    for (PoppingRun& run : report.runs) {
      progress.note(run.representation.text());
      request.representation = run.representation;
      run.result = measure_popping(*context, cast, staged, request);
      progress.advance();
    }
    if (store)
      write_pops(*store, report,
                 describe_run(*context, choose_timing_method(*context), chosen.scenario, "popping", command_line()));
  }
  if (!options.out.empty()) report.pictures = write_pop_pictures(options.out, report);
  if (options.json)
    fmt::print("{}\n", popping_json(report).dump(2));
  else
    print_popping(report);
  return 0;
}

metrics::Plane luma_of(const AnyImage& image, const std::string& where) {
  if (const auto* codes = std::get_if<Image8>(&image)) return metrics::luma601(*codes);
  if (const auto* codes = std::get_if<Image16>(&image)) return metrics::luma601(*codes);
  throw Error(where, "its frames are floats, which have no code values", "give frames of 8 or 16 bits");
}

int run_sequence(const PoppingOptions& options) {
  const std::unique_ptr<FrameSequence> frames = open_sequence(options.sequence);
  JumpReport report;
  report.sequence = options.sequence;
  metrics::Discontinuities discontinuities;
  {
    Progress progress("looking for pops", frames->frames);
    AnyImage image;
    while (frames->next(image)) {
      discontinuities.take(luma_of(image, options.sequence));
      progress.advance();
    }
  }
  report.frames = discontinuities.frames();
  if (report.frames < 3)
    throw Error(options.sequence, fmt::format("has {} frames", report.frames), "name a sequence of three or more");
  report.jumps = discontinuities.finish();
  if (options.json)
    fmt::print("{}\n", jumps_json(report).dump(2));
  else
    print_jumps(report);
  return 0;
}

void add_frame_options(Command& command, PoppingRequest& request) {
  command.add_option("--tick", request.tick, "the first tick that is drawn (30 a second by default)")
      ->type_name("N")
      ->capture_default_str()
      ->whole_number(0, 1'000'000'000);
  command.add_option("--frames", request.frames, "frames that are drawn, one a tick")
      ->type_name("N")
      ->capture_default_str()
      ->whole_number(2, 100'000);
}

}  // namespace

void add_popping(Command& app, Run& run) {
  Command* command =
      app.add_subcommand("popping", "Every switch of an agent in a sequence of frames, by how visible it is");
  command->footer(
      "For each switch the frame in which it happens is drawn a second time with this agent left as it was the frame\n"
      "before. What differs is the switch alone, and is scored at the agent's own pixels; a cross-fade counts as its\n"
      "worst step. `crowdbench schema --scores` says what each score is. Two options crossed make a table.\n"
      "With --sequence nothing is drawn: in which of these pictures does much change that motion does not explain?\n"
      "It sees pops of the whole picture; one figure's in a crowd is lost there.\n\n"
      "Examples:\n"
      "  crowdbench popping bench/scenarios/flyover.toml --representation 'hybrid(mesh,flat,distance=20)' --out pops\n"
      "  crowdbench popping bench/scenarios/flyover.toml --representation 'hybrid(mesh,flat,distance=20)' "
      "--sweep hysteresis=0,0.1 --sweep fade=0,4,8\n"
      "  crowdbench popping --sequence frames/");
  auto options = std::make_shared<PoppingOptions>();
  add_scene_options(*command, options->scene);
  add_representation_option(*command, options->representation, "one whose agents switch; the scenario's by default");
  command
      ->add_option("--sweep", options->sweeps,
                   "an option of the representation and its values, fade=0,4,8; several are crossed")
      ->type_name("KEY=V,V,...")
      ->expected(1)
      ->take_all()
      ->allow_extra_args(false);
  add_frame_options(*command, options->request);
  add_display_option(*command, options->scene.display);
  command->add_option("--rows", options->rows, "switches that are printed; --json has all")
      ->type_name("N")
      ->capture_default_str()
      ->whole_number(0, 1'000'000);
  auto* out = command->add_option("--out", options->out, "pictures of the most visible switches: before, with, without")
                  ->type_name("DIR")
                  ->output_folder();
  command->add_option("--worst", options->worst, "of how many switches, with --out")
      ->type_name("N")
      ->capture_default_str()
      ->whole_number(1, 10'000)
      ->needs(out);
  add_results_option(*command, options->results);
  auto* sequence = command
                       ->add_option("--sequence", options->sequence,
                                    "instead: a clip or a folder of frames, of which no switch is known")
                       ->type_name("PATH");
  for (const char* drawn : {"SCENARIO", "--representation", "--sweep", "--out", "--display", "--db"})
    sequence->excludes(drawn);
  add_bake_options(*command, options->bake_budget_mib, &options->no_cache);
  add_json_option(*command, options->json);
  command->callback([options, &run] {
    run = [options] { return options->sequence.empty() ? run_scenario(*options) : run_sequence(*options); };
  });
}

}  // namespace crowdbench::bench
