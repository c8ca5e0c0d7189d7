#include "bench/sweep/merge.h"

#include <fmt/format.h>

#include "bench/commands/command_line.h"
#include "bench/commands/commands.h"
#include "bench/commands/options.h"
#include "bench/experiments/score_rows.h"
#include "bench/sweep/sweep_run.h"
#include "core/counted.h"
#include "core/error.h"
#include "reports/exports/exports.h"

namespace crowdbench::bench {
namespace {

struct MergeOptions {
  std::string out;
  std::vector<std::string> shards;
  bool mixed = false, allow_missing = false, json = false;
};

constexpr int kNotEnough = 3;

int run_merge(const MergeOptions& options) {
  sweep::MergeRequest request;
  request.out = options.out;
  request.shards.assign(options.shards.begin(), options.shards.end());
  request.mixed = options.mixed;
  request.allow_missing = options.allow_missing;
  try {
    const sweep::MergeOutcome outcome = sweep::merge_shards(request);
    for (const std::string& remark : outcome.remarks) fmt::print(stderr, "crowdbench: warning: {}\n", remark);
    const sweep::PointStates states = sweep::states_of(outcome.contents);
    if (options.json) fmt::print("{}", reports::results_json(outcome.contents, score_docs(metrics::scores())));
    fmt::print(options.json ? stderr : stdout, "{}; {}; {}\n", states.text(),
               counted(request.shards.size(), "shard", "shards"), printable(options.out));
    return states.status();
  } catch (const sweep::MissingShards& missing) {
    fmt::print(stderr, "crowdbench: {}; measure them, or merge what there is: --allow-missing\n", missing.what);
    return kNotEnough;
  }
}

}  // namespace

void add_merge(Command& app, Run& run) {
  Command* command = app.add_subcommand("merge", "Put the shards of a sweep together, into one result file");
  command->footer(
      "It holds the same whatever number of shards it comes from, but for their times. `sweep PLAN --out FILE` then "
      "prints "
      "its tables.\nExit status: 0 done; 1 a point failed, or its picture check; 2 shards that do not belong together; "
      "3 "
      "shards or conditions\nare missing, or no point could be measured.\nExamples:\n  crowdbench merge "
      "textures.sqlite "
      "textures-*-of-8.sqlite");
  auto options = std::make_shared<MergeOptions>();
  command->add_option("OUT", options->out, "file to write; replaced when it exists")
      ->required()
      ->type_name("OUT.sqlite")
      ->output_file();
  command->add_option("SHARDS", options->shards, "files that `sweep --shard` made")
      ->required()
      ->type_name("SHARD.sqlite");
  command->add_flag("--mixed", options->mixed, "of different revisions or drivers too");
  command->add_flag("--allow-missing", options->allow_missing, "although shards or conditions are missing");
  add_json_option(*command, options->json, "print every row as JSON");
  command->callback([options, &run] { run = [options] { return run_merge(*options); }; });
}

}  // namespace crowdbench::bench
