#include <fmt/format.h>

#include <memory>

#include "bench/commands/command_line.h"
#include "bench/commands/commands.h"
#include "core/json.h"
#include "metrics/causes.h"
#include "metrics/popping.h"
#include "metrics/registry.h"
#include "reports/exports/results_schema.h"
#include "scene/scenario/scenario.h"
#include "scene/scenario/scenario_writer.h"

namespace crowdbench::bench {

namespace {

// The columns of a result file, and what `causes` of other commands' JSON holds.
std::string results_json() {
  Json out = Json::parse(reports::results_schema_json());
  out["causes"] = Json::array();
  for (const metrics::CauseDoc& doc : metrics::causes()) {
    Json cause = {{"name", doc.name}, {"title", doc.title}};
    cause["put_in_by_drawing"] = doc.drawn.empty() ? Json(nullptr) : Json(doc.drawn);
    cause["put_in_by_comparing"] = doc.read.empty() ? Json(nullptr) : Json(doc.read);
    out["causes"].push_back(std::move(cause));
  }
  return out.dump(2) + "\n";
}

}  // namespace

void add_schema(Command& app, Run& run) {
  Command* command = app.add_subcommand(
      "schema", "Print the JSON Schema of a scenario, its keys as a table, or the columns of a result file");
  command->footer(
      "Examples:\n  crowdbench schema > scenario.schema.json\n  crowdbench schema --markdown | less\n"
      "  crowdbench schema --defaults > my.toml     a scenario with every key at its default\n"
      "  crowdbench schema --results | less         every column of a result file\n"
      "  crowdbench schema --scores | less          what every score is");
  struct Options {
    bool markdown = false;
    bool defaults = false;
    bool results = false;
    bool scores = false;
    bool json = false;
  };
  auto options = std::make_shared<Options>();
  auto* markdown = command->add_flag("--markdown", options->markdown,
                                     "every key with type, default, unit, range and meaning, as Markdown");
  auto* defaults = command->add_flag("--defaults", options->defaults, "a scenario (TOML) with every key at its default")
                       ->excludes(markdown);
  auto* results = command
                      ->add_flag("--results", options->results,
                                 "every table and column of a result file with type, unit and meaning, as Markdown")
                      ->excludes(markdown)
                      ->excludes(defaults);
  command
      ->add_flag("--scores", options->scores, "every score with unit, direction, range, needs and formula, as Markdown")
      ->excludes(markdown)
      ->excludes(defaults)
      ->excludes(results);
  command->add_flag("--json", options->json, "with --results: the same as JSON")->needs(results);
  command->callback([options, &run] {
    run = [options] {
      if (options->results)
        fmt::print("{}",
                   options->json ? results_json() : reports::results_schema_markdown() + metrics::causes_markdown());
      else if (options->scores)
        fmt::print("{}{}", metrics::scores_markdown(metrics::scores()), metrics::pop_scores_markdown());
      else if (options->markdown)
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
