#include <fmt/format.h>
#include <fmt/ranges.h>

#include <filesystem>
#include <memory>
#include <set>

#include "bench/commands/command_line.h"
#include "bench/commands/commands.h"
#include "bench/commands/options.h"
#include "bench/commands/score_commands.h"
#include "bench/experiments/score_rows.h"
#include "core/error.h"
#include "core/files.h"
#include "renderers/representation.h"
#include "reports/exports/cost_export.h"
#include "reports/exports/exports.h"
#include "reports/page/report_page.h"
#include "store/joined.h"
#include "store/store.h"

namespace crowdbench::bench {
namespace {

struct ReportOptions {
  metrics::ScoreTable table;
  std::vector<std::string> files;
  std::string out, markdown, csv, scores_csv, json, google_benchmark;
};

// The files' own names; where two are alike, as they were given.
std::vector<std::string> names_of(const std::vector<std::string>& files) {
  std::vector<std::string> names;
  for (const std::string& file : files) names.push_back(std::filesystem::path(file).filename().string());
  if (std::set<std::string>(names.begin(), names.end()).size() == names.size()) return names;
  if (std::set<std::string>(files.begin(), files.end()).size() < files.size())
    throw Error("report", "a file is named twice", "name each file once");
  return files;
}

int run_report(const ReportOptions& options) {
  if (options.out.empty() && options.markdown.empty() && options.csv.empty() && options.scores_csv.empty() &&
      options.json.empty() && options.google_benchmark.empty())
    throw Error("report", "nothing to write",
                "name at least one of --out, --markdown, --csv, --scores-csv, --json-out, --google-benchmark");
  if (options.files.size() > 1 &&
      !(options.csv.empty() && options.scores_csv.empty() && options.json.empty() && options.google_benchmark.empty()))
    throw Error("report", "these forms have no place for a file's name",
                "name one file, or --out and --markdown alone, which set files beside each other");
  const bool samples = !options.out.empty() || !options.json.empty() || !options.google_benchmark.empty();
  const std::vector<std::string> names = names_of(options.files);
  std::vector<NamedContents> each;
  for (size_t i = 0; i < names.size(); ++i)
    each.push_back({names[i], read_store(options.files[i], samples, !options.out.empty())});
  const StoreContents contents = joined(std::move(each));
  const std::string source = fmt::format("{}", fmt::join(names, ", "));
  const std::vector<reports::ScoreDoc> scores = score_docs(options.table);
  const auto write = [](const std::string& path, const auto& make) {
    if (path.empty()) return;
    write_file(path, std::string_view(make()));
    fmt::print("{}\n", path);
  };
  write(options.out, [&] {
    return reports::report_page(contents, {source, scores, renderers::floors_by_name(), pop_score_docs()});
  });
  write(options.markdown, [&] {
    std::string text = reports::report_markdown(contents, source, scores);
    for (const reports::Scene& scene : reports::scenes_of(contents, scores)) text += reports::cost_markdown(scene);
    return text;
  });
  write(options.csv, [&] { return reports::results_csv(contents); });
  write(options.scores_csv, [&] { return reports::scores_csv(contents); });
  write(options.json, [&] { return reports::results_json(contents, scores); });
  write(options.google_benchmark, [&] { return reports::google_benchmark_json(contents); });
  return 0;
}

}  // namespace

void add_report(Command& app, Run& run) { add_report(app, run, metrics::scores()); }

void add_report(Command& app, Run& run, metrics::ScoreTable table) {
  Command* command = app.add_subcommand(
      "report", "Tell what a result file says: a page that opens offline, tables, other tools' forms");
  command->footer(
      "Examples:\n  crowdbench report results.sqlite --out report.html\n  crowdbench report results.sqlite "
      "--google-benchmark "
      "baseline.json --csv results.csv\n  crowdbench report before.sqlite after.sqlite --out both.html");
  auto options = std::make_shared<ReportOptions>();
  options->table = table;
  command
      ->add_option("FILE", options->files,
                   "result file that `bench`, `demo`, `sweep` or a command with --db made; several are set beside each "
                   "other")
      ->required()
      ->type_name("FILE.sqlite");
  command->add_option("--out", options->out, "one self-contained HTML page")->type_name("FILE.html")->output_file();
  command->add_option("--markdown", options->markdown, "the same tables in Markdown")
      ->type_name("FILE.md")
      ->output_file();
  command->add_option("--csv", options->csv, "one row a measurement, units in the column names")
      ->type_name("FILE.csv")
      ->output_file();
  command->add_option("--scores-csv", options->scores_csv, "one row a score, with what was compared")
      ->type_name("FILE.csv")
      ->output_file();
  command->add_option("--json-out", options->json, "every row as JSON, samples included")
      ->type_name("FILE.json")
      ->output_file();
  command
      ->add_option("--google-benchmark", options->google_benchmark,
                   "Google Benchmark's JSON, for compare.py and trackers")
      ->type_name("FILE.json")
      ->output_file();
  command->callback([options, &run] { run = [options] { return run_report(*options); }; });
}

}  // namespace crowdbench::bench
