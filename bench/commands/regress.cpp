#include "bench/experiments/regress.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <memory>

#include "bench/commands/command_line.h"
#include "bench/commands/commands.h"
#include "bench/commands/options.h"
#include "bench/commands/regress_output.h"
#include "bench/commands/score_bounds.h"
#include "bench/experiments/build_runs.h"
#include "core/error.h"
#include "core/files.h"
#include "core/hodges_lehmann.h"

namespace crowdbench::bench {
namespace {

struct RegressOptions {
  std::string baseline, current;
  std::vector<std::string> programs;
  std::string bench;
  int runs = 8;
  double effect_percent = 1;
  double detect_percent = 5;
  double picture_percent = 0.1;
  std::optional<double> scatter_percent;
  std::string correction = "holm";
  std::vector<std::string> tolerances;
  RegressLimits limits;
  std::string markdown, junit, explain, pictures;
  bool json = false;
};

Correction parse_correction(const std::string& text) {
  if (text == "holm") return Correction::holm;
  if (text == "bh") return Correction::benjamini_hochberg;
  if (text == "none") return Correction::none;
  throw Error("--correction", fmt::format("'{}' is not a correction", text), "use holm, bh or none");
}

RegressLimits limits_of(const RegressOptions& options) {
  RegressLimits limits = options.limits;
  limits.least_effect = options.effect_percent / 100;
  limits.detect = options.detect_percent / 100;
  limits.picture_share = options.picture_percent / 100;
  if (options.scatter_percent) limits.run_scatter = *options.scatter_percent / 100;
  limits.correction = parse_correction(options.correction);
  if (limits.detect <= limits.least_effect)
    throw Error("--detect",
                fmt::format("{:g} % is not more than the least effect of {:g} %", options.detect_percent,
                            options.effect_percent),
                "what must be found has to be larger than what counts as nothing");
  for (const std::string& text : options.tolerances) {
    const ScoreValue given = parse_score_value(text, "--tolerance", metrics::scores());
    limits.score_tolerances[std::string(given.score->name)] = given.value;
  }
  return limits;
}

// Logarithms of the reference's own time, its median in each run and point.
std::vector<double> reference_times(const std::vector<StoreContents>& side) {
  std::vector<double> logarithms;
  for (const StoreContents& contents : side)
    for (const MeasurementRow& row : contents.measurements)
      if (row.key.representation == row.reference && row.cpu_ns && row.frame_ns) {
        const std::string& headline = contents.runs.back().headline;
        const TimeSummary& time = headline == "gpu" && row.gpu_ns ? *row.gpu_ns
                                  : headline == "wall"            ? *row.frame_ns
                                                                  : *row.cpu_ns;
        if (time.median > 0) logarithms.push_back(std::log(time.median));
      }
  return logarithms;
}

// Runs follow each other A B A B: pairs of one place in the order are of neighbouring processes.
std::optional<Interval> drift_of(const BuildRuns& runs) {
  const std::vector<double> a = reference_times(runs.a);
  const std::vector<double> b = reference_times(runs.b);
  std::vector<double> differences;
  for (size_t i = 0; i < std::min(a.size(), b.size()); ++i) differences.push_back(b[i] - a[i]);
  if (differences.empty()) return std::nullopt;
  const Interval interval = hodges_lehmann(differences).interval;
  return Interval{std::expm1(interval.low), std::expm1(interval.high)};
}

int say(const RegressReport& report, const RegressOptions& options) {
  if (!options.markdown.empty()) write_file(options.markdown, std::string_view(regress_markdown(report)));
  if (!options.junit.empty()) write_file(options.junit, std::string_view(regress_junit(report)));
  if (!options.pictures.empty()) make_folder(options.pictures);
  if (!options.explain.empty())
    fmt::print("{}", regress_explanation(report, options.explain, options.pictures));
  else if (options.json)
    fmt::print("{}\n", regress_json(report).dump(2));
  else
    fmt::print("{}", regress_text(report));
  return exit_status(report);
}

// A result file, or all of a folder.
std::vector<StoreContents> read_side(const std::string& path) {
  if (!std::filesystem::is_directory(path)) return {read_store(path, true)};
  std::vector<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::directory_iterator(path))
    if (entry.path().extension() == ".sqlite") files.push_back(entry.path());
  if (files.empty())
    throw Error(path, "holds no result file", "give a file of `bench`, or a folder of such files (.sqlite), one a run");
  std::sort(files.begin(), files.end());
  std::vector<StoreContents> out;
  for (const auto& file : files) out.push_back(read_store(file, true));
  return out;
}

int run_regress(const RegressOptions& options) {
  const RegressLimits limits = limits_of(options);
  if (!options.programs.empty()) {
    if (options.programs.size() != 2)
      throw Error("--program", fmt::format("is given {} times", options.programs.size()),
                  "give it twice: the baseline's program first");
    if (!options.baseline.empty())
      throw Error("BASELINE", "files and --program are both given", "give either two files or two programs");
    BuildRuns runs = run_builds(options.programs[0], options.programs[1], options.bench, options.runs);
    RegressReport report = regress(runs.a, runs.b, limits, metrics::scores());
    report.drift = drift_of(runs);
    return say(report, options);
  }
  if (options.baseline.empty() || options.current.empty())
    throw Error("regress", "two result files are needed", "`crowdbench regress baseline current`, or --program twice");
  const std::vector<StoreContents> baseline = read_side(options.baseline);
  const std::vector<StoreContents> current = read_side(options.current);
  return say(regress(baseline, current, limits, metrics::scores()), options);
}

void add_limits(Command& command, RegressOptions& options) {
  command.add_option("--effect", options.effect_percent, "a change of a time by less counts as none, per cent")
      ->type_name("PCT")
      ->capture_default_str()
      ->number(0, 1000);
  command
      .add_option("--detect", options.detect_percent,
                  "a slow-down that the data must be able to exclude, per cent; else the exit status is 3")
      ->type_name("PCT")
      ->capture_default_str()
      ->number(0.01, 1000);
  command.add_option("--level", options.limits.level, "of the test, after the correction")
      ->type_name("P")
      ->capture_default_str()
      ->number(1e-6, 0.5);
  command.add_option("--correction", options.correction, "over all points: holm, bh (Benjamini-Hochberg) or none")
      ->type_name("NAME")
      ->capture_default_str();
  command
      .add_option(
          "--run-scatter", options.scatter_percent,
          "what runs are known to differ by without any change (standard deviation), per cent; else five of each "
          "tell")
      ->type_name("PCT")
      ->number(0, 1000);
  command
      .add_option("--tolerance", options.tolerances,
                  "how far a score may get worse, in its unit (else 2 % of its distance from equal); repeat")
      ->type_name("SCORE=VALUE")
      ->allow_extra_args(false);
  command.add_option("--picture-share", options.picture_percent, "of a picture's pixels that may change, per cent")
      ->type_name("PCT")
      ->capture_default_str()
      ->number(0, 100);
}

}  // namespace

