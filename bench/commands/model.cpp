#include <fmt/format.h>

#include <algorithm>
#include <memory>

#include "bench/commands/command_line.h"
#include "bench/commands/commands.h"
#include "bench/commands/options.h"
#include "bench/experiments/score_rows.h"
#include "core/error.h"
#include "core/files.h"
#include "core/json.h"
#include "core/progress.h"
#include "reports/exports/cost_export.h"
#include "reports/model/scene.h"
#include "store/store.h"

namespace crowdbench::bench {
namespace {

struct ModelOptions {
  std::vector<std::string> files;
  std::string markdown;
  bool json = false;
};

// Names are of a file: they must not drive the terminal.
void print_lines(std::string_view text) {
  while (!text.empty()) {
    const std::string_view line = text.substr(0, text.find('\n'));
    fmt::print("{}\n", printable(line, line.size()));
    text.remove_prefix(std::min(text.size(), line.size() + 1));
  }
}

// Each file by itself: times of two files may be of two machines.
int run_model(const ModelOptions& options) {
  Json all = Json::array();
  std::string text;
  {
    Progress progress("models", options.files.size());
    for (const std::string& file : options.files) {
      const StoreContents contents = read_store(file, false, false);
      for (const reports::Scene& scene : reports::scenes_of(contents, score_docs(metrics::scores()))) {
        Json one = {{"file", file}};
        one["scene"] = reports::cost_json(scene);
        all.push_back(one);
        text += reports::cost_markdown(scene);
      }
      progress.advance();
    }
  }
  if (text.empty()) throw Error("model", "no point was timed", "give result files of `bench` or `sweep` with times");
  if (!options.markdown.empty()) write_file(options.markdown, std::string_view(text.substr(1)));
  if (options.json) {
    const Json out = {{"scenes", all}};
    fmt::print("{}\n", out.dump(2));
  } else {
    print_lines(std::string_view(text).substr(1));
  }
  return 0;
}

}  // namespace

void add_model(Command& app, Run& run) {
  Command* command = app.add_subcommand(
      "model", "What a frame costs by agents, pixels and work; where representations break even; who is beaten");
  command->footer(
      "time = a + b agents + c covered pixels + ..., for each representation: of all subsets of terms the one that "
      "predicts best\nwhat it was not fitted to. Its accuracy is of points that neither terms nor coefficients were "
      "chosen by. Break-even is told\nwithin the agents and occupancies that were measured, with the interval of "
      "predicted ratios.\nExamples:\n  crowdbench model results.sqlite\n  crowdbench model results.sqlite --markdown "
      "model.md --json");
  auto options = std::make_shared<ModelOptions>();
  command->add_option("FILE", options->files, "result files of `bench` or `sweep`, each by itself")
      ->required()
      ->type_name("FILE.sqlite");
  command->add_option("--markdown", options->markdown, "the text as a file")->type_name("FILE.md")->output_file();
  add_json_option(*command, options->json);
  command->callback([options, &run] { run = [options] { return run_model(*options); }; });
}

}  // namespace crowdbench::bench
