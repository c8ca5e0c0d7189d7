#include <fmt/format.h>

#include "bench/commands/command_line.h"
#include "bench/commands/commands.h"
#include "bench/commands/options.h"
#include "bench/commands/scene_options.h"
#include "bench/experiments/score_rows.h"
#include "bench/sweep/estimate.h"
#include "bench/sweep/schedulers.h"
#include "bench/sweep/sweep_run.h"
#include "bench/sweep/sweep_table.h"
#include "core/counted.h"
#include "core/error.h"
#include "core/files.h"
#include "core/term_status.h"
#include "renderers/gl/context.h"
#include "reports/exports/exports.h"

namespace crowdbench::bench {
namespace {
namespace fs = std::filesystem;

struct SweepOptions {
  std::string plan, shard, out, markdown, device;
  bool dry_run = false, mixed = false, json = false, submit = false;
  std::optional<uint32_t> slurm, openjd;
};

// Beside where the user is, by the name of the plan's file.
fs::path out_of(const SweepOptions& options, const sweep::Shard& shard) {
  if (!options.out.empty()) return options.out;
  const fs::path whole = fs::path(options.plan).stem().string() + ".sqlite";
  return options.shard.empty() ? whole : sweep::shard_file(whole, shard.index, shard.count);
}

int write_jobs(const SweepOptions& options, const sweep::Plan& plan, const fs::path& out) {
  const uint32_t shards = options.slurm ? *options.slurm : *options.openjd;
  sweep::ShardJobs jobs{plan.name, program_directory() / "crowdbench", fs::absolute(options.plan), fs::absolute(out),
                        shards};
  if (!options.device.empty()) jobs.options = {"--device", options.device};
  if (options.mixed) jobs.options.emplace_back("--mixed");
  const std::string stem = fs::path(out).replace_extension().string();
  if (options.openjd) {
    const std::string file = stem + ".openjd.json";
    write_file(file, std::string_view(sweep::openjd_template(jobs)));
    fmt::print("{}\n", file);
    return 0;
  }
  const std::string array = stem + ".sbatch";
  const std::string merge = stem + "-merge.sbatch";
  write_file(array, std::string_view(sweep::slurm_array(jobs)));
  write_file(merge, std::string_view(sweep::slurm_merge(jobs)));
  fmt::print("{}\n{}\n", array, merge);
  if (options.submit) fmt::print("jobs {}\n", sweep::submit(array, merge));
  return 0;
}

void say_tables(const SweepOptions& options, const sweep::Plan& plan, const StoreContents& contents) {
  const std::string text = sweep::sweep_text(plan, contents);
  if (!options.markdown.empty()) write_file(options.markdown, std::string_view(text));
  if (options.json)
    fmt::print("{}", reports::results_json(contents, score_docs(metrics::scores())));
  else
    fmt::print("{}", text);
}

// Exit status; nothing where the machine could not draw, which another might.
std::optional<sweep::SweepOutcome> measure(const SweepOptions& options, const sweep::Plan& plan,
                                           const sweep::Shard& shard, const fs::path& out) {
  set_term_status(sweep::kRetryStatus);
  std::unique_ptr<gl::Context> context;
  try {
    context = open_context(options.device);
  } catch (const Error& error) {
    if (options.shard.empty() || !options.device.empty()) throw;
    fmt::print(stderr, "crowdbench: {}\n", error.what());
    return std::nullopt;
  }
  const TimingMethod method = choose_timing_method(*context);
  return sweep::run_shard(*context, method, plan, shard, out, options.mixed);
}

int run_sweep_command(const SweepOptions& options) {
  const sweep::Plan plan = sweep::read_plan(options.plan);
  const sweep::Shard shard = options.shard.empty() ? sweep::Shard() : sweep::parse_shard(options.shard);
  const fs::path out = out_of(options, shard);
  if (options.slurm || options.openjd) return write_jobs(options, plan, out);
  const sweep::Estimate estimate = sweep::estimate(plan, shard, out);
  if (options.dry_run) {
    fmt::print("{}", sweep::dry_run_text(plan, shard, estimate));
    return 0;
  }
  if (sweep::is_finished(out, plan, shard)) {
    fmt::print(stderr, "{} holds all of it already\n", printable(out.string()));
  } else {
    const std::optional<sweep::SweepOutcome> outcome = measure(options, plan, shard, out);
    if (!outcome) return sweep::kRetryStatus;
    fmt::print(stderr, "{} of {} measured, {} taken from the file; the sweep itself took {:.1f} % of the time; {}\n",
               outcome->measured, counted(outcome->cells, "condition", "conditions"), outcome->held,
               outcome->seconds > 0 ? 100 * (1 - outcome->measuring_s / outcome->seconds) : 0.0,
               printable(out.string()));
  }
  const StoreContents contents = read_store(out, false, false);
  say_tables(options, plan, contents);
  const sweep::PointStates states = sweep::states_of(contents);
  fmt::print(stderr, "{}\n", states.text());
  return contents.sweep_points.empty() ? 0 : states.status();
}

}  // namespace

void add_sweep(Command& app, Run& run) {
  Command* command =
      app.add_subcommand("sweep", "Measure every point of a plan, into a result file, and tabulate them");
  command->footer(
      "A plan is a TOML file that says what varies: keys of a scenario and options of representations, as lists, "
      "ranges or\nsamples; bench/plans holds examples, and bench/sweep/README.md says all there is. Ended by whatever, "
      "the same command goes\non where it was; of the condition in hand, whose points are measured together, nothing "
      "is "
      "kept.\nExit status: 0 done; 1 a point failed, or its picture check; 2 a mistake in the plan or the command; 3 "
      "no "
      "point could be\nmeasured; 75 not yet done (SIGTERM, or no device), run it again, perhaps elsewhere.\nExamples:\n"
      "  crowdbench sweep bench/plans/texture_size.toml --dry-run\n"
      "  crowdbench sweep bench/plans/texture_size.toml --out textures.sqlite --markdown textures.md\n"
      "  crowdbench sweep bench/plans/texture_size.toml --shard 2/8\n"
      "  crowdbench sweep bench/plans/texture_size.toml --slurm 8 --submit");
  auto options = std::make_shared<SweepOptions>();
  command->add_option("PLAN", options->plan, "plan of a sweep")->required()->type_name("PLAN.toml");
  command->add_option("--out", options->out, "result file; continued where it was begun (the plan's name, here)")
      ->type_name("FILE.sqlite")
      ->output_file();
  command->add_option("--shard", options->shard, "measure shard I of K, from 1, which `merge` puts together")
      ->type_name("I/K");
  command->add_flag("--dry-run", options->dry_run, "list the points, and about what they take in time and on disk");
  command->add_flag("--mixed", options->mixed, "go on with a file that another revision or driver has begun");
  command->add_option("--markdown", options->markdown, "the tables of the end")->type_name("FILE.md")->output_file();
  Option* slurm = command->add_option("--slurm", options->slurm, "write a Slurm job array of K shards, and its merge")
                      ->type_name("K")
                      ->whole_number(1, sweep::kMostShards)
                      ->excludes("--shard")
                      ->excludes("--markdown");
  command->add_flag("--submit", options->submit, "hand them to sbatch")->needs(slurm);
  command->add_option("--openjd", options->openjd, "write an Open Job Description template of K shards and their merge")
      ->type_name("K")
      ->whole_number(1, sweep::kMostShards)
      ->excludes(slurm)
      ->excludes("--shard")
      ->excludes("--markdown");
  add_device_option(*command, options->device);
  add_json_option(*command, options->json, "print every row of the result file as JSON instead of the tables");
  command->callback([options, &run] { run = [options] { return run_sweep_command(*options); }; });
}

}  // namespace crowdbench::bench
