#include "reports/exports/exports.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "core/counted.h"
#include "core/csv.h"
#include "core/error.h"
#include "core/json.h"
#include "core/statistics.h"
#include "reports/exports/markdown_cell.h"
#include "reports/exports/point_path.h"
#include "reports/exports/scores_markdown.h"
#include "reports/exports/side_markdown.h"
#include "reports/model/answer.h"
#include "reports/model/crossovers.h"
#include "reports/model/number_text.h"
#include "reports/model/side_by_side.h"
#include "reports/model/sweep_settings.h"
#include "reports/model/tuning_text.h"
#include "store/columns.h"

namespace crowdbench::reports {
namespace {

std::map<int64_t, const RunRow*> runs_by_id(const StoreContents& contents) {
  std::map<int64_t, const RunRow*> runs;
  for (const RunRow& run : contents.runs) runs[run.id] = &run;
  return runs;
}

Json number(double value) {
  if (std::isnan(value)) return nullptr;
  if (std::isinf(value)) return value > 0 ? "inf" : "-inf";
  return value;
}

std::string csv_field(const Json& value) {
  if (value.is_null()) return {};
  return value.is_string() ? crowdbench::csv_field(value.text()) : value.dump();
}

Json json_of(const Value& value) {
  return std::visit(
      []<typename T>(const T& held) -> Json {
        if constexpr (std::is_same_v<T, std::monostate>)
          return nullptr;
        else if constexpr (std::is_same_v<T, double>)
          return number(held);
        else
          return held;
      },
      value);
}

// Every column of one row in the order of the description; rows that it holds are added under their table's name,
// scores as an object of name and value.
template <typename Row>
Json row_json(const Row& row) {
  Json json = Json::object();
  for (const Field<Row>& field : table<Row>().fields) json[field.column.name] = json_of(field.get(row));
  if constexpr (std::is_same_v<Row, ComparisonRow>) {
    Json scores = Json::object();
    Json reasons = Json::object();
    for (const ScoreRow& score : row.scores) {
      scores[score.name] = score.value ? number(*score.value) : Json(nullptr);
      if (!score.reason.empty()) reasons[score.name] = score.reason;
    }
    json["scores"] = std::move(scores);
    json["reasons"] = std::move(reasons);
  } else if constexpr (OwnsRows<Row>) {
    const auto& held = row.*Owned<Row>::rows;
    Json parts = Json::array();
    for (const auto& part : held) parts.push_back(row_json(part));
    if (!held.empty()) json[table<std::decay_t<decltype(held.front())>>().description.rows] = std::move(parts);
  }
  return json;
}

// Records of one CSV, field by field.
class Csv {
 public:
  // The columns of a row that fit into a cell. ids: also the row's own id.
  template <typename Row>
  void add(const Row& row, bool ids = true) {
    for (const Field<Row>& field : table<Row>().fields)
      if (!field.column.bulky && (ids || !field.column.key)) put(csv_field(json_of(field.get(row))));
  }
  template <typename Row>
  void add_names(bool ids = true) {
    for (const Column& column : table<Row>().description.columns)
      if (!column.bulky && (ids || !column.key)) put(column.name);
  }
  void end_record() {
    text_ += "\r\n";
    first_ = true;
  }
  std::string take() { return std::move(text_); }

