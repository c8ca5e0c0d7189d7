#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <memory>

#include "bench/commands/commands.h"
#include "scene/scenario/scenario.h"
#include "scene/scenario/scenario_writer.h"

namespace crowdbench::bench {

void add_schema(CLI::App& app, Run& run) {
  CLI::App* command = app.add_subcommand("schema", "Print the JSON Schema of a scenario, or its keys as a table");
  command->footer(
      "Examples:\n  crowdbench schema > scenario.schema.json\n  crowdbench schema --markdown | less\n"
      "  crowdbench schema --defaults > my.toml     a scenario with every key at its default");
  struct Options {
    bool markdown = false;
    bool defaults = false;
  };
  auto options = std::make_shared<Options>();
  auto* markdown = command->add_flag("--markdown", options->markdown,
                                     "every key with type, default, unit, range and meaning, as Markdown");
  command->add_flag("--defaults", options->defaults, "a scenario (TOML) with every key at its default")
      ->excludes(markdown);
  command->callback([options, &run] {
    run = [options] {
      if (options->markdown)
        fmt::print("{}", scene::scenario_markdown());
      else if (options->defaults)
        fmt::print("{}", scene::to_toml(scene::Scenario{}));
      else
        fmt::print("{}", scene::scenario_schema());
      return 0;
    };
  });
}

}  // namespace crowdbench::bench
