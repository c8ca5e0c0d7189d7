#include "bench/stability/stability.h"

#include <fmt/format.h>

#include <memory>
#include <optional>

#include "bench/commands/command_line.h"
#include "bench/commands/commands.h"
#include "bench/commands/options.h"
#include "bench/commands/scene_options.h"
#include "bench/commands/stability_output.h"
#include "bench/timing/run_facts.h"
#include "core/command_line.h"
#include "core/error.h"
#include "core/files.h"
#include "renderers/gl/context.h"
#include "store/store.h"

namespace crowdbench::bench {
namespace {

struct StabilityOptions {
  std::vector<std::string> representations;
  StabilityRequest request;
  std::string markdown, page, results, device;
  bool list = false;
  bool no_cache = false;
  bool json = false;
};

int run_stability_command(const StabilityOptions& options) {
  StabilityRequest request = options.request;
  if (!options.representations.empty()) request.representations = parse_representations(options.representations);
  request.use_cache = !options.no_cache;
  const std::vector<StabilityCase> cases = chosen_cases(request);
  if (options.list) {
    fmt::print("{}", stability_list(cases));
    return 0;
  }
  if (!options.page.empty()) stability_page_of({});  // where pages cannot be made, nothing is drawn
  std::optional<StoreWriter> store;
  if (!options.results.empty()) store.emplace(options.results);  // refused before anything is drawn
  StabilityReport report;
  report.small = request.small;
  const auto context = open_context(options.device);
  report.renderer = context->renderer();
  report.rows = run_stability(*context, request, cases);
  if (store) {
    store->begin();
    const RunRow run =
        describe_run(*context, choose_timing_method(*context), scene::Scenario(), "stability", command_line());
    for (const StabilityCaseRow& row : stability_rows(report, store->write(run))) store->write(row);
    store->commit();
  }
  if (!options.markdown.empty()) write_file(options.markdown, std::string_view(stability_markdown(report)));
  if (!options.page.empty()) write_file(options.page, std::string_view(stability_page_of(report)));
  if (options.json)
    fmt::print("{}\n", stability_json(report).dump(2));
  else
    fmt::print("{}", stability_text(report));
  return failed(report) == 0 ? 0 : 1;
}

}  // namespace

void add_stability(Command& app, Run& run) {
  Command* command =
      app.add_subcommand("stability", "What holds at the extremes: every case measured beside its bound");
  command->footer(
      "Each case says what was asked, what was measured at worst and where, and the bound with where it comes from.\n"
      "Without options every case is asked of every representation. Exit status 1: a case does not hold.\n\n"
      "Examples:\n"
      "  crowdbench stability\n"
      "  crowdbench stability --representation relief --case eye --case world_1e7\n"
      "  crowdbench stability --small --markdown holds.md --page holds.html --db results.sqlite\n"
      "  crowdbench stability --list");
  auto options = std::make_shared<StabilityOptions>();
  add_representation_option(*command, options->representations, "of whom it is asked (default: every one)");
  command->add_option("--case", options->request.cases, "a case or a group of cases; may be given several times")
      ->type_name("NAME")
      ->expected(1)
      ->take_all()
      ->allow_extra_args(false);
  command->add_flag("--list", options->list, "print the cases and where their bounds come from, measure nothing");
  const Option* small = command->add_flag("--small", options->request.small, "smaller pictures and fewer cases");
  command->add_flag("--full", options->request.full, "also the cases that take minutes or gigabytes")->excludes(small);
  command->add_option("--markdown", options->markdown, "a table of what holds, a line a case with the worst of all")
      ->type_name("FILE.md")
      ->output_file();
  command->add_option("--page", options->page, "a page of every row, and of those that fail the worst pixel enlarged")
      ->type_name("FILE.html")
      ->output_file();
  add_results_option(*command, options->results);
  command->add_flag("--no-cache", options->no_cache, "neither read nor write stored bakes");
  add_device_option(*command, options->device);
  add_json_option(*command, options->json);
  command->callback([options, &run] { run = [options] { return run_stability_command(*options); }; });
}

}  // namespace crowdbench::bench