 private:
  void put(const std::string& field) {
    if (!first_) text_ += ',';
    text_ += field;
    first_ = false;
  }
  std::string text_;
  bool first_ = true;
};

// For people: the value with its unit.
std::string value_text(const Column& column, const Value& value) {
  if (value == Value() || value == Value(std::string())) return "–";
  if (const auto* flag = std::get_if<bool>(&value)) return *flag ? "yes" : "no";
  if (const auto* text = std::get_if<std::string>(&value)) return markdown_cell(*text);
  const std::string unit = column.unit.empty() ? "" : " " + column.unit;
  if (const auto* real = std::get_if<double>(&value)) {
    if (column.unit == "ns") return time_text(*real);
    if (column.unit == "fraction") return percent_text(*real);
    return fmt::format("{:.4g}{}", *real, unit);
  }
  const uint64_t count = std::holds_alternative<uint64_t>(value) ? std::get<uint64_t>(value)
                                                                 : static_cast<uint64_t>(std::get<int64_t>(value));
  if (column.unit == "bytes") return bytes_text(count);
  return column.type == ColumnType::seed ? std::to_string(count) : count_text(count) + unit;
}

std::string percent_or_dash(double occupancy) { return occupancy > 0 ? percent_text(occupancy) : "–"; }

// The mean and the standard deviation (n - 1) that Google Benchmark's readers expect beside the median.
std::optional<double> deviation(const std::vector<double>& values) {
  if (values.size() < 2) return std::nullopt;
  double mean = 0;
  for (const double value : values) mean += value / static_cast<double>(values.size());
  double sum = 0;
  for (const double value : values) sum += (value - mean) * (value - mean);
  return std::sqrt(sum / static_cast<double>(values.size() - 1));
}
double mean_of(const std::vector<double>& values) {
  double mean = 0;
  for (const double value : values) mean += value / static_cast<double>(values.size());
  return mean;
}

// Every column of the largest timed crowd of each representation, one a line; columns without any value are left out.
std::string largest_crowds(const Scene& scene) {
  std::vector<const MeasurementRow*> largest;
  for (const std::string& name : scene.representations) {
    const MeasurementRow* of = nullptr;
    for (const MeasurementRow* row : scene.rows)
      if (row->key.representation == name && is_timed(*row) && (of == nullptr || row->key.agents > of->key.agents))
        of = row;
    if (of != nullptr) largest.push_back(of);
  }
  if (largest.empty()) return {};
  std::string out =
      "\n## Every column of the largest crowds\n\nWhat each means: `crowdbench schema --results`.\n\n| column |";
  std::string rule = "|---|";
  for (const MeasurementRow* row : largest) {
    out += fmt::format(" {}, {} agents, {} |", markdown_cell(row->key.representation), count_text(row->key.agents),
                       percent_or_dash(row->key.requested_occupancy));
    rule += "--:|";
  }
  out += fmt::format("\n{}\n", rule);
  for (const Field<MeasurementRow>& field : table<MeasurementRow>().fields) {
    const Column& column = field.column;
    if (column.key || column.point || !column.references.empty()) continue;
    std::string line = fmt::format("| {} |", column.name);
    bool any = false;
    for (const MeasurementRow* row : largest) {
      const std::string text = value_text(column, field.get(*row));
      any = any || text != "–";
      line += fmt::format(" {} |", text);
    }
    if (any) out += line + "\n";
  }
  return out;
}

// Every column of the run, one a line.
std::string provenance(const RunRow& run) {
  std::string out = "\n## Provenance\n\n| column | value |\n|---|---|\n";
  for (const Field<RunRow>& field : table<RunRow>().fields)
    if (!field.column.key && !field.column.bulky)
      out += fmt::format("| {} | {} |\n", field.column.name, value_text(field.column, field.get(run)));
  return out + "\n";
}

// What `tune` found, before anything else.
std::string tunings_markdown(const StoreContents& contents, const std::vector<ScoreDoc>& scores) {
  std::string out;
  for (const TuningRow& row : contents.tunings) {
    const auto source = contents.sources.find(row.run);
    out += fmt::format("# The tuned rule: {}{}\n\n", markdown_cell(row.character),
                       source == contents.sources.end() ? "" : ", " + markdown_cell(source->second));
    for (const std::string& sentence : tuning_sentences(row, scores)) out += markdown_cell(sentence) + "\n\n";
    if (row.switches.empty()) continue;
    out += "| from here on | instead of | pixels tall | metres | 95 % | hysteresis |\n|---|---|--:|--:|---|--:|\n";
    for (const TunedSwitchRow& one : row.switches)
      out += fmt::format("| {} | {} | {:.1f} | {:.1f} | {} | {:.1f} % |\n", markdown_cell(one.to),
                         markdown_cell(one.from), one.height_px, one.depth, certainty_text(one), 100 * one.hysteresis);
    out += "\n";
    if (row.representation) out += fmt::format("Draws as `{}`\n\n", *row.representation);
  }
  return out;
}

}  // namespace

std::string report_markdown(const StoreContents& contents, const std::string& source,
                            const std::vector<ScoreDoc>& scores) {
  const std::vector<Scene> scenes = scenes_of(contents, scores);
  if (scenes.empty() && contents.tunings.empty())
    throw Error(source, "holds no measurement and no tuned rule", "run `crowdbench bench --out` or `tune --db` first");
  const SweepSettings all_settings(contents);
  std::string out = tunings_markdown(contents, scores) + side_markdown(side_by_side(scenes));
  const auto add = [&]<typename... Args>(fmt::format_string<Args...> format, Args&&... args) {
    fmt::format_to(std::back_inserter(out), format, std::forward<Args>(args)...);
  };
  for (const Scene& scene : scenes) {
    const RunRow& run = *scene.run;
    const std::string& metric = run.headline;
    const std::string settings = all_settings.of_scene(scene);
    add("# {}, {} × {} pixels, scenario “{}”{}\n\n", markdown_cell(scene.character), scene.width, scene.height,
        markdown_cell(run.scenario_name),
        (settings.empty() ? "" : ", " + markdown_cell(settings)) +
            (scene.source.empty() ? "" : ", of " + markdown_cell(scene.source)));
    if (const auto notice = void_notice(scene)) add("**{}**\n\n", markdown_cell(*notice));
    for (const std::string& sentence : answer(scene)) add("{}\n\n", markdown_cell(sentence));
    if (run.software)
      out +=
          "**Drawn by a software rasteriser**: times compare representations with each other on this machine and say "
          "nothing about a GPU.\n\n";
    add("Median {} of a finished frame with its 95 % interval.\n\n", metric_title(metric));
    out +=
        "| representation | agents | occupancy | time | interval | wall clock | times as fast | interval | frames | "
        "status |\n|---|--:|--:|--:|--:|--:|--:|--:|--:|---|\n";
    for (const double occupancy : scene.occupancies)
      for (const uint32_t agents : scene.agents)
        for (const std::string& name : scene.representations) {
          const MeasurementRow* row = scene.find(name, agents, occupancy);
          if (row == nullptr) continue;
          const auto& time = time_of(*row, metric);
          const RatioRow* ratio = scene.ratio("speed", name, agents, occupancy, metric);
          add("| {} | {} | {} | {} | {} | {} | {} | {} | {} | {}{} |\n", markdown_cell(name), count_text(agents),
              percent_or_dash(occupancy), time ? time_text(time->median) : "–",
              time ? time_text(time->low) + " to " + time_text(time->high) : "–",
              row->frame_ns ? time_text(row->frame_ns->median) : "–", ratio ? factor_text(ratio->ratio) + "×" : "–",
              ratio ? factor_text(ratio->low) + " to " + factor_text(ratio->high) : "–", row->rounds,
              status_name(row->status), row->reason.empty() ? "" : ": " + markdown_cell(row->reason));
        }
    const auto lines = crossovers_of(scene, metric);
    if (!lines.empty()) {
      out += "\n## Which is the cheaper one\n\n| pair | occupancy | by the paired ratios |\n|---|--:|---|\n";
      for (const CrossoverLine& line : lines)
        add("| {} and {} | {} | {} |\n", markdown_cell(line.first), markdown_cell(line.second),
            percent_or_dash(line.occupancy), markdown_cell(crossover_text(line)));
    }
    out += scores_markdown(scene) + largest_crowds(scene) + provenance(run);
  }
  for (const UndrawnPoints& one : undrawn_points(contents)) {
    add("{} of the plan {} not drawn ({}: {}):\n\n", counted(one.count, "point", "points"),
        one.count == 1 ? "was" : "were", one.state, markdown_cell(one.reason));
    for (const std::string& point : one.some) add("- {}\n", markdown_cell(point));
    if (one.count > one.some.size()) add("- {} more\n", count_text(one.count - one.some.size()));
    out += "\n";
  }
  return out;
}

std::string results_csv(const StoreContents& contents) {
  const auto runs = runs_by_id(contents);
  Csv csv;
  csv.add_names<MeasurementRow>();
  csv.add_names<RunRow>(false);
  csv.end_record();
  for (const MeasurementRow& row : contents.measurements) {
    const auto run = runs.find(row.run);
    if (run == runs.end()) continue;
    csv.add(row);
    csv.add(*run->second, false);
    csv.end_record();
  }
  return csv.take();
}

std::string scores_csv(const StoreContents& contents) {
  const auto runs = runs_by_id(contents);
  Csv csv;
  csv.add_names<ComparisonRow>();
  csv.add_names<ScoreRow>();
  csv.add_names<RunRow>(false);
  csv.end_record();
  for (const ComparisonRow& row : contents.comparisons) {
    const auto run = runs.find(row.run);
    if (run == runs.end()) continue;
    for (const ScoreRow& score : row.scores) {
      csv.add(row);
      csv.add(score);
      csv.add(*run->second, false);
      csv.end_record();
    }
  }
  return csv.take();
}

std::string results_json(const StoreContents& contents, const std::vector<ScoreDoc>& docs) {
  Json all = Json::object();
  for_each_table([&]<typename Row>(const Table<Row>& table) {
    if (table.rows == nullptr || has_bytes(table.description)) return;
    Json& rows = all[table.description.rows] = Json::array();
    for (const Row& row : contents.*table.rows) rows.push_back(row_json(row));
  });
  for (const ScoreDoc& doc : docs)
    all["scores"].push_back({{"name", doc.name},
                             {"title", doc.title},
                             {"unit", doc.unit},
                             {"better", doc.higher_is_better ? "higher" : "lower"},
                             {"equal", doc.best ? number(*doc.best) : Json(nullptr)},
                             {"computes", doc.computes}});
  return all.dump(2) + "\n";
}

namespace {

// The machine, by google-benchmark's names where it has one, and all else that the run says.
Json benchmark_context(const RunRow& run) {
  Json context = {{"date", run.started}, {"executable", "crowdbench"}, {"json_schema_version", 1}};
  if (run.cpu_threads > 0) context["num_cpus"] = run.cpu_threads;
  if (run.cpu_mhz) context["mhz_per_cpu"] = std::llround(*run.cpu_mhz);
  if (run.cpu_scaling_enabled) context["cpu_scaling_enabled"] = *run.cpu_scaling_enabled;
  for (const Field<RunRow>& field : table<RunRow>().fields) {
    const Json value = json_of(field.get(run));
    if (!field.column.key && !field.column.bulky && !value.is_null())
      context["crowdbench_" + field.column.name] = value;
  }
  return context;
}

// User counters: every number that may be absent and is here. Times are the entry's own.
Json benchmark_counters(const MeasurementRow& row) {
  Json counters = Json::object();
  for (const Field<MeasurementRow>& field : table<MeasurementRow>().fields) {
    const Json value = json_of(field.get(row));
    if (field.column.optional && field.column.unit != "ns" && value.is_number()) counters[field.column.name] = value;
  }
  return counters;
}

// A measurement among the benchmarks: a family is a representation.
struct Benchmark {
  const MeasurementRow& row;
  std::string run_name;
  int family = 0, instance = 0;

