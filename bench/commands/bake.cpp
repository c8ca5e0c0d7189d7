#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <chrono>
#include <nlohmann/json.hpp>

#include "bench/commands.h"
#include "core/error.h"
#include "renderers/gl/context.h"
#include "renderers/representation.h"
#include "scene/crowd.h"
#include "scene/gltf.h"

namespace crowdbench::bench {
namespace {

using nlohmann::ordered_json;

struct Options {
  std::string representation;
  std::vector<std::string> characters = {"mannequin"};
  std::vector<std::string> clips;
  double bake_budget_mib = 512;
  std::string device;
  bool force = false;
  bool no_cache = false;
  bool json = false;
};

int run_bake(const Options& options) {
  const renderers::Spec spec = renderers::parse_spec(options.representation);
  scene::Scenario scenario;
  scenario.characters.clear();
  for (const std::string& source : options.characters) {
    scene::CharacterEntry entry;
    entry.source = source;
    entry.clips = options.clips;
    scenario.characters.push_back(entry);
  }
  const scene::Cast cast = scene::load_cast(scenario);
  gl::Context context({.device = options.device});
  renderers::MakeContext make{.context = context, .cast = cast};
  make.bake_budget = static_cast<uint64_t>(options.bake_budget_mib * (1 << 20));
  make.use_cache = !options.no_cache;
  make.rebake = options.force;
  const auto start = std::chrono::steady_clock::now();
  const auto representation = renderers::make_representation(make, spec);
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  const renderers::BakeInfo bake = representation->bake_info();
  const renderers::Footprint bytes = representation->footprint();

  if (options.json) {
    ordered_json out = {{"representation", spec.text()},
                        {"renderer", context.renderer()},
                        {"cached", bake.cached},
                        {"seconds", seconds},
                        {"bake_seconds", bake.seconds},
                        {"cache_key", bake.cache_key.empty() ? ordered_json(nullptr) : ordered_json(bake.cache_key)},
                        {"texture_bytes", bytes.texture_bytes},
                        {"buffer_bytes", bytes.buffer_bytes},
                        {"gpu_bytes", bytes.gpu_bytes()},
                        {"disk_bytes", bytes.disk_bytes}};
    out["facts"] = ordered_json::object();
    for (const auto& [name, value] : bake.facts) out["facts"][name] = value;
    out["characters"] = ordered_json::array();
    for (size_t c = 0; c < cast.characters.size(); ++c)
      out["characters"].push_back({{"name", cast.characters[c]->name}, {"triangles", representation->triangles(c)}});
    fmt::print("{}\n", out.dump(2, ' ', false, ordered_json::error_handler_t::replace));
    return 0;
  }
  const auto mib = [](uint64_t b) { return static_cast<double>(b) / (1 << 20); };
  fmt::print("{} of", spec.text());
  for (const auto& character : cast.characters) fmt::print(" {}", printable(character->name));
  fmt::print("\n  renderer      {}\n", context.renderer());
  if (bake.cache_key.empty())
    fmt::print("  nothing is baked\n");
  else
    fmt::print("  {}  {:.2f} s\n", bake.cached ? "read from disk" : "baked         ", bake.seconds);
  fmt::print("  textures      {:.1f} MiB\n  buffers       {:.2f} MiB\n  on disk       {:.1f} MiB\n",
             mib(bytes.texture_bytes), mib(bytes.buffer_bytes), mib(bytes.disk_bytes));
  for (const auto& [name, value] : bake.facts) fmt::print("  {:<13} {:g}\n", name, value);
  return 0;
}

}  // namespace

void add_bake(CLI::App& app, Run& run) {
  CLI::App* command = app.add_subcommand("bake", "Bake a representation of a character, or read it from the cache");
  command->footer(
      "Bakes are kept in $CROWDBENCH_CACHE_DIR, else $XDG_CACHE_HOME/crowdbench, else ~/.cache/crowdbench, keyed by "
      "the\n"
      "character's content, the options, the bake's version and the OpenGL renderer.\n\n"
      "Examples:\n"
      "  crowdbench bake flat\n"
      "  crowdbench bake flat:views=sphere-32x9,frames=16 --character knight.glb --json");
  auto options = std::make_shared<Options>();
  command->add_option("REPRESENTATION", options->representation, "name[:key=value,...]; info --representations")
      ->required();
  command->add_option("--character", options->characters,
                      "a glTF file, or mannequin[:triangles=N,joints=N]; may be given several times");
  command->add_option("--clip", options->clips, "name or index; may be given several times (the default clip)");
  command->add_option("--bake-budget", options->bake_budget_mib, "MiB that the bake may take (512)")
      ->check(CLI::Range(1.0, 1e6));
  command->add_flag("--force", options->force, "bake anew although it is in the cache");
  command->add_flag("--no-cache", options->no_cache, "neither read nor write stored bakes");
  command->add_option("--device", options->device, "EGL device: its index, software, or surfaceless");
  command->add_flag("--json", options->json, "print JSON");
  command->callback([options, &run] { run = [options] { return run_bake(*options); }; });
}

}  // namespace crowdbench::bench
