#include "reports/exports/exports.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>

#include "core/error.h"
#include "core/statistics.h"
#include "reports/model/answer.h"
#include "reports/model/crossovers.h"
#include "reports/model/number_text.h"
#include "reports/model/scores.h"

namespace crowdbench::reports {
namespace {

using Json = nlohmann::ordered_json;

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
template <typename T>
Json maybe(const std::optional<T>& value) {
  if (!value) return nullptr;
  if constexpr (std::is_floating_point_v<T>) return number(*value);
  return *value;
}

void put_time(Json& row, const std::string& name, const std::optional<TimeSummary>& time) {
  const auto field = [&](const char* suffix, double TimeSummary::*member) {
    row[name + suffix] = time ? Json((*time).*member) : Json(nullptr);
  };
  field("", &TimeSummary::median);
  field("_low", &TimeSummary::low);
  field("_high", &TimeSummary::high);
  field("_p05", &TimeSummary::p05);
  field("_p95", &TimeSummary::p95);
  field("_p99", &TimeSummary::p99);
}

// The columns of the CSV and the JSON alike, in order.
Json measurement_json(const MeasurementRow& row) {
  Json json = {{"id", row.id},
               {"run", row.run},
               {"representation", row.key.representation},
               {"character", row.key.character},
               {"agents", row.key.agents},
               {"width_px", row.key.width},
               {"height_px", row.key.height},
               {"requested_occupancy", row.key.requested_occupancy},
               {"status", status_name(row.status)},
               {"reason", row.reason},
               {"reference", row.reference},
               {"achieved_occupancy", maybe(row.achieved_occupancy)},
               {"covered_px", maybe(row.covered_px)},
               {"reference_px", maybe(row.reference_px)},
               {"moved_px", maybe(row.moved_px)},
               {"touched_px", maybe(row.touched_px)},
               {"agents_wholly", maybe(row.agents_wholly)},
               {"agents_partly", maybe(row.agents_partly)},
               {"agents_off", maybe(row.agents_off)},
               {"triangles_per_agent", maybe(row.triangles_per_agent)},
               {"rounds", row.rounds},
               {"warmup_frames", row.warmup_frames},
               {"settled", row.settled}};
  put_time(json, "frame_ns", row.frame_ns);
  put_time(json, "cpu_ns", row.cpu_ns);
  put_time(json, "main_cpu_ns", row.main_cpu_ns);
  put_time(json, "gpu_ns", row.gpu_ns);
  json["low_1_percent_fps"] = maybe(row.low_1_percent_fps);
  json["vertices_shaded"] = maybe(row.vertices_shaded);
  json["primitives"] = maybe(row.primitives);
  json["fragments"] = maybe(row.fragments);
  json["samples_passed"] = maybe(row.samples_passed);
  json["texture_bytes"] = maybe(row.texture_bytes);
  json["buffer_bytes"] = maybe(row.buffer_bytes);
  json["upload_bytes_per_frame"] = maybe(row.upload_bytes_per_frame);
  json["disk_bytes"] = maybe(row.disk_bytes);
  json["shared_bytes"] = maybe(row.shared_bytes);
  json["bake_seconds"] = maybe(row.bake_seconds);
  json["bake_cached"] = maybe(row.bake_cached);
  return json;
}

Json run_json(const RunRow& run) {
  return {{"id", run.id},
          {"command", run.command},
          {"arguments", run.arguments},
          {"started", run.started},
          {"version", run.version},
          {"revision", run.revision},
          {"scenario_name", run.scenario_name},
          {"scenario", run.scenario},
          {"scenario_hash", run.scenario_hash},
          {"seed", run.seed},
          {"gl_vendor", run.gl_vendor},
          {"gl_renderer", run.gl_renderer},
          {"gl_version", run.gl_version},
          {"software", run.software},
          {"headline", run.headline},
          {"cpu_model", run.cpu_model},
          {"cpu_threads", run.cpu_threads},
          {"os", run.os},
          {"timer_cost_ns", run.timer_cost_ns}};
}

std::string csv_field(const Json& value) {
  if (value.is_null()) return {};
  if (!value.is_string()) return value.dump();
  const auto& text = value.get_ref<const std::string&>();
  if (text.find_first_of(",\"\r\n") == std::string::npos) return text;
  std::string quoted(1, '"');
  for (const char c : text) {
    if (c == '"') quoted += '"';
    quoted += c;
  }
  quoted += '"';
  return quoted;
}

// "|" would end a cell of a Markdown table, "<" could open HTML.
std::string cell(const std::string& text) {
  std::string out;
  for (const char c : text) {
    if (c == '|')
      out += "\\|";
    else if (c == '<')
      out += "&lt;";
    else
      out += c == '\n' || c == '\r' ? ' ' : c;
  }
  return out;
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

}  // namespace

std::string report_markdown(const StoreContents& contents, const std::string& source) {
  const std::vector<Scene> scenes = scenes_of(contents);
  if (scenes.empty()) throw Error(source, "holds no measurement", "run `crowdbench bench --out` first");
  std::string out;
  const auto add = [&]<typename... Args>(fmt::format_string<Args...> format, Args&&... args) {
    fmt::format_to(std::back_inserter(out), format, std::forward<Args>(args)...);
  };
  for (const Scene& scene : scenes) {
    const RunRow& run = *scene.run;
    const std::string& metric = run.headline;
    add("# {}, {} × {} pixels, scenario “{}”\n\n", cell(scene.character), scene.width, scene.height,
        cell(run.scenario_name));
    if (const auto notice = void_notice(scene)) add("**{}**\n\n", cell(*notice));
    for (const std::string& sentence : answer(scene)) add("{}\n\n", cell(sentence));
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
          add("| {} | {} | {} | {} | {} | {} | {} | {} | {} | {}{} |\n", cell(name), count_text(agents),
              percent_or_dash(occupancy), time ? time_text(time->median) : "–",
              time ? time_text(time->low) + " to " + time_text(time->high) : "–",
              row->frame_ns ? time_text(row->frame_ns->median) : "–", ratio ? factor_text(ratio->ratio) + "×" : "–",
              ratio ? factor_text(ratio->low) + " to " + factor_text(ratio->high) : "–", row->rounds,
              status_name(row->status), row->reason.empty() ? "" : ": " + cell(row->reason));
        }
    const auto lines = crossovers_of(scene, metric);
    if (!lines.empty()) {
      out += "\n## Where the curves cross\n\n| pair | occupancy | at | cheaper |\n|---|--:|--:|---|\n";
      for (const CrossoverLine& line : lines)
        add("| {} and {} | {} | {} | {} |\n", cell(line.first), cell(line.second), percent_or_dash(line.occupancy),
            line.agents ? fmt::format("{:.0f} agents", *line.agents) : "–",
            line.agents ? fmt::format("{} below, {} beyond", cell(line.cheaper_below), cell(line.cheaper_beyond))
                        : fmt::format("{} from {} to {} agents", cell(line.cheaper_beyond), count_text(line.from),
                                      count_text(line.to)));
    }
    const auto overlap = scores_by_height(scene, "silhouette_iou");
    if (!overlap.empty()) {
      const auto ssim = scores_by_height(scene, "ssim");
      out +=
          "\n## Difference of single agents\n\n| representation | height, px | views | silhouette IoU | worst | SSIM "
          "|\n"
          "|---|--:|--:|--:|--:|--:|\n";
      for (const ScoreByHeight& row : overlap) {
        const auto similar = std::find_if(ssim.begin(), ssim.end(), [&](const ScoreByHeight& s) {
          return s.representation == row.representation && s.height_px == row.height_px;
        });
        add("| {} | {:.0f} | {} | {:.3f} | {:.3f} | {} |\n", cell(row.representation), row.height_px, row.views,
            row.mean, row.least, similar == ssim.end() ? "–" : fmt::format("{:.3f}", similar->mean));
      }
    }
    out += "\n## Memory\n\n| representation | textures | buffers | upload a frame | shared |\n|---|--:|--:|--:|--:|\n";
    for (const std::string& name : scene.representations) {
      const MeasurementRow* largest = nullptr;
      for (const MeasurementRow* row : scene.rows)
        if (row->key.representation == name && is_timed(*row) &&
            (largest == nullptr || row->key.agents > largest->key.agents))
          largest = row;
      const auto bytes = [](const std::optional<uint64_t>& value) { return value ? bytes_text(*value) : "–"; };
      if (largest != nullptr)
        add("| {} | {} | {} | {} | {} |\n", cell(name), bytes(largest->texture_bytes), bytes(largest->buffer_bytes),
            bytes(largest->upload_bytes_per_frame), bytes(largest->shared_bytes));
    }
    add("\n{}, {}; OpenGL {}; crowdbench {} ({}); scenario SHA-256 {}; seed {}; {}\n\n", cell(run.cpu_model),
        cell(run.gl_renderer), cell(run.gl_version), run.version, run.revision, run.scenario_hash, run.seed,
        run.started);
  }
  return out;
}

std::string results_csv(const StoreContents& contents) {
  const auto runs = runs_by_id(contents);
  std::string out;
  bool header = true;
  for (const MeasurementRow& row : contents.measurements) {
    Json json = measurement_json(row);
    const auto run = runs.find(row.run);
    if (run == runs.end()) continue;
    const Json provenance = run_json(*run->second);
    for (const auto& [key, value] : provenance.items())
      if (key != "id" && key != "scenario") json[key] = value;
    const auto line = [&](const auto& field) {
      bool first = true;
      for (const auto& [key, value] : json.items()) {
        if (!first) out += ',';
        out += field(key, value);
        first = false;
      }
      out += "\r\n";
    };
    if (header) line([](const std::string& key, const Json&) { return key; });
    header = false;
    line([](const std::string&, const Json& value) { return csv_field(value); });
  }
  return out;
}

std::string results_json(const StoreContents& contents) {
  Json runs = Json::array();
  for (const RunRow& run : contents.runs) runs.push_back(run_json(run));
  Json measurements = Json::array();
  for (const MeasurementRow& row : contents.measurements) {
    Json json = measurement_json(row);
    if (!row.samples.empty()) {
      Json samples = Json::array();
      for (const SampleRow& sample : row.samples)
        samples.push_back({{"round", sample.round},
                           {"tick", sample.tick},
                           {"frame_ns", sample.frame_ns},
                           {"cpu_ns", sample.cpu_ns},
                           {"main_cpu_ns", sample.main_cpu_ns},
                           {"gpu_ns", maybe(sample.gpu_ns)}});
      json["samples"] = std::move(samples);
    }
    measurements.push_back(std::move(json));
  }
  Json ratios = Json::array();
  for (const RatioRow& row : contents.ratios)
    ratios.push_back({{"run", row.run},
                      {"kind", row.kind},
                      {"representation", row.of.representation},
                      {"character", row.of.character},
                      {"agents", row.of.agents},
                      {"width_px", row.of.width},
                      {"height_px", row.of.height},
                      {"requested_occupancy", row.of.requested_occupancy},
                      {"to", row.to},
                      {"metric", row.metric},
                      {"ratio", row.ratio},
                      {"ratio_low", row.low},
                      {"ratio_high", row.high},
                      {"pairs", row.pairs}});
  Json comparisons = Json::array();
  for (const ComparisonRow& row : contents.comparisons) {
    Json scores = Json::object();
    Json reasons = Json::object();
    for (const ScoreRow& score : row.scores) {
      scores[score.name] = maybe(score.value);
      if (!score.reason.empty()) reasons[score.name] = score.reason;
    }
    comparisons.push_back({{"run", row.run},
                           {"kind", row.kind},
                           {"representation", row.representation},
                           {"reference", row.reference},
                           {"character", row.character},
                           {"agents", row.agents},
                           {"requested_occupancy", row.requested_occupancy},
                           {"tick", row.tick},
                           {"height_px", maybe(row.height_px)},
                           {"azimuth_deg", maybe(row.azimuth_deg)},
                           {"elevation_deg", maybe(row.elevation_deg)},
                           {"clip", row.clip},
                           {"time_s", maybe(row.time)},
                           {"scores", scores},
                           {"reasons", reasons}});
  }
  const Json all = {{"runs", runs}, {"measurements", measurements}, {"ratios", ratios}, {"comparisons", comparisons}};
  return all.dump(2) + "\n";
}

std::string google_benchmark_json(const StoreContents& contents) {
  const auto runs = runs_by_id(contents);
  Json context = Json::object();
  if (!contents.runs.empty()) {
    const RunRow& run = contents.runs.back();
    context = {{"date", run.started},         {"host_name", ""},           {"executable", "crowdbench"},
               {"num_cpus", run.cpu_threads}, {"mhz_per_cpu", 0},          {"cpu_scaling_enabled", false},
               {"caches", Json::array()},     {"load_avg", Json::array()}, {"library_build_type", "release"},
               {"json_schema_version", 1}};
    const Json provenance = run_json(run);
    for (const auto& [key, value] : provenance.items())
      if (key != "id" && key != "scenario") context["crowdbench_" + key] = value;
  }
  Json benchmarks = Json::array();
  std::map<std::string, int> family;
  std::map<std::string, int> instances;
  for (const MeasurementRow& row : contents.measurements) {
    const std::string run_name =
        fmt::format("crowd/representation:{}/character:{}/agents:{}/occupancy:{}/{}x{}", row.key.representation,
                    row.key.character, row.key.agents, row.key.requested_occupancy, row.key.width, row.key.height);
    const int family_index = family.try_emplace(row.key.representation, static_cast<int>(family.size())).first->second;
    const int instance = instances[row.key.representation]++;
    Json counters = Json::object();
    const auto counter = [&](const char* name, const auto& value) {
      if (value) counters[name] = *value;
    };
    counter("covered_px", row.covered_px);
    counter("achieved_occupancy", row.achieved_occupancy);
    counter("vertices_shaded", row.vertices_shaded);
    counter("primitives", row.primitives);
    counter("fragments", row.fragments);
    counter("samples_passed", row.samples_passed);
    counter("texture_bytes", row.texture_bytes);
    counter("buffer_bytes", row.buffer_bytes);
    counter("upload_bytes_per_frame", row.upload_bytes_per_frame);
    const auto entry = [&](const std::string& name, const char* type) {
      return Json{{"name", name},
                  {"family_index", family_index},
                  {"per_family_instance_index", instance},
                  {"run_name", run_name},
                  {"run_type", type},
                  {"repetitions", row.samples.size()},
                  {"threads", 1}};
    };
    if (row.samples.empty()) {
      Json json = entry(run_name, "iteration");
      json["repetition_index"] = 0;
      json["error_occurred"] = true;
      json["error_message"] = fmt::format("{}: {}", status_name(row.status), row.reason);
      json["iterations"] = 0;
      json["real_time"] = 0;
      json["cpu_time"] = 0;
      json["time_unit"] = "ns";
      benchmarks.push_back(std::move(json));
      continue;
    }
    std::vector<double> real;
    std::vector<double> cpu;
    for (const SampleRow& sample : row.samples) {
      Json json = entry(run_name, "iteration");
      json["repetition_index"] = sample.round;
      json["iterations"] = 1;
      json["real_time"] = sample.frame_ns;
      json["cpu_time"] = sample.cpu_ns;
      json["time_unit"] = "ns";
      if (row.status != Status::valid) json["label"] = fmt::format("{}: {}", status_name(row.status), row.reason);
      if (sample.gpu_ns) json["gpu_ns"] = *sample.gpu_ns;
      json.update(counters);
      benchmarks.push_back(std::move(json));
      real.push_back(static_cast<double>(sample.frame_ns));
      cpu.push_back(static_cast<double>(sample.cpu_ns));
    }
    const auto aggregate = [&](const char* name, double real_time, double cpu_time) {
      Json json = entry(run_name + "_" + name, "aggregate");
      json["aggregate_name"] = name;
      json["aggregate_unit"] = "time";
      json["iterations"] = row.samples.size();
      json["real_time"] = real_time;
      json["cpu_time"] = cpu_time;
      json["time_unit"] = "ns";
      json.update(counters);
      benchmarks.push_back(std::move(json));
    };
    aggregate("mean", mean_of(real), mean_of(cpu));
    aggregate("median", median(real), median(cpu));
    // One sample has no deviation, and 0 would be a wrong one.
    if (const auto spread = deviation(real); spread) aggregate("stddev", *spread, *deviation(cpu));
    for (const auto& [name, q] : {std::pair{"p05", 0.05}, std::pair{"p95", 0.95}, std::pair{"p99", 0.99}})
      aggregate(name, quantile(real, q), quantile(cpu, q));
  }
  const Json all = {{"context", context}, {"benchmarks", benchmarks}};
  return all.dump(2) + "\n";
}

}  // namespace crowdbench::reports
