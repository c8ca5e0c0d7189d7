#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <memory>

#include "bench/commands/command_line.h"
#include "bench/commands/commands.h"
#include "bench/commands/level_output.h"
#include "bench/commands/options.h"
#include "bench/commands/scene_options.h"
#include "bench/experiments/audit.h"
#include "bench/stage/stage_scenario.h"
#include "bench/stage/view_samples.h"
#include "core/error.h"
#include "core/json.h"
#include "core/progress.h"
#include "renderers/gl/context.h"
#include "renderers/representation.h"
#include "scene/crowd/crowd.h"
#include "scene/gltf/gltf.h"
#include "scene/scenario/parse_scenario.h"

namespace crowdbench::bench {
namespace {

struct BakeOptions {
  std::string representation;
  std::vector<std::string> characters = {"mannequin"};
  CharacterOptions character;  // for all of them
  std::vector<std::string> clips;
  uint64_t bake_budget_mib = kDefaultBakeBudgetMiB;
  std::string device;
  bool force = false;
  bool no_cache = false;
  bool audit = false;
  std::string required_by;
  bool report = false;
  bool json = false;
};

std::string names_that_honour_required_by() {
  std::vector<std::string> names;
  for (const renderers::RepresentationType& type : renderers::representation_types())
    if (type.required_by) names.push_back(type.name);
  return fmt::format("{}", fmt::join(names, " or "));
}

// A count as a whole number.
Json number(double value) {
  if (value == std::floor(value) && std::abs(value) < 9e15) return static_cast<int64_t>(value);
  return value;
}

Json json_of(const AuditError& e) {
  Json out = {{"views", e.views}};
  for (const auto& [score, mean] : e.means) out[std::string(score->name)] = mean;
  return out;
}

Json json_of(const ViewAudit& a) {
  Json out = {{"grid", a.grid},
              {"views", a.views},
              {"step_deg", {{"mean", a.step_deg_mean}, {"max", a.step_deg_max}}},
              {"error_deg", {{"mean", a.error_deg_mean}, {"max", a.error_deg_max}}},
              {"frames", a.frames},
              {"pose_step_seconds", a.pose_step_seconds},
              {"pose_step_mm", {{"mean", a.pose_step_mm_mean}, {"max", a.pose_step_mm_max}}},
              {"texel_mm", a.texel_mm},
              {"bytes", a.bytes},
              {"smooth_step_deg", kSmoothViewStepDeg},
              {"smooth", a.meets_limit},
              {"smooth_grid", a.limit_grid},
              {"smooth_views", a.limit_views},
              {"smooth_bytes", a.limit_bytes},
              {"stored", json_of(a.stored)},
              {"between", json_of(a.between)},
              {"between_frames", json_of(a.between_frames)},
              {"unmirrored", a.unmirrored ? json_of(*a.unmirrored) : Json(nullptr)},
              {"orbit_flicker", a.orbit_flicker}};
  return out;
}

void print(const ViewAudit& a) {
  const auto mib = [](uint64_t b) { return static_cast<double>(b) / (1 << 20); };
  fmt::print(
      "audit of the view sampling of {}\n  grid          {}, {} views captured, {:.1f} MiB in tiles of {:.1f} mm\n",
      a.representation, a.grid, a.views, mib(a.bytes), a.texel_mm);
  fmt::print("  view step     {:.2f} degrees between neighbours, {:.2f} at most\n", a.step_deg_mean, a.step_deg_max);
  fmt::print("  view error    {:.2f} degrees from the nearest view, {:.2f} at most\n", a.error_deg_mean,
             a.error_deg_max);
  fmt::print("  pose step     {} frames, {:.0f} ms; the farthest vertex moves {:.0f} mm, {:.0f} at most\n", a.frames,
             a.pose_step_seconds * 1000, a.pose_step_mm_mean, a.pose_step_mm_max);
  if (a.meets_limit)
    fmt::print("  smooth        yes: steps of at most {:g} degrees are not seen to jump\n", kSmoothViewStepDeg);
  else
    fmt::print("  smooth        no: steps above {:g} degrees are seen to jump; {} ({} views, {:.1f} MiB) would do\n",
               kSmoothViewStepDeg, a.limit_grid, a.limit_views, mib(a.limit_bytes));
  const auto line = [](const char* name, const AuditError& e) {
    fmt::print("  {:<14}", name);
    for (const auto& [score, mean] : e.means)
      if ((score->uses & metrics::kInTables) != 0)
        fmt::print("{} {}{}{}  ", score->column, metrics::value_text(*score, mean), score->unit.empty() ? "" : " ",
                   score->unit);
    fmt::print("({} views)\n", e.views);
  };
  line("stored views", a.stored);
  line("between", a.between);
  line("and frames", a.between_frames);
  if (a.unmirrored) line("not mirrored", *a.unmirrored);
  fmt::print("  orbit         flicker {:.3f} code values over a quarter turn in degrees\n", a.orbit_flicker);
}

// What a bake left: the representation and what was asked about it.
struct Baked {
  std::unique_ptr<renderers::Representation> representation;
  double seconds = 0;                          // to make it, or to read it
  uint64_t ticks = 0;                          // that --required-by looked at
  std::vector<std::vector<ViewAudit>> audits;  // by character, with --audit: of audited_specs()
};

scene::Scenario scenario_of(const BakeOptions& options, scene::KeyPlaces& places) {
  if (!options.required_by.empty()) return scene::load_scenario(options.required_by, &places);
  scene::Scenario scenario;
  scenario.characters.clear();
  for (const std::string& source : options.characters) {
    scene::CharacterEntry entry = options.character.entry();
    entry.source = source;
    entry.clips = options.clips;
    scenario.characters.push_back(entry);
  }
  return scenario;
}

Baked make_bake(const BakeOptions& options, const renderers::Spec& spec, const scene::Scenario& scenario,
                const scene::Cast& cast, gl::Context& context) {
  Baked baked;
  renderers::MakeContext make{.context = context, .cast = cast};
  make.bake_budget = options.bake_budget_mib << 20;
  make.use_cache = !options.no_cache;
  make.rebake = options.force;
  Staged staged;  // what make.required_by refers to
  if (!options.required_by.empty()) {
    staged = stage_scenario(scenario, cast, context);
    baked.ticks = required_ticks(staged.scenario);
    make.required_by = view_samples_of(staged.scenario, cast, staged.crowd, baked.ticks);
  }
  const auto start = std::chrono::steady_clock::now();
  baked.representation = renderers::make_representation(make, spec);
  baked.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  if (options.audit) {
    Progress progress("auditing the views", 0);
    for (const auto& character : cast.characters) {
      std::vector<ViewAudit>& audits = baked.audits.emplace_back();
      for (const renderers::Spec& audited : audited_specs(spec))
        audits.push_back(audit_views(context, character, audited, make.bake_budget, make.use_cache));
    }
  }
  return baked;
}

Json json_of(const renderers::Kept& kept) {
  return {{"unit", kept.unit},
          {"kept", kept.kept},
          {"whole", kept.whole},
          {"kept_bytes", kept.kept_bytes},
          {"whole_bytes", kept.whole_bytes}};
}

void print_json(const BakeOptions& options, const renderers::Spec& spec, const scene::Cast& cast,
                const std::string& renderer, const Baked& baked) {
  const renderers::BakeInfo bake = baked.representation->bake_info();
  const renderers::Footprint bytes = baked.representation->footprint();
  Json out = {{"representation", spec.text()},
              {"renderer", renderer},
              {"cached", bake.cached},
              {"seconds", baked.seconds},
              {"bake_seconds", renderers::cold_seconds(bake)},
              {"load_seconds", bake.cached ? Json(bake.seconds) : Json(nullptr)},
              {"cache_key", bake.cache_key.empty() ? Json(nullptr) : Json(bake.cache_key)},
              {"texture_bytes", bytes.texture_bytes},
              {"buffer_bytes", bytes.buffer_bytes},
              {"gpu_bytes", bytes.gpu_bytes()},
              {"disk_bytes", bytes.disk_bytes}};
  if (!options.required_by.empty()) {
    out["required_by"] = {{"scenario", options.required_by}, {"ticks", baked.ticks}, {"kept", Json::array()}};
    for (const renderers::Kept& kept : bake.kept) out["required_by"]["kept"].push_back(json_of(kept));
  }
  out["notes"] = bake.notes;
  out["levels"] = levels_json(bake.levels);
  out["facts"] = Json::object();
  for (const auto& [name, value] : bake.facts) out["facts"][name] = number(value);
  if (options.report)
    for (const auto& [name, value] : bake.facts) out[name] = number(value);
  if (options.report && !bake.items.empty()) {
    out["items"] = Json::array();
    for (const renderers::BakeItem& item : bake.items) {
      out["items"].push_back({{"name", item.name}});
      for (const auto& [name, value] : item.facts) out["items"].back()[name] = number(value);
    }
  }
  out["characters"] = Json::array();
  for (size_t c = 0; c < cast.characters.size(); ++c)
    out["characters"].push_back(
        {{"name", cast.characters[c]->name}, {"triangles", baked.representation->triangles(c)}});
  for (size_t c = 0; c < baked.audits.size(); ++c) {
    Json& audit = out["characters"][c]["audit"];
    for (const ViewAudit& one : baked.audits[c]) audit.push_back(json_of(one));
    if (audit.size() == 1) audit = Json(audit[0]);
  }
  fmt::print("{}\n", out.dump(2));
}

void print_text(const BakeOptions& options, const renderers::Spec& spec, const scene::Cast& cast,
                const std::string& renderer, const Baked& baked) {
  const renderers::BakeInfo bake = baked.representation->bake_info();
  const renderers::Footprint bytes = baked.representation->footprint();
  const auto mib = [](uint64_t b) { return static_cast<double>(b) / (1 << 20); };
  fmt::print("{} of", spec.text());
  for (const auto& character : cast.characters) fmt::print(" {}", printable(character->name));
  fmt::print("\n  renderer      {}\n", renderer);
  if (bake.cache_key.empty())
    fmt::print("  nothing is baked\n");
  else
    fmt::print("  baked         {:.2f} s{}\n", bake.made_seconds,
               bake.cached ? fmt::format(" when it was made; read from disk in {:.2f} s", bake.seconds) : "");
  for (const renderers::Kept& kept : bake.kept)
    fmt::print("  required by   {} in {} ticks: {} of {} {}, {:.1f} of {:.1f} MiB\n", printable(options.required_by),
               baked.ticks, kept.kept, kept.whole, kept.unit, mib(kept.kept_bytes), mib(kept.whole_bytes));
  fmt::print("  textures      {:.1f} MiB\n  buffers       {:.2f} MiB\n  on disk       {:.1f} MiB\n",
             mib(bytes.texture_bytes), mib(bytes.buffer_bytes), mib(bytes.disk_bytes));
  for (const auto& [name, value] : bake.facts) fmt::print("  {:<13} {:g}\n", name, value);
  for (const renderers::LevelInfo& level : bake.levels) fmt::print("  level of {}\n", level_text(level));
  for (const std::string& note : bake.notes) fmt::print("  note: {}\n", printable(note));
  if (options.report)
    for (const renderers::BakeItem& item : bake.items) {
      fmt::print("  {:<28}", printable(item.name));
      for (const auto& [name, value] : item.facts) fmt::print("  {} {:g}", name, value);
      fmt::print("\n");
    }
  for (const std::vector<ViewAudit>& audits : baked.audits)
    for (const ViewAudit& audit : audits) print(audit);
}

int run_bake(const BakeOptions& options) {
  const renderers::Spec spec = parse_representation(options.representation);
  if (!options.required_by.empty() && !honours_required_by(spec))
    throw Error("--required-by",
                fmt::format("'{}' {}", spec.name,
                            !view_grid_meaning(renderers::representation_type(spec.name)).empty()
                                ? "keeps all of its views: it cannot leave any out"
                                : "stores no views that could be left out"),
                "leave --required-by out, or bake " + names_that_honour_required_by());
  scene::KeyPlaces places;
  const scene::Scenario scenario = scenario_of(options, places);
  const scene::Cast cast = open_cast(scenario, std::filesystem::path(options.required_by).parent_path(), places);
  gl::Context context({.device = options.device});
  const Baked baked = make_bake(options, spec, scenario, cast, context);
  (options.json ? print_json : print_text)(options, spec, cast, context.renderer(), baked);
  return 0;
}

}  // namespace

void add_bake(Command& app, Run& run) {
  Command* command = app.add_subcommand("bake", "Bake a representation of a character, or read it from the cache");
  command->footer(
      "Bakes are kept in $CROWDBENCH_CACHE_DIR, else $XDG_CACHE_HOME/crowdbench, else ~/.cache/crowdbench, keyed by "
      "the\n"
      "character's content, the options, the bake's version and the OpenGL renderer.\n\n"
      "Examples:\n"
      "  crowdbench bake --representation flat\n"
      "  crowdbench bake --representation flat:views=sphere-32x9,frames=16 --character knight.glb --json\n"
      "  crowdbench bake --representation relief --report --json\n"
      "  crowdbench bake --representation flat:views=sphere-17x8-mirrored --audit\n"
      "  crowdbench bake --representation flat --required-by plaza.toml");
  auto options = std::make_shared<BakeOptions>();
  add_representation_option(*command, options->representation, "what is baked")->required();
  add_character_options(*command, options->characters, options->character);
  command->add_option("--clip", options->clips, "name or index; may be given several times (the default clip)")
      ->type_name("CLIP")
      ->take_all()
      ->expected(1)
      ->allow_extra_args(false);
  command
      ->add_option("--required-by", options->required_by,
                   "a scenario: keep only the views and frames that its camera sees of its agents")
      ->type_name("SCENARIO")
      ->excludes("--character")
      ->excludes("--clip");
  command->add_flag(
      "--audit", options->audit,
      "also state how coarse the stored views and frames are, what 6 degrees a step would take, and what\n"
      "they were measured to cost in the picture, of a representation that stores views or is made of one that does");
  command->add_flag("--force", options->force, "bake anew although it is in the cache");
  add_bake_options(*command, options->bake_budget_mib, &options->no_cache);
  add_device_option(*command, options->device);
  command->add_flag(
      "--report", options->report,
      "also the bake's items, where it names any; JSON: what the representation says of its bake beside the "
      "sizes,\nnot only under facts");
  add_json_option(*command, options->json);
  command->callback([options, &run] { run = [options] { return run_bake(*options); }; });
}

}  // namespace crowdbench::bench