  Json entry(const std::string& name, const char* type) const {
    return {{"name", name},         {"family_index", family}, {"per_family_instance_index", instance},
            {"run_name", run_name}, {"run_type", type},       {"repetitions", row.samples.size()},
            {"threads", 1}};
  }
  std::string status() const { return fmt::format("{}: {}", status_name(row.status), row.reason); }
};

Json untimed_entry(const Benchmark& benchmark) {
  Json json = benchmark.entry(benchmark.run_name, "iteration");
  json["repetition_index"] = 0;
  json["error_occurred"] = true;
  json["error_message"] = benchmark.status();
  json["iterations"] = 0;
  json["real_time"] = 0;
  json["cpu_time"] = 0;
  json["time_unit"] = "ns";
  return json;
}

Json sample_entry(const Benchmark& benchmark, const SampleRow& sample, const Json& counters) {
  Json json = benchmark.entry(benchmark.run_name, "iteration");
  json["repetition_index"] = sample.round;
  json["iterations"] = 1;
  json["real_time"] = sample.frame_ns;
  json["cpu_time"] = sample.cpu_ns;
  json["time_unit"] = "ns";
  if (benchmark.row.status != Status::valid) json["label"] = benchmark.status();
  if (sample.gpu_ns) json["gpu_ns"] = *sample.gpu_ns;
  json.update(counters);
  return json;
}

void add_aggregates(const Benchmark& benchmark, const Json& counters, Json& benchmarks) {
  std::vector<double> real;
  std::vector<double> cpu;
  for (const SampleRow& sample : benchmark.row.samples) {
    real.push_back(static_cast<double>(sample.frame_ns));
    cpu.push_back(static_cast<double>(sample.cpu_ns));
  }
  const auto add = [&](const char* name, double real_time, double cpu_time) {
    Json json = benchmark.entry(benchmark.run_name + "_" + name, "aggregate");
    json["aggregate_name"] = name;
    json["aggregate_unit"] = "time";
    json["iterations"] = real.size();
    json["real_time"] = real_time;
    json["cpu_time"] = cpu_time;
    json["time_unit"] = "ns";
    json.update(counters);
    benchmarks.push_back(std::move(json));
  };
  add("mean", mean_of(real), mean_of(cpu));
  add("median", median(real), median(cpu));
  // One sample has no deviation, and 0 would be a wrong one.
  if (const auto spread = deviation(real); spread) add("stddev", *spread, *deviation(cpu));
  constexpr std::pair<const char*, double> kQuantiles[] = {{"p05", 0.05}, {"p95", 0.95}, {"p99", 0.99}};
  for (const auto& [name, q] : kQuantiles) add(name, quantile(real, q), quantile(cpu, q));
}

}  // namespace

std::string google_benchmark_json(const StoreContents& contents) {
  Json benchmarks = Json::array();
  std::map<std::string, int> family;
  std::map<std::string, int> instances;
  for (const MeasurementRow& row : contents.measurements) {
    const std::string& representation = row.key.representation;
    const Benchmark benchmark{row, point_path(row.key),
                              family.try_emplace(representation, static_cast<int>(family.size())).first->second,
                              instances[representation]++};
    if (row.samples.empty()) {
      benchmarks.push_back(untimed_entry(benchmark));
      continue;
    }
    const Json counters = benchmark_counters(row);
    for (const SampleRow& sample : row.samples) benchmarks.push_back(sample_entry(benchmark, sample, counters));
    add_aggregates(benchmark, counters, benchmarks);
  }
  const Json all = {{"context", contents.runs.empty() ? Json::object() : benchmark_context(contents.runs.back())},
                    {"benchmarks", benchmarks}};
  return all.dump(2) + "\n";
}

}  // namespace crowdbench::reports
