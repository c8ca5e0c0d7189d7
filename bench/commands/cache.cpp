// `crowdbench cache`: the bakes that are stored, and how to be rid of them.
#include <fmt/chrono.h>
#include <fmt/format.h>

#include <chrono>
#include <memory>
#include <vector>

#include "bench/commands/command_line.h"
#include "bench/commands/commands.h"
#include "bench/commands/options.h"
#include "core/error.h"
#include "core/json.h"
#include "renderers/bake/cache_entries.h"
#include "reports/model/number_text.h"

namespace crowdbench::bench {
namespace {
namespace fs = std::filesystem;

using renderers::CacheEntry;

struct CacheOptions {
  std::string action;
  bool json = false;
};

std::string utc_text(fs::file_time_type time) {
  const auto system = std::chrono::file_clock::to_sys(time);
  return fmt::format("{:%Y-%m-%d %H:%M:%S}Z",
                     fmt::gmtime(std::chrono::system_clock::to_time_t(
                         std::chrono::time_point_cast<std::chrono::system_clock::duration>(system))));
}

Json entries_json(const fs::path& folder, const std::vector<CacheEntry>& entries, uint64_t held, uint64_t limit) {
  Json list = Json::array();
  for (const CacheEntry& entry : entries)
    list.push_back({{"kind", entry.kind},
                    {"key", entry.key},
                    {"bytes", entry.bytes},
                    {"last_use", utc_text(entry.last_use)},
                    {"file", entry.file.string()}});
  const bool limited = limit != std::numeric_limits<uint64_t>::max();
  return {{"folder", folder.string()},
          {"bytes", held},
          {"limit_bytes", limited ? Json(limit) : Json(nullptr)},
          {"entries", list}};
}

void list_entries(const CacheOptions& options) {
  const fs::path folder = renderers::bake_folder();
  const uint64_t limit = renderers::cache_limit_bytes();
  const std::vector<CacheEntry> entries = renderers::cache_entries(folder);
  uint64_t held = 0;
  for (const CacheEntry& entry : entries) held += entry.bytes;
  if (options.json) {
    fmt::print("{}\n", entries_json(folder, entries, held, limit).dump(2));
    return;
  }
  for (const CacheEntry& entry : entries)
    fmt::print("{}  {:>10}  {:<12} {}\n", utc_text(entry.last_use), reports::bytes_text(entry.bytes), entry.kind,
               entry.key);
  fmt::print("{}: {} {}, {} of {}\n", folder.string(), entries.size(), entries.size() == 1 ? "bake" : "bakes",
             reports::bytes_text(held),
             limit == std::numeric_limits<uint64_t>::max() ? "any size" : "at most " + reports::bytes_text(limit));
}

void clear_entries(const CacheOptions& options) {
  const fs::path folder = renderers::bake_folder();
  const renderers::RemovedEntries removed = renderers::clear_cache(folder);
  const size_t left = renderers::cache_entries(folder).size();
  if (options.json)
    fmt::print("{}\n", Json{{"folder", folder.string()}, {"removed", removed.count}, {"bytes", removed.bytes}}.dump(2));
  else
    fmt::print("{}: {} {} removed, {}\n", folder.string(), removed.count, removed.count == 1 ? "bake" : "bakes",
               reports::bytes_text(removed.bytes));
  if (left > 0)
    throw Error(folder.string(), fmt::format("{} of the bakes cannot be removed", left), "see who may write there");
}

Error unknown_action(const std::string& given) {
  const std::string near = nearest_name(given, {"list", "clear"});
  return Error("cache", fmt::format("'{}' is not something to do with the cache", printable(given, 60)),
               near.empty() ? "list, or clear; see crowdbench cache --help" : fmt::format("did you mean '{}'?", near));
}

}  // namespace

void add_cache(Command& app, Run& run) {
  auto options = std::make_shared<CacheOptions>();
  Command* command = app.add_subcommand("cache", "List the bakes that are stored, or remove them");
  command->footer(fmt::format(
      "Bakes are kept in $CROWDBENCH_CACHE_DIR, else $XDG_CACHE_HOME/crowdbench, else ~/.cache/crowdbench. When a new "
      "one\n"
      "makes them more than $CROWDBENCH_CACHE_LIMIT_MIB (default {}; 0: no limit), those unused for longest are "
      "removed.\n"
      "Examples:\n  crowdbench cache list          each with its last use, the one unused for longest first\n"
      "  crowdbench cache list --json\n  crowdbench cache clear         removes all\n",
      renderers::kDefaultCacheLimitMiB));
  command->add_option("ACTION", options->action, "list or clear")->required()->type_name("list|clear");
  add_json_option(*command, options->json, "the same as JSON");
  command->callback([options, &run] {
    run = [options] {
      if (options->action == "list")
        list_entries(*options);
      else if (options->action == "clear")
        clear_entries(*options);
      else
        throw unknown_action(options->action);
      return 0;
    };
  });
}

}  // namespace crowdbench::bench
