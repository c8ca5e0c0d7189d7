#include <fmt/format.h>

#include <memory>

#include "bench/commands/command_line.h"
#include "bench/commands/commands.h"
#include "bench/commands/score_commands.h"
#include "bench/experiments/score_rows.h"
#include "core/error.h"
#include "core/files.h"
#include "reports/exports/bencher.h"
#include "reports/exports/exports.h"
#include "reports/exports/frame_log.h"
#include "store/store.h"

namespace crowdbench::bench {
namespace {

struct ExportOptions {
  metrics::ScoreTable table;
  std::string file;
  std::string csv, scores_csv, json, google_benchmark, bencher, frame_log, markdown;
};

int run_export(const ExportOptions& options) {
  if (options.csv.empty() && options.scores_csv.empty() && options.json.empty() && options.google_benchmark.empty() &&
      options.bencher.empty() && options.frame_log.empty() && options.markdown.empty())
    throw Error("export", "nothing to write",
                "name at least one of --csv, --scores-csv, --json-out, --google-benchmark, --bencher, --frame-log, "
                "--markdown");
  const StoreContents contents = read_store(options.file, true, false);
  const std::vector<reports::ScoreDoc> scores = score_docs(options.table);
  const auto write = [](const std::string& path, const auto& make) {
    if (path.empty()) return;
    write_file(path, std::string_view(make()));
    fmt::print("{}\n", path);
  };
  write(options.csv, [&] { return reports::results_csv(contents); });
  write(options.scores_csv, [&] { return reports::scores_csv(contents); });
  write(options.json, [&] { return reports::results_json(contents, scores); });
  write(options.google_benchmark, [&] { return reports::google_benchmark_json(contents); });
  write(options.bencher, [&] { return reports::bencher_json(contents); });
  write(options.frame_log, [&] { return reports::frame_log_csv(contents); });
  const std::string source = std::filesystem::path(options.file).filename().string();
  write(options.markdown, [&] { return reports::report_markdown(contents, source, scores); });
  return 0;
}

}  // namespace

void add_export(Command& app, Run& run) { add_export(app, run, metrics::scores()); }

void add_export(Command& app, Run& run, metrics::ScoreTable table) {
  Command* command = app.add_subcommand("export", "A result file in other tools' forms: tables, trackers, frame logs");
  command->footer(
      "Column names carry their units. Parquet is not among them: Debian 12 has no library that writes it; read the "
      "CSV with what\nwrites yours.\nExamples:\n  crowdbench export results.sqlite --csv results.csv --bencher "
      "bencher.json\n  crowdbench export results.sqlite --frame-log frames.csv");
  auto options = std::make_shared<ExportOptions>();
  options->table = table;
  command->add_option("FILE", options->file, "result file")->required()->type_name("FILE.sqlite");
  const auto add = [&](const char* name, std::string& target, const char* meaning, const char* type) {
    command->add_option(name, target, meaning)->type_name(type)->output_file();
  };
  add("--csv", options->csv, "one row a measurement", "FILE.csv");
  add("--scores-csv", options->scores_csv, "one row a score, with what was compared", "FILE.csv");
  add("--json-out", options->json, "every row as JSON, samples included", "FILE.json");
  add("--google-benchmark", options->google_benchmark, "Google Benchmark's JSON, for compare.py and trackers",
      "FILE.json");
  add("--bencher", options->bencher, "Bencher's metric format: medians, intervals and scores by point", "FILE.json");
  add("--frame-log", options->frame_log, "every timed frame, under PresentMon's column names", "FILE.csv");
  add("--markdown", options->markdown, "the report's tables", "FILE.md");
  command->callback([options, &run] { run = [options] { return run_export(*options); }; });
}

}  // namespace crowdbench::bench
