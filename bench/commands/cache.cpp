#include <fmt/chrono.h>
#include <fmt/format.h>

#include <chrono>
#include <memory>

#include "bench/commands/command_line.h"
#include "bench/commands/commands.h"
#include "bench/commands/options.h"
#include "core/error.h"
#include "core/json.h"
#include "renderers/bake/cache_limit.h"

namespace crowdbench::bench {
namespace {

struct Options {
  std::string what;
  bool json = false;
};

std::string date_of(const renderers::CachedBake& bake) {
  const auto time = std::chrono::time_point_cast<std::chrono::seconds>(std::chrono::file_clock::to_sys(bake.used));
  return fmt::format("{:%Y-%m-%dT%H:%M:%SZ}", time);
}

int list(const std::filesystem::path& folder, bool json) {
  const std::vector<renderers::CachedBake> bakes = renderers::cached_bakes(folder);
  const uint64_t limit = renderers::bake_limit();
  uint64_t bytes = 0;
  Json rows = Json::array();
  for (const renderers::CachedBake& bake : bakes) {
    bytes += bake.bytes;
    rows.push_back({{"kind", bake.kind}, {"key", bake.key}, {"bytes", bake.bytes}, {"used", date_of(bake)}});
  }
  if (json) {
    const Json out = {{"folder", folder.string()}, {"limit_bytes", limit}, {"bytes", bytes}, {"bakes", rows}};
    fmt::print("{}\n", out.dump(2));
    return 0;
  }
  const auto mib = [](uint64_t b) { return static_cast<double>(b) / (1 << 20); };
  for (const renderers::CachedBake& bake : bakes)
    fmt::print("{:>9.1f} MiB  {}  {:<12} {}\n", mib(bake.bytes), date_of(bake), printable(bake.kind),
               printable(bake.key.substr(0, 16)));
  fmt::print("{} bakes, {:.1f} of {:.1f} MiB, in {}\n", bakes.size(), mib(bytes), mib(limit),
             printable(folder.string()));
  return 0;
}

int clear(const std::filesystem::path& folder, bool json) {
  const size_t bakes = renderers::cached_bakes(folder).size();
  const uint64_t removed = renderers::shrink_bakes(folder, 0);
  if (json)
    fmt::print("{}\n", Json({{"folder", folder.string()}, {"removed", bakes}, {"removed_bytes", removed}}).dump(2));
  else
    fmt::print("{} bakes removed, {:.1f} MiB, from {}\n", bakes, static_cast<double>(removed) / (1 << 20),
               printable(folder.string()));
  return 0;
}

int run_cache(const Options& options) {
  const std::filesystem::path folder = renderers::bake_folder();
  if (options.what == "list") return list(folder, options.json);
  if (options.what == "clear") return clear(folder, options.json);
  throw Error("cache", fmt::format("'{}' is not something that it does", printable(options.what, 40)),
              "say list or clear");
}

}  // namespace

void add_cache(Command& app, Run& run) {
  Command* command = app.add_subcommand("cache", "The bakes on disk: lists them, or removes them all");
  command->footer(
      "Bakes take at most $CROWDBENCH_CACHE_MIB, 4096 where that is not set: a new one drives out those that were not\n"
      "used for longest. They are in $CROWDBENCH_CACHE_DIR/bakes, see bake --help.\n"
      "Examples:\n  crowdbench cache list\n  crowdbench cache list --json\n  crowdbench cache clear");
  auto options = std::make_shared<Options>();
  command->add_option("ACTION", options->what, "list: the one not used for longest first; clear: removes all")
      ->required()
      ->type_name("list|clear");
  add_json_option(*command, options->json);
  command->callback([options, &run] { run = [options] { return run_cache(*options); }; });
}

}  // namespace crowdbench::bench
