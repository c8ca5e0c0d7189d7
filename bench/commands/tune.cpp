#include "bench/experiments/tune.h"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <filesystem>

#include "bench/commands/command_line.h"
#include "bench/commands/options.h"
#include "bench/commands/scene_options.h"
#include "bench/commands/score_bounds.h"
#include "bench/commands/score_commands.h"
#include "bench/commands/tune_output.h"
#include "bench/experiments/quality.h"
#include "bench/experiments/tune_rows.h"
#include "bench/stage/low_polygon.h"
#include "bench/stage/stage.h"
#include "bench/timing/run_facts.h"
#include "core/command_line.h"
#include "core/counted.h"
#include "core/error.h"
#include "core/files.h"
#include "core/progress.h"
#include "scene/cast/cast.h"
#include "scene/cast/open_character.h"
#include "scene/pose/normalise.h"
#include "scene/scenario/scenario.h"

namespace crowdbench::bench {
namespace {

struct TuneOptions {
  SceneOptions scene;
  std::vector<std::string> representations;
  std::string clip;
  std::string error, pop;
  std::string azimuths, elevations;
  std::vector<std::string> also;
  double nearest_px = 0, farthest_px = 8;
  double budget_ms = 0;
  uint64_t heights = 12, views = 72;
  uint64_t moments = 12, fade = 0, rounds = 20;
  uint64_t promise_seeds = kPromiseSeeds, prove = 0, prove_figures = kSeedFigures;
  std::string prove_on;
  std::string page, results;
  bool check_views = false;
  uint64_t bake_budget_mib = kDefaultBakeBudgetMiB;
  bool no_cache = false;
  bool json = false;
};

// "SCORE=VALUE": of the score that the table has a threshold of.
std::string default_threshold(metrics::ScoreTable table) {
  const metrics::Score* score = metrics::score_of_threshold(table);
  assert(score != nullptr);
  return fmt::format("{}={:g}", score->name, *score->threshold);
}

// All representations that stand alone and the level of detail that every figure of speed is told against; the
// reference first, asked for or not.
std::vector<renderers::Spec> candidates_of(const TuneOptions& options) {
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
std::vector<double> heights_of(const TuneOptions& options, int rows) {
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

// Agents of the scenario's first frame within the camera's edges; those beyond cost nothing and are left out.
struct Seen {
  std::vector<std::vector<double>> heights_px;  // by character
  std::vector<double> elevations_deg;           // from where each is looked at
};
Seen agents_seen(Stage& stage) {
  const scene::Frame& frame = stage.frame(0);
  const glm::dmat3 turn = scene::view_rotation(frame.camera);
  const double slope = std::tan(frame.camera.fov_y / 2);
  const double aspect = static_cast<double>(frame.width) / frame.height;
  Seen out;
  out.heights_px.resize(frame.agents.size());
  for (size_t c = 0; c < frame.agents.size(); ++c) {
    for (const scene::FrameAgent& agent : frame.agents[c]) {
      const double height = stage.cast().characters[c]->placement.height * agent.scale;
      const glm::dvec3 middle = glm::dvec3(agent.position) + glm::dvec3(0, height / 2, 0);
      const glm::dvec3 seen = turn * middle;
      const double depth = -seen.z;
      if (depth < frame.camera.near || std::abs(seen.y) > depth * slope + height / 2 ||
          std::abs(seen.x) > depth * slope * aspect + height / 2)
        continue;
      out.heights_px[c].push_back(height / scene::pixel_size_at(frame.camera, depth, frame.height));
      out.elevations_deg.push_back(glm::degrees(std::asin(std::clamp(-middle.y / glm::length(middle), -1.0, 1.0))));
    }
  }
  return out;
}

// What was given, or what the scenario's camera sees: all but its outermost 5 % on either side.
TuneBlocks blocks_of(const TuneOptions& options, const Seen& seen) {
  TuneBlocks blocks;
  blocks.views = static_cast<size_t>(options.views);
  blocks.moments = static_cast<size_t>(options.moments);
  if (!options.azimuths.empty() || !options.elevations.empty()) {
    blocks.azimuths_deg =
        parse_numbers(options.azimuths.empty() ? "0:300:60" : options.azimuths, "--azimuth-deg", -360, 360);
    blocks.elevations_deg =
        parse_numbers(options.elevations.empty() ? "0,20" : options.elevations, "--elevation-deg", -90, 90);
  } else if (!seen.elevations_deg.empty()) {
    blocks.lowest_deg = quantile(seen.elevations_deg, 0.05);
    blocks.highest_deg = quantile(seen.elevations_deg, 0.95);
  }
  return blocks;
}

TuneRequest read_request(const TuneOptions& options, metrics::ScoreTable table, const ChosenScenario& chosen) {
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
  request.blocks = blocks_of(options, {});
  request.budget_ns = 1e6 * options.budget_ms;
  if (request.budget_ns > 0 && !std::isfinite(metrics::best_value(*request.error.score)))
    throw Error("--budget-ms",
                fmt::format("{} has no finite best value, so that losses do not add up", request.error.score->name),
                "take another score with --threshold");
  if (options.promise_seeds == 1 || options.promise_seeds == 2)
    throw Error("--promise-seeds", "an interval is not made of so few", "use 0, or at least 3");
  if (options.prove > 0 && options.promise_seeds == 0)
    throw Error("--prove", "without --promise-seeds there is no promise of speed", "use at least 3 of them");
  if (options.prove == 0 && !options.prove_on.empty())
    throw Error("--prove-on", "nothing is proved", "give the number of seeds with --prove");
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

// The scenario's characters, or that of --character, and those of --also-character in equal shares.
ChosenScenario chosen_scenario(const TuneOptions& options) {
  ChosenScenario chosen = read_scenario(options.scene);
  for (const std::string& source : options.also) {
    CharacterOptions character = options.scene.character;
    character.source = scene::is_built_in(source) ? source : std::filesystem::absolute(source).string();
    chosen.scenario.characters.push_back(character.entry());
  }
  return chosen;
}

TuneSubject subject_of(const TuneOptions& options, const std::shared_ptr<const scene::Character>& character) {
  TuneSubject subject;
  subject.character = character;
  subject.clip =
      options.clip.empty() ? character->placement.default_clip : scene::require_clip_or_none(*character, options.clip);
  return subject;
}

// The scenario as it was placed: other seeds need no solving.
TuneProofRequest proof_request(const TuneOptions& options, const Staged& staged, const scene::Cast& cast) {
  TuneProofRequest request;
  request.scenario = staged.scenario;
  request.scenario.occupancy.reset();
  request.cast = &cast;
  request.bake_budget = options.bake_budget_mib << 20;
  return request;
}

// The character of --prove-on, and how a scenario names it.
struct OtherCast {
  scene::CharacterEntry entry;
  scene::Cast cast;
  TuneSubject subject;
};
// Nothing without --prove-on.
std::optional<OtherCast> other_cast(const TuneOptions& options, scene::Scenario scenario) {
  if (options.prove_on.empty()) return std::nullopt;
  CharacterOptions character = options.scene.character;
  character.source = options.prove_on;
  OtherCast out;
  out.entry = character.entry();
  scenario.characters = {out.entry};
  out.cast = open_cast(scenario);
  out.subject = subject_of(options, out.cast.characters[0]);
  return out;
}

// What figures of every tuned character score on each seed.
struct SeedFigures {
  std::vector<SeedScores> scores;                     // by seed
  std::vector<std::vector<UnseenFigure>> by_subject;  // of all seeds
};
SeedFigures score_seeds(gl::Context& context, const TuneOptions& options, const TuneReport& report,
                        const renderers::Spec& representation, const std::vector<uint64_t>& seeds) {
  const TuneRequest& request = report.request;
  SeedFigures out;
  out.by_subject.resize(request.subjects.size());
  Progress progress("unseen figures", seeds.size() * request.subjects.size());
  for (const uint64_t seed : seeds) {
    std::vector<UnseenFigure> all;
    for (size_t s = 0; s < request.subjects.size(); ++s) {
      const auto count = static_cast<size_t>(options.prove_figures);
      std::vector<UnseenFigure> figures =
          draw_unseen(context, request, request.subjects[s], representation, count, seed);
      for (UnseenFigure& one : figures) one.place += s * count;
      all.insert(all.end(), figures.begin(), figures.end());
      out.by_subject[s].insert(out.by_subject[s].end(), figures.begin(), figures.end());
      progress.advance();
    }
    out.scores.push_back(scores_of(*request.error.score, seed, all));
  }
  return out;
}

// A crowd of one character alone, on the same ground and through the same camera.
TuneProofRequest crowd_of(TuneProofRequest request, const scene::CharacterEntry& entry, const scene::Cast& cast) {
  request.scenario.characters = {entry};
  request.cast = &cast;
  return request;
}

OthersPromise promise_others(gl::Context& context, const TuneReport& report, const TuneProofRequest& request,
                             const scene::Cast& cast) {
  std::vector<CharacterDrawn> left_out;
  const size_t count = report.request.subjects.size();
  const std::vector<uint64_t> seeds = derived_seeds(report.request.seed, SeedsFor::characters, count);
  for (size_t s = 0; s < count; ++s) {
    scene::Cast one;
    one.characters = {cast.characters[s]};
    one.banks = {cast.banks[s]};
    one.shares = {1.0};
    TuneProofRequest of = crowd_of(request, request.scenario.characters[s], one);
    of.representation = tuned_representation(report.request, report.result.left_out[s]);
    left_out.push_back(draw_character(context, report.request, of, report.request.subjects[s], {seeds[s]}));
  }
  return promised_of_others(*report.request.error.score, std::move(left_out));
}

// Crowds and figures of unseen seeds, of the tuned characters or of another.
TuneProof prove(gl::Context& context, const TuneOptions& options, const TuneReport& report, const OtherCast* other,
                const TuneProofRequest& request) {
  TuneProof proof;
  const std::vector<uint64_t> seeds =
      derived_seeds(report.request.seed, SeedsFor::proof, static_cast<size_t>(options.prove));
  if (other != nullptr) {
    proof.other = prove_other(
        *report.others,
        draw_character(context, report.request, crowd_of(request, other->entry, other->cast), other->subject, seeds));
    return proof;
  }
  proof.speed = prove_speed(*report.promise, time_seeds(context, request, seeds));
  const SeedFigures figures = score_seeds(context, options, report, request.representation, seeds);
  proof.score = prove_score(*report.score_promise, figures.scores);
  for (size_t s = 0; s < figures.by_subject.size(); ++s)
    proof.errors.push_back(prove_errors(report.request, report.result, s, figures.by_subject[s]));
  return proof;
}

// What the rules of thumb say of every candidate that was not refused.
void predict_all(gl::Context& context, TuneReport& report) {
  Progress progress("predictions", report.request.subjects.size() * report.request.candidates.size());
  report.predicted.assign(report.request.subjects.size(),
                          std::vector<TunePrediction>(report.request.candidates.size()));
  for (size_t s = 0; s < report.request.subjects.size(); ++s)
    for (size_t c = 0; c < report.request.candidates.size(); ++c) {
      throw_if_interrupted();
      progress.advance();
      if (report.result.subjects[s].refused[c].empty())
        report.predicted[s][c] =
            predict(context, report.request, report.request.subjects[s], report.request.candidates[c]);
    }
}

void describe_plan(gl::Context& context, const TuneOptions& options, const scene::Cast& cast, const OtherCast* other,
                   const Staged& staged, TuneReport& report) {
  const TuneAnswer& answer = report.result.together;
  if (!answer.plan) return;
  predict_all(context, report);
  if (!options.page.empty()) report.pictures = draw_switches(context, report.request, answer);
  TuneProofRequest request = proof_request(options, staged, cast);
  request.representation = tuned_representation(report.request, answer);
  if (options.promise_seeds > 0 && staged.crowd.size() > 0) {
    const std::vector<uint64_t> seeds =
        derived_seeds(report.request.seed, SeedsFor::promise, static_cast<size_t>(options.promise_seeds));
    SpeedPromise speed = promised_speed(time_seeds(context, request, seeds));
    report.score_promise = promised_score(*report.request.error.score,
                                          score_seeds(context, options, report, request.representation, seeds).scores);
    report.promise = std::move(speed);  // with the score's, or neither
    if (no_promise_of_others(report.request).empty()) report.others = promise_others(context, report, request, cast);
  }
  if (options.check_views) report.lenses = check_lenses(context, report.request, report.result, usual_lenses());
  if (options.prove > 0 && report.promise) report.proof = prove(context, options, report, other, request);
}

TuneReport measure(const TuneOptions& options, metrics::ScoreTable table) {
  const ChosenScenario chosen = chosen_scenario(options);
  TuneReport report;
  report.request = read_request(options, table, chosen);
  Progress progress("tune", 0);
  progress.note("loading the characters");
  const scene::Cast cast = open_cast(chosen.scenario, chosen.folder, chosen.places);
  for (const auto& character : cast.characters) {
    const TuneSubject subject = subject_of(options, character);
    const scene::PoseBank bank(*character, {subject.clip}, 30);
    report.bounds.emplace_back(bank.bounds_max() - bank.bounds_min());
    report.request.subjects.push_back(subject);
  }
  if (const std::string why = no_promise_of_others(report.request); !options.prove_on.empty() && !why.empty())
    throw Error("--prove-on", "of a character that was not tuned nothing is promised: " + why,
                report.request.budget_ns > 0 ? "leave --budget-ms out" : "tune more of them with --also-character");
  const std::optional<OtherCast> other = other_cast(options, chosen.scenario);
  const auto context = open_context(options.scene.device);
  progress.note(fmt::format("placing {}", counted(chosen.scenario.crowd.agents, "agent", "agents")));
  const Staged staged = stage_scenario(chosen.scenario, cast, *context);
  if (options.prove > 0 && staged.crowd.size() == 0)
    throw Error("--prove", "the crowd has no agents, so that no speed is promised", "give some with --agents");
  report.request.cost.fov_y = staged.camera.fov_y;
  report.run = describe_run(*context, choose_timing_method(*context), chosen.scenario, "tune", command_line());
  report.crowd = static_cast<uint32_t>(staged.crowd.size());
  {
    Stage stage(*context, cast);
    stage.show(staged);
    const Seen seen = agents_seen(stage);
    for (size_t s = 0; s < cast.characters.size(); ++s) report.request.subjects[s].agents_px = seen.heights_px[s];
    report.request.blocks = blocks_of(options, seen);
  }
  progress.note("");
  if (report.request.budget_ns > 0 && staged.crowd.size() > 0)
    report.request.frame_ns = [&](const renderers::Spec& spec) {
      TuneProofRequest request = proof_request(options, staged, cast);
      request.representation = spec;
      return time_seeds(*context, request, {staged.scenario.seed})[0].plan_ns;
    };
  report.result = tune(*context, report.request);
  report.request.frame_ns = {};
  // What was tuned is told even where what was asked of it then cannot be.
  try {
    describe_plan(*context, options, cast, other ? &*other : nullptr, staged, report);
  } catch (const Error& e) {
    report.failed = e;
  }
  return report;
}

int run_tune(const TuneOptions& options, metrics::ScoreTable table) {
  std::optional<StoreWriter> store;
  if (!options.results.empty()) store.emplace(options.results);  // refused before anything is drawn
  const TuneReport report = measure(options, table);
  if (store) write_tune_rows(*store, tune_rows(report, store->write(report.run)));
  if (!options.page.empty()) write_file(options.page, std::string_view(tune_page_of(report)));
  if (options.json)
    fmt::print("{}\n", tune_json(report).dump(2));
  else
    print_tune(report);
  if (report.failed) throw Error(*report.failed);
  return report.result.together.plan && (!report.proof || report.proof->holds()) ? 0 : 1;
}

void add_view_options(Command& command, TuneOptions& options) {
  command
      .add_option("--azimuth-deg", options.azimuths,
                  "from where it is looked at, 0 = from the front; without a list all round")
      ->type_name("LIST");
  command
      .add_option("--elevation-deg", options.elevations,
                  "positive = from above; without a list as the scenario's camera sees its agents")
      ->type_name("LIST");
  const auto add_count = [&](const char* name, uint64_t& value, uint64_t least, uint64_t most, const char* text) {
    command.add_option(name, value, text)->type_name("N")->capture_default_str()->whole_number(least, most);
  };
  add_count("--views", options.views, 1, 10'000, "directions without lists; 72 bound the bad end's 5 %");
  add_count("--moments", options.moments, 1, 100, "of the clip, evenly; with lists each for every direction");
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

void add_proof_options(Command& command, TuneOptions& options) {
  const auto add_count = [&](const char* name, uint64_t& value, uint64_t least, uint64_t most, const char* text) {
    command.add_option(name, value, text)->type_name("N")->capture_default_str()->whole_number(least, most);
  };
  add_count("--promise-seeds", options.promise_seeds, 0, 1000,
            "crowds of other seeds from which speed and score on any other are promised; 0: none");
  command.add_flag("--check-views", options.check_views,
                   "draw the plan's heights at 720, 1080 and 2160 rows through 30 and 90 degrees too");
  add_count("--prove", options.prove, 0, 1000, "hold the plan against its promise on so many unseen seeds; 0: not");
  add_count("--prove-figures", options.prove_figures, 1, 100'000,
            "figures scored on each seed, of each tuned character");
  command
      .add_option("--prove-on", options.prove_on,
                  "the same on a crowd of a character that was not tuned, of three tuned ones or more")
      ->type_name("C");
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
      "its 95 % interval. A change from one to another must keep the pop threshold where it happens. Of all that "
      "is\n"
      "allowed the cheapest is taken, for the scenario's agents and camera; with --budget-ms, of all sets that take "
      "no\n"
      "longer, the one that loses least, whatever the threshold. Several characters get a rule each and one for all.\n"
      "Times are of this machine and of the device that draws; what is printed first says which. On a software "
      "rasteriser\n"
      "they choose and compare, and a budget in milliseconds is one for that rasteriser.\n"
      "Exit status 1: nothing is allowed somewhere, nothing fits, or a proof fails.\n\n"
      "Examples:\n"
      "  crowdbench tune --representation flat,relief\n"
      "  crowdbench tune street.toml --character knight.glb --threshold ssim=0.9 --pop-threshold ssim=0.8 --fade 8 "
      "--json\n"
      "  crowdbench tune --budget-ms 8 --agents 5000\n"
      "  crowdbench tune --representation flat --prove 20 --check-views\n"
      "  crowdbench tune street.toml --also-character fox.glb --page tuned.html --db results.sqlite");
  auto options = std::make_shared<TuneOptions>();
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
  command->add_option("--budget-ms", options->budget_ms, "what a frame may take: then the least visible set within it")
      ->type_name("MS")
      ->number(0, 1e6);
  command->add_option("--also-character", options->also, "a further character of the crowd, as --character; repeated")
      ->type_name("C");
  add_view_options(*command, *options);
  add_proof_options(*command, *options);
  add_display_option(*command, options->scene.display);
  command
      ->add_option(
          "--page", options->page,
          "one self-contained page: the answer, errors and costs by distance, pictures of each switch, engines")
      ->type_name("FILE.html")
      ->output_file();
  add_results_option(*command, options->results);
  add_bake_options(*command, options->bake_budget_mib, &options->no_cache);
  add_json_option(*command, options->json);
  command->callback([options, &run] { run = [options] { return run_tune(*options, metrics::scores()); }; });
}

}  // namespace crowdbench::bench