void add_regress(Command& app, Run& run) {
  Command* command =
      app.add_subcommand("regress", "Whether a build draws slower or wronger than another one, from result files");
  command->footer(
      "Points are paired by scenario and key. What is compared is the ratio to the reference's time of the same "
      "rounds, by a rank\ntest with a least effect and a correction over all points; scores and pictures by "
      "thresholds. Five runs of each side say\nhow much runs differ without any change: a folder's files, or --runs "
      "of two programs. Exit status 0: nothing is worse;\n1: something is; 3: not enough data.\nExamples:\n  "
      "crowdbench "
      "regress baseline current --markdown regress.md --junit regress.xml\n  crowdbench regress "
      "--program old/crowdbench --program new/crowdbench --bench \"plaza.toml --agents 250 --occupancy 0.15\"\n  "
      "crowdbench regress baseline.sqlite current.sqlite --run-scatter 0.5 --explain 3 --pictures why");
  auto options = std::make_shared<RegressOptions>();
  command->add_option("BASELINE", options->baseline, "result file of `bench`, before, or a folder of them, one a run")
      ->type_name("FILE.sqlite|FOLDER");
  command->add_option("CURRENT", options->current, "the same, after")->type_name("FILE.sqlite|FOLDER");
  const Option* program =
      command
          ->add_option("--program", options->programs,
                       "in place of files: two programs of crowdbench, the baseline's first, run in turns A B A B")
          ->type_name("FILE")
          ->allow_extra_args(false);
  command->add_option("--bench", options->bench, "with --program: what both are asked for, as after `crowdbench bench`")
      ->type_name("ARGUMENTS")
      ->needs(program);
  command->add_option("--runs", options->runs, "with --program: processes of each; under 5 no time has a verdict")
      ->type_name("K")
      ->capture_default_str()
      ->whole_number(1, 1000)
      ->needs(program);
  add_limits(*command, *options);
  command->add_option("--markdown", options->markdown, "the verdicts for a pull request")
      ->type_name("FILE.md")
      ->output_file();
  command->add_option("--junit", options->junit, "the verdicts for a build server")
      ->type_name("FILE.xml")
      ->output_file();
  const Option* explain = command
                              ->add_option("--explain", options->explain,
                                           "all about a point: its number in the table, or a piece of its text")
                              ->type_name("POINT");
  command
      ->add_option("--pictures", options->pictures, "with --explain: the pictures of both sides and their difference")
      ->type_name("FOLDER")
      ->output_folder()
      ->needs(explain);
  add_json_option(*command, options->json);
  command->callback([options, &run] { run = [options] { return run_regress(*options); }; });
}

}  // namespace crowdbench::bench
