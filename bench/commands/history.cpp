#include "reports/model/history.h"

#include <fmt/format.h>

#include <memory>

#include "bench/commands/command_line.h"
#include "bench/commands/commands.h"
#include "bench/commands/options.h"
#include "core/error.h"
#include "core/files.h"
#include "core/json.h"
#include "core/progress.h"
#include "reports/page/history_page.h"
#include "store/store.h"

namespace crowdbench::bench {
namespace {

using reports::HistoryChange;
using reports::HistorySeries;
using reports::HistoryValue;

struct HistoryOptions {
  std::vector<std::string> files;
  std::string page;
  ChangePointOptions change;
  uint64_t window = ChangePointOptions{}.window;
  double least_percent = 2;
  bool json = false;
};

double relative_change(const ChangePoint& point) {
  return point.mean_before > 0 ? point.mean_after / point.mean_before - 1 : 0;
}

std::string method(const ChangePointOptions& options) {
  return fmt::format(
      "Change points by E-divisive means over windows of {} runs, kept where p is below {:g} and the level changes by "
      "more than {:g} %. When a point is dropped, both of its neighbours are judged anew.",
      options.window, options.max_p, 100 * options.min_magnitude);
}

Json json_of(const HistorySeries& series) {
  Json values = Json::array();
  for (const HistoryValue& value : series.values)
    values.push_back({{"value", value.value},
                      {"low", value.low},
                      {"high", value.high},
                      {"revision", value.revision},
                      {"started", value.started}});
  Json changes = Json::array();
  for (const HistoryChange& change : series.changes)
    changes.push_back({{"index", change.point.index},
                       {"revision", change.revision},
                       {"revision_before", change.revision_before},
                       {"started", change.started},
                       {"mean_before", change.point.mean_before},
                       {"mean_after", change.point.mean_after},
                       {"change", relative_change(change.point)},
                       {"p", change.point.p}});
  return {{"scenario", series.scenario},
          {"representation", series.key.representation},
          {"character", series.key.character},
          {"agents", series.key.agents},
          {"width_px", series.key.width},
          {"height_px", series.key.height},
          {"requested_occupancy", series.key.requested_occupancy},
          {"metric", series.metric},
          {"values", values},
          {"changes", changes}};
}

std::string text_of(const HistorySeries& series) {
  std::string out = fmt::format("{}: {} runs, now {:.4g} of the reference's {} time\n", series_name(series),
                                series.values.size(), series.values.back().value, series.metric);
  for (const HistoryChange& change : series.changes)
    out += fmt::format("  {:+.1f} % at {} ({}), after {}: {:.4g} to {:.4g}, p = {:.2g}\n",
                       100 * relative_change(change.point), change.revision, change.started, change.revision_before,
                       change.point.mean_before, change.point.mean_after, change.point.p);
  return out + (series.changes.empty() ? "  no change\n" : "");
}

int run_history(const HistoryOptions& options) {
  ChangePointOptions change = options.change;
  change.window = options.window;
  change.min_magnitude = options.least_percent / 100;
  std::vector<StoreContents> files;
  {
    Progress progress("reading", options.files.size());
    for (const std::string& file : options.files) {
      files.push_back(read_store(file, false, false));
      progress.advance();
    }
  }
  const std::vector<HistorySeries> all = reports::history_of(files, change);
  if (all.empty())
    throw Error("history", "no point was measured twice against its reference",
                "give result files of several runs of one `bench`");
  if (!options.page.empty()) write_file(options.page, std::string_view(history_page(all, method(change))));
  if (options.json) {
    Json series = Json::array();
    for (const HistorySeries& one : all) series.push_back(json_of(one));
    const Json out = {{"method", method(change)}, {"series", series}};
    fmt::print("{}\n", out.dump(2));
    return 0;
  }
  for (const HistorySeries& one : all) fmt::print("{}", text_of(one));
  fmt::print("{}\n", method(change));
  if (!options.page.empty()) fmt::print("{}\n", options.page);
  return 0;
}

}  // namespace

void add_history(Command& app, Run& run) {
  Command* command =
      app.add_subcommand("history", "Where the speed of a point changed for good, over the result files of many runs");
  command->footer(
      "Each run's time is taken over the reference's of the same rounds, so that runs of other days compare; runs are "
      "ordered by\ntheir start. A change is named by the first revision of the new level and the one before "
      "it.\nExamples:\n  crowdbench history nightly-*.sqlite --chart history.html\n"
      "  crowdbench history results.sqlite --json");
  auto options = std::make_shared<HistoryOptions>();
  command->add_option("FILE", options->files, "result files of `bench`, in any order")
      ->required()
      ->type_name("FILE.sqlite");
  command->add_option("--window", options->window, "runs that are looked at together")
      ->type_name("N")
      ->capture_default_str()
      ->whole_number(4, 1000);
  command->add_option("--max-p", options->change.max_p, "of a change that is kept")
      ->type_name("P")
      ->capture_default_str()
      ->number(1e-9, 0.5);
  command->add_option("--least", options->least_percent, "a change of a level by less is none, per cent")
      ->type_name("PCT")
      ->capture_default_str()
      ->number(0, 1000);
  command->add_option("--chart", options->page, "a page with every point's runs and changes")
      ->type_name("FILE.html")
      ->output_file();
  add_json_option(*command, options->json);
  command->callback([options, &run] { run = [options] { return run_history(*options); }; });
}

}  // namespace crowdbench::bench
