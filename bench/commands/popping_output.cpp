#include "bench/commands/popping_output.h"

#include <fmt/format.h>

#include <algorithm>

#include "bench/commands/scene_options.h"
#include "bench/commands/score_json.h"
#include "core/counted.h"
#include "core/files.h"
#include "core/image_io.h"

namespace crowdbench::bench {
namespace {

using metrics::PopScore;

const char* tail_name(const PopScore& score) {
  return score.direction == metrics::Direction::higher_is_better ? "p05" : "p95";
}

// The scores that have room in a terminal's table of settings.
constexpr size_t kTableScores = 3;

Json values_json(const Switch& of) {
  Json out = Json::object();
  const auto scores = metrics::pop_scores();
  for (size_t s = 0; s < scores.size(); ++s)
    out[std::string(scores[s].name)] = json_number(of.pixels > 0 ? of.values[s] : std::nullopt);
  return out;
}

Json switch_json(const PoppingRun& run, const Switch& of) {
  return {{"agent", of.id - 1},
          {"character", of.character},
          {"tick", of.tick},
          {"frames", of.steps},
          {"complete", of.complete},
          {"from", run.result.components[of.from]},
          {"to", run.result.components[of.to]},
          {"distance_m", of.distance},
          {"pixels", of.pixels},
          {"worst_tick", of.worst_tick},
          {"scores", values_json(of)}};
}

Json run_json(const PoppingRun& run) {
  Json setting = Json::object();
  for (const auto& [key, value] : run.setting) setting[key] = value;
  Json quantiles = Json::object();
  const auto scores = metrics::pop_scores();
  for (size_t s = 0; s < scores.size(); ++s) {
    const std::optional<PopQuantiles> of = pop_quantiles(run.result.switches, s);
    quantiles[std::string(scores[s].name)] =
        of ? Json({{"median", of->median}, {tail_name(scores[s]), of->tail}, {"worst", of->worst}}) : Json(nullptr);
  }
  Json list = Json::array();
  for (const Switch& of : run.result.switches) list.push_back(switch_json(run, of));
  return {{"representation", run.representation.text()},
          {"setting", setting},
          {"components", run.result.components},
          {"agents_in_view", run.result.agents_in_view},
          {"drawings", run.result.drawings},
          {"switches", run.result.switches.size()},
          {"seen", seen_switches(run.result.switches)},
          {"quantiles", quantiles},
          {"list", list}};
}

void print_list(const PoppingReport& report, const PoppingRun& run) {
  const auto scores = metrics::pop_scores();
  for (size_t k = 0; k < run.result.components.size(); ++k) fmt::print("  {} = {}\n", k, run.result.components[k]);
  const size_t shown = std::min(report.rows, run.result.switches.size());
  if (shown == 0) return;
  fmt::print("\n{:>7} {:>7} {:>6} {:>7} {:>11} {:>7}", "tick", "agent", "switch", "frames", "distance m", "pixels");
  for (const PopScore& score : scores) fmt::print(" {:>9}", score.column);
  fmt::print("\n");
  for (size_t i = 0; i < shown; ++i) {
    const Switch& of = run.result.switches[i];
    fmt::print("{:>7} {:>7} {:>6} {:>7} {:>11.2f} {:>7}", of.tick, of.id - 1, fmt::format("{}>{}", of.from, of.to),
               fmt::format("{}{}", of.steps, of.complete ? "" : "+"), of.distance, of.pixels);
    for (size_t s = 0; s < scores.size(); ++s)
      fmt::print(" {:>9}", metrics::value_text(scores[s], of.pixels > 0 ? of.values[s] : std::nullopt));
    fmt::print("\n");
  }
  if (shown < run.result.switches.size())
    fmt::print("  ... and {} that are less visible\n", run.result.switches.size() - shown);
}

std::string setting_text(const PoppingRun& run) {
  std::string text;
  for (const auto& [key, value] : run.setting) text += fmt::format("{}{}={}", text.empty() ? "" : " ", key, value);
  return text.empty() ? "all" : text;
}

void print_settings(const PoppingReport& report) {
  const auto scores = metrics::pop_scores().first(kTableScores);
  size_t width = 7;
  for (const PoppingRun& run : report.runs) width = std::max(width, setting_text(run).size());
  fmt::print("\n{:<{}} {:>8} {:>6}", "setting", width, "switches", "seen");
  for (const PopScore& score : scores)
    fmt::print(" | {:>9} {:>9} {:>9}", fmt::format("{} p50", score.column), tail_name(score), "worst");
  fmt::print("\n");
  for (const PoppingRun& run : report.runs) {
    fmt::print("{:<{}} {:>8} {:>6}", setting_text(run), width, run.result.switches.size(),
               seen_switches(run.result.switches));
    for (size_t s = 0; s < scores.size(); ++s) {
      const std::optional<PopQuantiles> of = pop_quantiles(run.result.switches, s);
      const auto text = [&](double PopQuantiles::*member) {
        return metrics::value_text(scores[s], of ? std::optional((*of).*member) : std::nullopt);
      };
      fmt::print(" | {:>9} {:>9} {:>9}", text(&PopQuantiles::median), text(&PopQuantiles::tail),
                 text(&PopQuantiles::worst));
    }
    fmt::print("\n");
  }
}

}  // namespace

Json popping_json(const PoppingReport& report) {
  const PoppingRequest& request = report.request;
  Json out = {{"scenario", report.scenario.name},
              {"cast", report.cast},
              {"seed", report.scenario.seed},
              {"width", report.scenario.width},
              {"height", report.scenario.height},
              {"renderer", report.renderer},
              {"ticks", {request.tick, request.tick + request.frames - 1}},
              {"fps", request.view.fps}};
  out["display"] = display_json(report.display);
  out["scores"] = out["runs"] = Json::array();
  for (const PopScore& score : metrics::pop_scores())
    out["scores"].push_back({{"name", score.name},
                             {"title", score.title},
                             {"unit", score.unit},
                             {"equal", score.equal},
                             {"computes", score.computes}});
  for (const PoppingRun& run : report.runs) out["runs"].push_back(run_json(run));
  out["pictures"] = report.pictures;
  return out;
}

void print_popping(const PoppingReport& report) {
  const PoppingRequest& request = report.request;
  fmt::print("{} of {}, {} x {} pixels, ticks {} to {} at {:g} frames a second; {}\n",
             counted(report.scenario.crowd.agents, "agent", "agents"), report.cast, report.scenario.width,
             report.scenario.height, request.tick, request.tick + request.frames - 1, request.view.fps,
             report.renderer);
  if (report.runs.size() == 1) {
    fmt::print("{}: {}\n", report.runs[0].representation.text(),
               counted(report.runs[0].result.switches.size(), "switch", "switches"));
    print_list(report, report.runs[0]);
  }
  print_settings(report);
  fmt::print("\n");
  for (const PopScore& score : metrics::pop_scores())
    fmt::print("  {:<9} {}{}{}; {:g} = no pop\n", score.column, score.title, score.unit.empty() ? "" : ", ", score.unit,
               score.equal);
  fmt::print("  display   {}\n", display_line(report.display));
  for (const std::string& file : report.pictures) fmt::print("  wrote {}\n", file);
}

std::vector<std::string> write_pop_pictures(const std::filesystem::path& folder, const PoppingReport& report) {
  make_folder(folder);
  std::vector<std::string> files;
  for (size_t r = 0; r < report.runs.size(); ++r) {
    const PoppingRun& run = report.runs[r];
    size_t number = 0;
    for (const Switch& of : run.result.switches) {
      if (!of.pictures.kept()) continue;
      const std::string name =
          fmt::format("{}{:02}_tick{}_agent{}", report.runs.size() > 1 ? fmt::format("run{:02}_", r) : std::string(),
                      ++number, of.worst_tick, of.id - 1);
      ImageMetadata metadata = picture_metadata(report.scenario, run.representation.text());
      metadata["tick"] = std::to_string(of.worst_tick);
      const metrics::Box& box = of.pictures.box;
      metadata["box"] = fmt::format("{},{},{},{}", box.x, box.y, box.width, box.height);
      for (const auto& [ending, image] :
           {std::pair("before", &of.pictures.before), std::pair("with", &of.pictures.with),
            std::pair("without", &of.pictures.without)}) {
        const std::filesystem::path file = folder / fmt::format("{}_{}.png", name, ending);
        write_png(file, *image, metadata);
        files.push_back(file.string());
      }
    }
  }
  return files;
}

Json jumps_json(const JumpReport& report) {
  Json out = {{"sequence", report.sequence},
              {"frames", report.frames},
              {"found", Json::array()},
              {"least_jump", metrics::kLeastJump},
              {"times_median", metrics::kJumpTimesMedian},
              {"jumps", Json::array()}};
  for (const metrics::Jump& jump : report.jumps) {
    if (jump.found) out["found"].push_back(jump.frame);
    out["jumps"].push_back({{"frame", jump.frame},
                            {"change", jump.change},
                            {"left", jump.left},
                            {"jump", jump.jump},
                            {"found", jump.found}});
  }
  return out;
}

void print_jumps(const JumpReport& report) {
  fmt::print("{}: {} frames; luma in code values\n\n{:>7} {:>9} {:>16} {:>9}\n", report.sequence, report.frames,
             "frame", "change", "beyond motion", "jump");
  size_t found = 0;
  for (const metrics::Jump& jump : report.jumps) {
    fmt::print("{:>7} {:>9.3f} {:>16.3f} {:>9.3f}{}\n", jump.frame, jump.change, jump.left, jump.jump,
               jump.found ? "  pops" : "");
    found += jump.found ? 1 : 0;
  }
  fmt::print("\n{} of {} frames pop: a jump above {:g} code values and {:g} times the median\n", found, report.frames,
             metrics::kLeastJump, metrics::kJumpTimesMedian);
}

}  // namespace crowdbench::bench
